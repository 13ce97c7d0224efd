"""Finer triangles where a small source is close: there illuminance falls from node to node by its distance.

A node stands for the surface around it. Beside a lamp that is closer than the next node it would speak for
a surface that receives far less, and the sum over all nodes would exceed what the lamps send.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.mesh.closest import closest
from lelight.mesh.nodes import SurfaceMesh
from lelight.mesh.refinement import refine
from lelight.scene import BoolArray, FloatArray, IntArray, Scene

#: Places on sources; where there are more, no single source counts for much, and all are left alone.
MOST_PLACES = 256
#: Places on an emitting triangle, weights of its corners: middle, corners, middles of edges.
PLACES = np.concatenate([np.full((1, 3), 1 / 3), np.eye(3), 0.5 - 0.5 * np.eye(3)])
#: No edge is made shorter than this share of the scene's diagonal.
SHORTEST = 2e-4


def graded(surface: SurfaceMesh, scene: Scene, labels: IntArray) -> SurfaceMesh:
    """Bisect triangles until none is longer than a source is away, or than it is large.

    Every patch stays conforming; the shape of its triangles suffers no more than by any bisection.

    Parameters
    ----------
    labels : (n_t,) int, patch of each triangle of the scene
    """
    centres, sizes = _sources(scene)
    if not 0 < len(centres) <= MOST_PLACES:
        return surface
    least = np.maximum(sizes, SHORTEST * scene.diagonal)
    # At map coordinates distances of squares need a near origin.
    origin = surface.vertices.mean(axis=0)
    while True:
        corners = np.ascontiguousarray(surface.vertices[surface.triangles] - origin)
        long = np.zeros(len(corners), dtype=np.bool_)
        _mark_long(corners, centres - origin, least, long)
        if not long.any():
            return surface
        surface = refine(surface, long, corners=scene.corners, labels=labels)


def _sources(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Places (s, 3) of all sources, and the edge (s,) in m that is short enough beside each."""
    corners = scene.vertices[scene.triangles[scene.emitting]]
    on_faces = np.einsum("pc,tcx->tpx", PLACES, corners).reshape(-1, 3)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    sizes = np.repeat(edges.max(axis=1, initial=0.0), len(PLACES))
    positions = scene.lamp_positions
    return np.concatenate([on_faces, positions]), np.concatenate([sizes, np.zeros(len(positions))])


@njit(**COMPILED)
def _mark_long(corners: FloatArray, centres: FloatArray, least: FloatArray, long: BoolArray) -> None:
    """Mark triangles (m,) whose longest edge exceeds the distance to any source, and its least."""
    for t in range(len(corners)):
        longest = 0.0
        for k in range(3):
            edge = corners[t, (k + 1) % 3] - corners[t, k]
            longest = max(longest, edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2])
        for s in range(len(centres)):
            if (
                longest > least[s] * least[s]
                and longest > closest(centres[s, 0], centres[s, 1], centres[s, 2], corners, t)[0]
            ):
                long[t] = True
                break
