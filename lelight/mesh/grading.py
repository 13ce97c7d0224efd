"""Finer triangles where a small source is close: there illuminance falls from node to node by its distance.

A node stands for the surface around it. Beside a lamp that is closer than the next node it would speak for
a surface that receives far less, and the sum over all nodes would exceed what the lamps send.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit

from lelight.mesh.closest import closest
from lelight.mesh.edges import directed_edges, edge_keys
from lelight.mesh.nodes import SurfaceMesh
from lelight.scene import BoolArray, FloatArray, IntArray, Scene

#: Places on sources; where there are more, no single source counts for much, and all are left alone.
MOST_PLACES = 256
#: Places on an emitting triangle, weights of its corners: middle, corners, middles of edges.
PLACES = np.concatenate([np.full((1, 3), 1 / 3), np.eye(3), 0.5 - 0.5 * np.eye(3)])
#: No edge is made shorter than this share of the scene's diagonal.
SHORTEST = 2e-4


def graded(surface: SurfaceMesh, scene: Scene) -> SurfaceMesh:
    """Bisect triangles until none is longer than a source is away, or than it is large.

    Every patch stays conforming; the shape of its triangles suffers no more than by any bisection.
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
        surface = _bisected(surface, long)


def _sources(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Places (s, 3) of all sources, and the edge (s,) in m that is short enough beside each."""
    emitting = np.array([material.emits for material in scene.materials], dtype=np.bool_)
    corners = scene.corners[emitting[scene.triangle_materials]]
    on_faces = np.einsum("pc,tcx->tpx", PLACES, corners).reshape(-1, 3)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    sizes = np.repeat(edges.max(axis=1, initial=0.0), len(PLACES))
    positions = np.array([lamp.position for lamp in scene.luminaires]).reshape(-1, 3)
    return np.concatenate([on_faces, positions]), np.concatenate([sizes, np.zeros(len(positions))])


@njit(nogil=True, cache=True, error_model="numpy")
def _mark_long(corners: FloatArray, centres: FloatArray, least: FloatArray, long: BoolArray) -> None:
    """Mark triangles (m,) whose longest edge exceeds the distance to any source, and its least."""
    for t in range(len(corners)):
        longest = 0.0
        for k in range(3):
            edge = corners[t, (k + 1) % 3] - corners[t, k]
            longest = max(longest, edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2])
        for s in range(len(centres)):
            if longest > least[s] * least[s] and longest > closest(centres[s], corners[t])[0]:
                long[t] = True
                break


def _bisected(surface: SurfaceMesh, marked: BoolArray) -> SurfaceMesh:
    """Cut the edges that stand in the way of the marked triangles (m,) and are the longest of all around."""
    triangles, keys, longest = _longest_first(surface)
    longest_of, where = longest
    while True:  # along ever longer edges, to those that may be cut (Rivara 1984)
        wanted = np.zeros(len(keys), dtype=np.bool_)
        wanted[longest_of[marked]] = True
        grown = marked | wanted[where].any(axis=1)
        if np.array_equal(grown, marked):
            break
        marked = grown
    around = np.bincount(where.ravel(), minlength=len(keys))
    terminal = wanted & (np.bincount(longest_of, minlength=len(keys)) == around)
    cut = terminal[longest_of]
    number = np.cumsum(terminal) - 1
    ends = np.empty((int(terminal.sum()), 2), dtype=np.int64)
    ends[number[longest_of[cut]]] = triangles[cut, :2]
    middles = len(surface.vertices) + number[longest_of[cut]]
    a, b, c = triangles[cut].T
    halves = np.concatenate([np.stack([a, middles, c], axis=1), np.stack([middles, b, c], axis=1)])
    return _with_middles(surface, ends, triangles[~cut], halves)


def _longest_first(surface: SurfaceMesh) -> tuple[IntArray, IntArray, tuple[IntArray, IntArray]]:
    """Triangles turned so that the longest edge leaves corner 0, the edges, each one's longest, and its three.

    Equal lengths are told apart by the edge, so that two neighbours always agree on which is longer.
    """
    start, end = directed_edges(surface.triangles)
    keys, first, where = np.unique(edge_keys(start, end), return_index=True, return_inverse=True)
    spans = surface.vertices[start[first]] - surface.vertices[end[first]]
    rank = np.empty(len(keys), dtype=np.int64)
    rank[np.lexsort((keys, np.linalg.norm(spans, axis=1)))] = np.arange(len(keys))
    of_triangle = where.reshape(-1, 3)
    turn = np.argmax(rank[of_triangle], axis=1)
    rows = np.arange(len(of_triangle))
    turned = np.stack([surface.triangles[rows, (turn + k) % 3] for k in range(3)], axis=1)
    return turned, keys, (of_triangle[rows, turn], of_triangle)


def _with_middles(surface: SurfaceMesh, ends: IntArray, kept: IntArray, halves: IntArray) -> SurfaceMesh:
    """Put middles of edges (k, 2) into a surface, vertices and triangles in the order of their patches."""
    normals = surface.normals[ends].sum(axis=1)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 0.0, normals / np.maximum(length, 1e-300), surface.normals[ends[:, 0]])
    vertices = np.concatenate([surface.vertices, surface.vertices[ends].mean(axis=1)])
    patches = np.concatenate([surface.vertex_patches, surface.vertex_patches[ends[:, 0]]])
    order = np.argsort(patches, kind="stable")
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    triangles = place[np.concatenate([kept, halves])]
    own = patches[order][triangles[:, 0]]
    by_patch = np.argsort(own, kind="stable")
    return replace(
        surface,
        vertices=vertices[order],
        normals=np.concatenate([surface.normals, normals])[order],
        vertex_patches=patches[order],
        triangles=triangles[by_patch],
        triangle_patches=own[by_patch],
    )
