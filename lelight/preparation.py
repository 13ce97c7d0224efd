"""Before light is estimated: plan, nodes, receivers and the base field."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import form_of
from lelight.crowding import require_clear_emitters
from lelight.errors import SceneError
from lelight.estimate.base import BaseField
from lelight.estimate.defect import with_starts
from lelight.estimate.variants import DIRECT_ONLY, VARIANTS, Variant
from lelight.memory import allowed_memory, require_fitting
from lelight.mesh.neighbours import alike
from lelight.mesh.nodes import NodeMesh
from lelight.mesh.patches import patches
from lelight.mesh.probes import Probes, draw_probes
from lelight.mesh.remesh import default_edge
from lelight.metrics.grid import grid_points
from lelight.placement import (
    Placed,
    Site,
    place_nodes,
    solved_base,
    with_shared_clear_share,
    with_shared_known_direct,
)
from lelight.places import Places, further_places
from lelight.plan import ASKED, Decision, Plan, make_plan
from lelight.plancost import no_cost
from lelight.reach import in_channels, reached_materials, seen_sides
from lelight.receivers import Receivers, joined, space_receivers, surface_receivers, with_surface
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas
from lelight.settings import Settings
from lelight.tracing.world import World, build_world

#: Grid points and eyes are few, and figures are taken from each: they sample so many doublings more than
#: nodes.
PLANE_DOUBLINGS, EYE_DOUBLINGS = 2, 6

#: Nodes of one side that a mesh has at the least, over its area and the inverse square of its edge.
LEAST_NODES = 0.5

#: Share of the light that all surfaces together must absorb, by area.
LEAST_ABSORPTION = 1e-3

#: Said of lamps that make a spot on a surface close to them.
SPOTS = Decision(
    "spots of close lamps",
    "left to chains from the lamps, near fields kept small",
    "a lamp is so close to a surface that nearly all it receives falls on a spot; paths find that by chance "
    "only, so light close to edges may be a little low",
)


@dataclass(frozen=True)
class Stage:
    """Scene, mesh and receivers, ready to be lit.

    Attributes
    ----------
    labels : (n_t,) int, patch of each traced triangle
    receivers : nodes first, then the points of all planes, then the eyes, then the probes, then the further places
    grids : points (k, 3) and shape (rows, columns) of each plane
    edge : float, m, of the node mesh
    base : field on which the estimate stands, None where there is none
    probes : points between the nodes
    further : places beside grid points and eyes, in the order of their receivers, the last of all
    neighbours : (n, 7) int, visible nodes around each
    variant : how indirect light is estimated
    """

    world: World
    labels: IntArray
    mesh: NodeMesh
    receivers: Receivers
    grids: tuple[tuple[FloatArray, tuple[int, int]], ...]
    edge: float
    plan: Plan
    base: BaseField | None
    probes: Probes
    further: tuple[Places, ...]
    neighbours: IntArray
    variant: Variant


def prepare(scene: Scene, settings: Settings, executor: Executor, keep: Keeper) -> Stage:
    """Plan, remesh, find the lit sides and the buried nodes, list the receivers."""
    plan = make_plan(scene, method=settings.method, forced=settings)
    labels = patches(scene)
    edge = settings.edge or default_edge(scene) * settings.edge_scale
    _require_room_for_mesh(scene, plan, edge, settings)
    world = build_world(scene, plan.channels)
    require_absorption(scene, world)
    require_clear_emitters(scene, world)
    site = Site(scene, world, labels, settings, executor, keep)
    placed = keep.once("mesh", lambda: place_nodes(site, edge, exchange=plan.indirect), form_of(Placed))
    mesh, lit = placed.mesh, placed.lit
    keep.clock.lap("pilot")
    reached = reached_materials(scene, labels, lit)
    plan = make_plan(scene, method=settings.method, forced=settings, reached=reached)
    world = in_channels(world, scene, plan.channels)
    site = replace(site, world=world)
    grids = tuple(grid_points(plane) for plane in scene.planes)
    probes = draw_probes(mesh, scene.corners, labels, seed=settings.seed)
    further = further_places(scene, grids, world.caster)
    seen, kept = seen_sides(scene, world, mesh, plan)
    degrees = plan.degrees[mesh.materials] * seen[mesh.patches, np.where(mesh.sides > 0, 0, 1)]
    receivers = _receivers(scene, mesh, degrees, grids, probes, further)
    decided = (*plan.decisions, _sides(plan, mesh, lit), *([kept] if kept else []))
    plan = replace(plan, decisions=decided)
    receivers = with_shared_clear_share(site, receivers, "clear share")
    base, variant = None, chosen_variant(plan, settings)
    if variant.on_base:
        base = _base(site, placed, receivers[slice(0, len(mesh))], edge)
        if base.guide is not None:
            receivers = with_shared_known_direct(site, base.guide.leading(receivers), base.guide.sight)
        if base.spots:
            plan = replace(plan, decisions=(*plan.decisions, SPOTS))
    keep.clock.lap("base")
    neighbours = alike(mesh.positions, mesh.normals, left_out=mesh.hidden)
    return Stage(
        world, labels, mesh, receivers, grids, edge, plan, base, probes, further, neighbours, variant
    )


def _require_room_for_mesh(scene: Scene, plan: Plan, edge: float, settings: Settings) -> None:
    """Refuse a mesh that is far too fine for the memory before it is made."""
    nodes = LEAST_NODES * triangle_areas(scene.corners) / edge**2
    detailed = nodes[plan.degrees[scene.triangle_materials] > 0] if plan.angular == "all" else np.zeros(1)
    require_fitting(
        scene.name,
        int(nodes.sum()),
        int(detailed.sum()),
        degree=plan.degree,
        channels=plan.channels,
        edge=edge,
        allowed=allowed_memory(settings.memory),
        triangles=len(scene.triangles),
    )


def chosen_variant(plan: Plan, settings: Settings) -> Variant:
    """Estimator that is asked for, less what the plan leaves out."""
    if not plan.indirect:
        return DIRECT_ONLY
    variant = VARIANTS[settings.estimator]
    if plan.residual or variant.near != "rest":
        return variant
    return VARIANTS["shortened" if variant.on_base else "clamped"]


def _sides(plan: Plan, mesh: NodeMesh, lit: BoolArray) -> Decision:
    value = f"{int(lit.sum())} of {2 * len(lit)} patch sides carry nodes"
    if plan.sides == "both":
        return Decision("sides", value, ASKED, no_cost(f"{len(mesh)} nodes"))
    more = 2.0 * len(lit) / max(int(lit.sum()), 1)
    return Decision("sides", value, "the others receive no light", no_cost(f"both sides x {more:.2g}"))


def _base(site: Site, placed: Placed, nodes: Receivers, edge: float) -> BaseField:
    """Solve the base field, and see what it lacks."""
    base = solved_base(site, placed, edge, "base", nodes=nodes)
    return with_starts(site.world, base, seed=site.settings.seed, executor=site.executor, keep=site.keep)


def require_absorption(scene: Scene, world: World) -> None:
    """Refuse a scene whose surfaces absorb next to nothing: chains in it hardly ever end."""
    albedo = world.reflectances.diffuse_share + world.reflectances.specular_share
    areas = triangle_areas(scene.corners)
    absorbed = 1.0 - float(np.average(albedo[scene.triangle_materials], weights=areas))
    if absorbed < LEAST_ABSORPTION * (1.0 - 1e-9):
        raise SceneError(
            f"{scene.name}: surfaces absorb {absorbed:.2g} of the light, at least {LEAST_ABSORPTION:g} is needed "
            "for an end; lower the reflectances"
        )


def _receivers(
    scene: Scene,
    mesh: NodeMesh,
    degrees: IntArray,
    grids: tuple[tuple[FloatArray, tuple[int, int]], ...],
    probes: Probes,
    further: tuple[Places, ...],
) -> Receivers:
    """Nodes of degrees (n,), then points of all planes, then eyes, then probes, then further places."""
    parts = [surface_receivers(mesh, degrees)]
    for plane, (points, _) in zip(scene.planes, grids, strict=True):
        parts.append(space_receivers(points, _repeated(plane.normal, points), doublings=PLANE_DOUBLINGS))
    for eye in scene.observers:
        parts.append(space_receivers(eye.position[None], eye.direction[None], doublings=EYE_DOUBLINGS))
    parts.append(with_surface(space_receivers(probes.points, probes.normals)))
    parts += [places.receivers() for places in further]
    return joined(parts)


def _repeated(normal: FloatArray, points: FloatArray) -> FloatArray:
    return np.tile(normal, (len(points), 1))
