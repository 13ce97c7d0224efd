"""Surfaces too close together for rays: which nodes they take, and when nothing can be told of a scene.

Rays are traced in single precision and start a few of its steps off their surface. What lies closer than that
is jumped over, so a node there would see through walls.
"""

from __future__ import annotations

import numpy as np

from lelight.errors import SceneError
from lelight.mesh.nodes import NodeMesh
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas
from lelight.tracing.world import World

#: Surfaces closer than this share of a ray's offset lie in one another and hide nothing.
SAME_PLACE = 0.02
#: Surfaces whose normals have at least this cosine run alongside each other.
ALONGSIDE = 0.9
#: Share of the area that may be too crowded for rays.
MOST_CROWDED = 0.01
#: Least weight of a corner at a point that lies well inside a triangle.
INSIDE = 1e-3
#: Places on an emitting triangle, weights of its corners, that are asked who else emits from there.
PROBES = np.array([[0.34, 0.33, 0.33], [0.7, 0.2, 0.1], [0.1, 0.7, 0.2], [0.2, 0.1, 0.7]])


def crowded(world: World, mesh: NodeMesh, labels: IntArray) -> BoolArray:
    """Nodes (n,) whose rays would start behind another surface.

    Parameters
    ----------
    labels : (n_t,) int, patch of each traced triangle
    """
    taken = _behind_another(world, labels, mesh.positions, mesh.normals, mesh.patches)
    # In the corners of something tiny single precision sees nothing; the middles of triangles tell of them too.
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    normals = mesh.normals[mesh.triangles].mean(axis=1)
    around = _behind_another(world, labels, middles, normals, mesh.triangle_patches)
    taken[mesh.triangles[around]] = True
    return taken


def _behind_another(
    world: World, labels: IntArray, points: FloatArray, normals: FloatArray, patches: IntArray
) -> BoolArray:
    """Say of which surface points (k, 3) rays would start behind the surface of another patch than theirs."""
    hits = world.caster.closest(world.caster.leave(points, normals), -normals)
    other = (hits.triangle >= 0) & (labels[hits.triangle] != patches) & _alongside(hits.normals, normals)
    height = np.einsum("nx,nx->n", hits.points - points, normals)
    between = (height > SAME_PLACE * world.caster.offset) & (height < world.caster.offset)
    return np.asarray(other & between)


def _alongside(one: FloatArray, other: FloatArray) -> BoolArray:
    """Say which unit normals (k, 3) are of surfaces that run alongside each other; others only cross."""
    return np.asarray(np.abs(np.einsum("nx,nx->n", one, other)) > ALONGSIDE)


def require_room(scene: Scene, world: World, mesh: NodeMesh, taken: BoolArray) -> None:
    """Refuse a scene of which much is too crowded for rays; ``taken`` (n,) are its nodes that are."""
    seen = ~mesh.hidden | taken
    if float(mesh.areas[taken].sum()) > MOST_CROWDED * float(mesh.areas[seen].sum()):
        raise _crowded(scene, world, "surfaces")


def _crowded(scene: Scene, world: World, what: str) -> SceneError:
    return SceneError(
        f"{scene.name}: {what} lie closer together than {world.caster.offset:.2g} m, which rays cannot "
        f"tell apart in a scene of {scene.diagonal:.3g} m; leave out what is far away, or widen the gap"
    )


def require_clear_emitters(scene: Scene, world: World) -> None:
    """Refuse emitting faces with another surface right before them, and such as overlap in one plane.

    Of the first kind rays would start behind that surface, of the second each would shine as if the other were
    not there.
    """
    emitters = world.emitters
    if not len(emitters.areas):
        return
    points = np.einsum("pc,tcx->tpx", PROBES, emitters.corners).reshape(-1, 3)
    normals = np.repeat(emitters.normals, len(PROBES), axis=0)
    own = np.repeat(np.flatnonzero(emitters.of_triangle >= 0), len(PROBES))
    hits = world.caster.closest(world.caster.leave(points, normals), -normals)
    met = hits.triangle
    height = np.einsum("nx,nx->n", hits.points - points, normals)
    behind = (met >= 0) & (met != own) & (height > SAME_PLACE * world.caster.offset)
    behind &= _alongside(hits.normals, normals)
    power = np.repeat(emitters.power[: len(emitters.areas)], len(PROBES))
    if float(power[behind].sum()) > MOST_CROWDED * float(power.sum()):
        raise _crowded(scene, world, "an emitting face and another surface")
    twice = (met >= 0) & (met != own) & (np.abs(height) <= SAME_PLACE * world.caster.offset)
    twice &= (emitters.of_triangle[met] >= 0) & (hits.front | emitters.both_sides[emitters.of_triangle[met]])
    twice[twice] = _inside(points[twice], world.caster.corners[met[twice]])
    if twice.any():
        where = ", ".join(f"{coordinate:.3f}" for coordinate in points[np.argmax(twice)])
        name = scene.materials[world.materials[own[np.argmax(twice)]]].name
        raise SceneError(
            f"{scene.name}: faces of material {name!r} at ({where}) m emit from the very place where others do; "
            "leave one of them out"
        )


def _inside(points: FloatArray, corners: FloatArray) -> BoolArray:
    """Say which points (k, 3) lie well inside triangles (k, 3, 3) of their plane: rays beside a needle may err."""
    whole = triangle_areas(corners)
    weights = [
        triangle_areas(np.stack([points, corners[:, k], corners[:, (k + 1) % 3]], axis=1)) for k in range(3)
    ]
    outside = np.sum(weights, axis=0) > (1.0 + INSIDE) * whole
    return np.asarray(~outside & (np.min(weights, axis=0) > INSIDE * whole))
