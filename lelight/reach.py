"""What of a scene light reaches, and what of that an observer may look at: what the plan is decided on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lelight.channels import channel_matrix
from lelight.mesh.nodes import NodeMesh
from lelight.plan import Decision, Plan, is_dark
from lelight.plancost import degree_cost
from lelight.scene import BoolArray, IntArray, Scene
from lelight.tracing.emitters import collect_emitters
from lelight.tracing.reflection import collect_reflectances
from lelight.tracing.world import World


def without_dark_lamps(scene: Scene) -> Scene:
    """Leave out luminaires that give no light: they would be weighed at every place and never be drawn."""
    return replace(scene, luminaires=tuple(lamp for lamp in scene.luminaires if not is_dark(lamp)))


def reached_materials(scene: Scene, labels: IntArray, lit: BoolArray) -> BoolArray:
    """Materials (n_materials,) of patches that receive light on a side.

    Parameters
    ----------
    labels : (n_t,) int, patch of each triangle
    lit : (n_patches, 2) bool, sides that receive light
    """
    reached = np.zeros(len(scene.materials), dtype=np.bool_)
    reached[scene.triangle_materials[lit[labels].any(axis=1)]] = True
    return reached


def in_channels(world: World, scene: Scene, channels: int) -> World:
    """Carry another number of channels through the same surfaces."""
    if channels == world.channels:
        return world
    matrix = channel_matrix(channels)
    return replace(
        world, reflectances=collect_reflectances(scene, matrix), emitters=collect_emitters(scene, matrix)
    )


def seen_sides(scene: Scene, world: World, mesh: NodeMesh, plan: Plan) -> tuple[BoolArray, Decision | None]:
    """Sides (n_patches, 2) whose nodes keep angular detail: those that an eye sees, or a mirror may show.

    Where too little was kept, a direction is evaluated by reflecting the view ray: noisier, and right.
    """
    sides = np.ones((int(mesh.patches.max(initial=-1)) + 1, 2), dtype=np.bool_)
    if plan.angular == "all" or not scene.observers:
        return sides, None
    materials = np.unique(mesh.materials)
    mirrors = [
        scene.materials[m].name for m in materials if scene.materials[m].glossy and not plan.degrees[m]
    ]
    detailed = plan.degrees[mesh.materials] > 0
    count = int(detailed.sum())
    name = "nodes with angular detail"
    if mirrors:
        reason = f"{', '.join(mirrors[:3])} may show them to an observer"
        return sides, Decision(name, f"{count} of {len(mesh)}", reason)
    column = np.where(mesh.sides > 0, 0, 1)
    sides[:] = False
    for patch, side in np.unique(np.stack([mesh.patches, column], axis=1)[detailed], axis=0):
        own = np.flatnonzero((mesh.patches == patch) & (column == side))
        sides[patch, side] = _sees_any(scene, world, mesh, own)
    kept = int((detailed & sides[mesh.patches, column]).sum())
    reason = "on sides that an observer sees" if kept else "no observer sees any of the others"
    return sides, Decision(name, f"{kept} of {len(mesh)}", reason, degree_cost(plan.degree, plan.channels))


def _sees_any(scene: Scene, world: World, mesh: NodeMesh, nodes: IntArray) -> bool:
    """Say whether any eye sees any of the nodes."""
    places = world.caster.leave(mesh.positions[nodes], mesh.normals[nodes])
    for eye in scene.observers:
        away = eye.position - places
        before = np.einsum("nx,nx->n", away, mesh.normals[nodes]) > 0
        if before.any():
            eyes = np.tile(eye.position, (int(before.sum()), 1))
            if world.caster.visible(places[before], eyes).any():
                return True
    return False
