"""Where nodes lie: on the lit sides of the remeshed surface, refined where that is asked for, none of them buried.

Refining by exchanged light needs a base field; that is solved here for the mesh at hand, whichever it is.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from lelight.adaptation import ROUNDS, ROUNDS_OF_EXCHANGE, bent, bent_by_exchange
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import ARRAY, form_of
from lelight.crowding import crowded, require_room
from lelight.errors import SceneError
from lelight.estimate.base import BaseField, solve_base
from lelight.estimate.direct import with_clear_share
from lelight.estimate.knowndirect import with_known_direct
from lelight.memory import allowed_memory, require_fitting
from lelight.mesh.grading import graded
from lelight.mesh.locate import patch_sides
from lelight.mesh.nodes import NodeMesh, SurfaceMesh, hide, node_mesh
from lelight.mesh.refinement import refine
from lelight.mesh.remesh import remesh
from lelight.pilot import buried, lit_sides, open_sides, stepped_aside, touching
from lelight.receivers import Receivers, node_receivers
from lelight.scene import BoolArray, FloatArray, IntArray, Scene
from lelight.settings import Settings
from lelight.tracing.sight import Shares
from lelight.tracing.world import World

#: Seed of what tells which sides light reaches and which nodes are buried. A side that is lit along its rim only, as
#: those of books that all but touch, is found by chance; with the same chance in every run all have the same nodes.
MESH_SEED = 0
#: Receivers asked at once how much of the emitters they see.
CLEAR_SHARE_CHUNK = 1024
#: Nodes of a coarser mesh for the base field, about, but for what the scene's own triangles ask. The base is a draft:
#: in an office of 115 000 nodes four times fewer for it cost a tenth of variance.
COARSE_BASE_NODES = 1 << 15
#: Such a mesh is worth its making below this share of the nodes there are.
WORTH_COARSENING = 0.5


@dataclass(frozen=True)
class Placed:
    """Nodes, and the sides (n_patches, 2) of patches that receive light."""

    mesh: NodeMesh
    lit: BoolArray


@dataclass(frozen=True)
class Site:
    """What nodes are placed on, how, and by whom.

    Attributes
    ----------
    labels : (n_t,) int, patch of each traced triangle
    """

    scene: Scene
    world: World
    labels: IntArray
    settings: Settings
    executor: Executor
    keep: Keeper


def place_nodes(site: Site, edge: float, *, exchange: bool) -> Placed:
    """Remesh, place nodes, and refine the mesh under them where that is asked for, by exchanged light too or not."""
    scene, labels, keep = site.scene, site.labels, site.keep
    surface = keep.once(
        "mesh/surface",
        lambda: graded(remesh(scene, labels, edge=edge), scene, labels),
        form_of(SurfaceMesh),
    )
    keep.clock.lap("remesh")
    seed, executor = site.settings.seed, site.executor
    if site.settings.sides == "both":
        lit = open_sides(site.world, labels)
    else:
        lit = lit_sides(scene, site.world, labels=labels, seed=MESH_SEED, executor=executor, keep=keep)
    placed = _seen_nodes(site, surface, lit, "buried")
    if placed.mesh.hidden.all():
        raise SceneError(f"{scene.name}: no surface receives light; check where the lamps are and face")
    if not site.settings.adaptive:
        return placed
    unrefined, tolerance = placed, site.settings.target_error
    by_direct = partial(bent, site.world, tolerance=tolerance, labels=labels, seed=seed, executor=executor)
    surface, placed = _refined(site, surface, lit, placed, by_direct, ROUNDS, "bent")
    if not exchange:
        return placed
    by_exchange = partial(
        bent_by_exchange,
        site.world,
        solved_base(site, unrefined, edge, "mesh/base"),
        tolerance=tolerance,
        labels=labels,
        seed=seed,
        executor=executor,
    )
    return _refined(site, surface, lit, placed, by_exchange, ROUNDS_OF_EXCHANGE, "exchange")[1]


def _refined(
    site: Site,
    surface: SurfaceMesh,
    lit: BoolArray,
    placed: Placed,
    asks: Callable[..., BoolArray],
    rounds: int,
    name: str,
) -> tuple[SurfaceMesh, Placed]:
    """Cut the triangles over which light is off, on either side, in rounds, and place nodes anew."""
    for number in range(rounds):
        off = asks(mesh=placed.mesh, keep=site.keep, name=f"mesh/{name} {number}")
        own = [np.flatnonzero(placed.lit[surface.triangle_patches, side]) for side in (0, 1)]
        asked = np.zeros(len(surface.triangles), dtype=np.bool_)
        asked[np.concatenate(own)[off]] = True
        if not asked.any():
            break
        surface = refine(surface, asked, corners=site.world.caster.corners, labels=site.labels)
        placed = _seen_nodes(site, surface, lit, f"buried {name} {number}")
    return surface, placed


def _seen_nodes(site: Site, surface: SurfaceMesh, lit: BoolArray, name: str) -> Placed:
    """Place nodes on the lit sides (n_patches, 2), hide the buried and crowded; a side with no other is not lit."""
    scene, world = site.scene, site.world
    mesh = stepped_aside(world, node_mesh(surface, lit))
    hidden = buried(world, mesh, seed=MESH_SEED, executor=site.executor, keep=site.keep, name=name)
    hidden |= _spared(mesh, touching(world, mesh) & ~hidden, hidden)
    taken = crowded(world, mesh, site.labels)
    require_room(scene, world, hide(mesh, hidden), taken)
    hidden |= taken
    if site.settings.sides == "both":
        return Placed(hide(mesh, hidden), lit)
    seen = np.zeros_like(lit)
    seen[mesh.patches[~hidden], np.where(mesh.sides[~hidden] > 0, 0, 1)] = True
    kept = seen[mesh.patches, np.where(mesh.sides > 0, 0, 1)]
    if kept.all():
        return Placed(hide(mesh, hidden), seen)
    placed = replace(node_mesh(surface, seen), positions=mesh.positions[kept])
    return Placed(hide(placed, hidden[kept]), seen)


def nodes_of_base(nodes: float) -> float:
    """How many nodes the base is solved on where there are so many, but for what the scene's own triangles ask."""
    return COARSE_BASE_NODES if WORTH_COARSENING * nodes > COARSE_BASE_NODES else nodes


def solved_base(
    site: Site, placed: Placed, edge: float, name: str, *, nodes: Receivers | None = None
) -> BaseField:
    """Solve the base field at the nodes, or on a coarser mesh where there are very many; not without memory for it.

    Parameters
    ----------
    nodes : receivers at the nodes that know how much of the emitters they see, where there are such already
    """
    mesh = placed.mesh
    seen = int(np.count_nonzero(~mesh.hidden))
    wanted = nodes_of_base(seen)
    if wanted < seen:
        coarse = edge * (seen / wanted) ** 0.5
        found = site.keep.once(f"{name} mesh", lambda: _coarse_nodes(site, placed, coarse), form_of(NodeMesh))
        if len(found) < len(mesh):
            mesh, nodes = found, None
    require_fitting(
        site.scene.name,
        len(placed.mesh),
        0,
        degree=0,
        channels=site.world.channels,
        edge=edge,
        allowed=allowed_memory(site.settings.memory),
        triangles=len(site.scene.triangles),
        base_nodes=len(mesh),
    )
    if nodes is None:
        nodes = with_shared_clear_share(site, node_receivers(mesh), f"{name} clear share")
    return solve_base(
        site.world,
        mesh,
        nodes,
        labels=site.labels,
        lit=placed.lit,
        seed=site.settings.seed,
        executor=site.executor,
        keep=site.keep,
        name=name,
    )


def _coarse_nodes(site: Site, placed: Placed, edge: float) -> NodeMesh:
    """Place nodes on the same sides over longer edges; the nodes there are, where that would spare too few."""
    surface = graded(remesh(site.scene, site.labels, edge=edge), site.scene, site.labels)
    if len(node_mesh(surface, placed.lit)) > WORTH_COARSENING * len(placed.mesh):
        return placed.mesh
    # The pieces of this work are not kept: it takes seconds.
    unkept = replace(site, keep=Keeper(stop=site.keep.stop))
    return _seen_nodes(unkept, surface, placed.lit, "buried").mesh


@dataclass(frozen=True)
class _ClearShare:
    clear_share: FloatArray
    direct_doublings: IntArray


def with_shared_clear_share(site: Site, receivers: Receivers, name: str) -> Receivers:
    """`with_clear_share` by as many threads as there are."""

    def part(own: Receivers) -> _ClearShare:
        shared = with_clear_share(site.world, own, seed=(site.settings.seed, 3), among=len(receivers))
        return _ClearShare(shared.clear_share, shared.direct_doublings)

    def all_parts() -> _ClearShare:
        chunks = receivers.chunks(CLEAR_SHARE_CHUNK)
        parts = list(site.keep.map(site.executor, f"{name}/part", part, chunks, form_of(_ClearShare)))
        return _ClearShare(
            np.concatenate([found.clear_share for found in parts]),
            np.concatenate([found.direct_doublings for found in parts]),
        )

    found = site.keep.once(name, all_parts, form_of(_ClearShare))
    return replace(receivers, clear_share=found.clear_share, direct_doublings=found.direct_doublings)


def with_shared_known_direct(site: Site, receivers: Receivers, sight: Shares) -> Receivers:
    """`with_known_direct` by as many threads as there are."""

    def part(own: Receivers) -> FloatArray:
        return with_known_direct(site.world, own, sight).known_direct

    def all_parts() -> FloatArray:
        chunks = receivers.chunks(CLEAR_SHARE_CHUNK)
        return np.concatenate(list(site.keep.map(site.executor, "known direct/part", part, chunks, ARRAY)))

    return replace(receivers, known_direct=site.keep.once("known direct", all_parts, ARRAY))


def _spared(mesh: NodeMesh, mask: BoolArray, hidden: BoolArray) -> BoolArray:
    """Take from the mask (n,) the nodes of patch sides that it would leave with hidden ones (n,) at the most."""
    groups = patch_sides(mesh.patches, mesh.sides)
    left = np.bincount(groups, ~mask & ~hidden)
    return np.asarray(mask & (left[groups] > 0))
