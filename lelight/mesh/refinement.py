"""Local refinement: halve the triangles that ask for it, and as few others as conformity needs.

Rivara, "New longest-edge algorithms for the refinement and/or improvement of unstructured triangulations", Int.
J. Numer. Meth. Engng 40 (1997): an edge is cut where it is the longest of all triangles around it; from a
triangle that asks, the way there leads over ever longer edges.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lelight.mesh.bisection import longest_first, terminal_edges
from lelight.mesh.edges import directed_edges, edge_keys
from lelight.mesh.nearest import nearest_points
from lelight.mesh.nodes import SurfaceMesh
from lelight.scene import BoolArray, FloatArray, IntArray


def refine(surface: SurfaceMesh, asked: BoolArray, *, corners: FloatArray, labels: IntArray) -> SurfaceMesh:
    """Cut the triangles that are asked for (m,) in two or more; no vertex is left hanging.

    Parameters
    ----------
    corners : (n_t, 3, 3) float, m, of the traced triangles, on which new vertices are put
    labels : (n_t,) int, patch of each
    """
    whole = surface
    while asked.any():
        whole, asked = _cut_once(whole, asked)
    fresh = np.arange(len(surface.vertices), len(whole.vertices))
    vertices = whole.vertices.copy()
    vertices[fresh], _ = nearest_points(vertices[fresh], whole.vertex_patches[fresh], corners, labels)
    order = np.argsort(whole.triangle_patches, kind="stable")
    return replace(
        whole,
        vertices=vertices,
        triangles=whole.triangles[order],
        triangle_patches=whole.triangle_patches[order],
    )


def _cut_once(surface: SurfaceMesh, asked: BoolArray) -> tuple[SurfaceMesh, BoolArray]:
    """Cut every terminal edge that a triangle which asks leads to; returns who still asks."""
    triangles, _ = longest_first(surface.vertices, surface.triangles)
    longest, terminal = terminal_edges(triangles)
    chosen = terminal & _reached(triangles, longest, asked)
    cut = chosen[longest]
    number = len(surface.vertices) + np.cumsum(chosen) - 1
    ends = np.empty((int(chosen.sum()), 2), dtype=np.int64)
    middles = number[longest[cut]]
    ends[middles - len(surface.vertices)] = triangles[cut, :2]
    a, b, c = triangles[cut].T
    halves = np.concatenate([np.stack([a, middles, c], axis=1), np.stack([middles, b, c], axis=1)])
    patches = surface.triangle_patches
    finer = replace(
        surface,
        vertices=np.concatenate([surface.vertices, surface.vertices[ends].mean(axis=1)]),
        normals=np.concatenate([surface.normals, _mean_normals(surface.normals[ends])]),
        vertex_patches=np.concatenate([surface.vertex_patches, surface.vertex_patches[ends[:, 0]]]),
        triangles=np.concatenate([triangles[~cut], halves]),
        triangle_patches=np.concatenate([patches[~cut], patches[cut], patches[cut]]),
    )
    still = np.concatenate([asked[~cut], np.zeros(2 * int(cut.sum()), dtype=np.bool_)])
    return finer, still


def _reached(triangles: IntArray, longest: IntArray, asked: BoolArray) -> BoolArray:
    """Edges to which the longest edges of the triangles that ask lead, over neighbours' longer ones."""
    _, edges = np.unique(edge_keys(*directed_edges(triangles)), return_inverse=True)
    own = edges.reshape(-1, 3)
    reached = np.zeros(int(edges.max(initial=-1)) + 1, dtype=np.bool_)
    reached[longest[asked]] = True
    while True:
        further = reached.copy()
        further[longest[reached[own].any(axis=1) & _on_the_way(own, longest, reached)]] = True
        if np.array_equal(further, reached):
            return reached
        reached = further


def _on_the_way(own: IntArray, longest: IntArray, reached: BoolArray) -> BoolArray:
    """Triangles that share a reached edge which is not their longest: the way leads on through them."""
    shorter = own != longest[:, None]
    return np.asarray((reached[own] & shorter).any(axis=1))


def _mean_normals(pairs: FloatArray) -> FloatArray:
    """Average pairs of normals (k, 2, 3) to unit ones (k, 3)."""
    mean = pairs.mean(axis=1)
    length = np.linalg.norm(mean, axis=1, keepdims=True)
    return np.asarray(np.where(length > 0, mean / np.where(length > 0, length, 1.0), pairs[:, 0]))
