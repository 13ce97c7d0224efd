"""Longest-edge bisection: cut triangles until no edge is too long, exactly on the original surface.

Rivara, "Algorithms for refining triangular grids suitable for adaptive and multigrid techniques", Int. J.
Numer. Meth. Engng 20 (1984): cutting only edges that are the longest of all their triangles leaves no
hanging vertex and never halves the smallest angle more than once.
"""

from __future__ import annotations

import numpy as np

from lelight.mesh.edges import directed_edges, edge_keys
from lelight.scene import BoolArray, FloatArray, IntArray


def bisect(
    vertices: FloatArray, triangles: IntArray, *, edge: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """Cut triangles at the middle of their longest edges until every edge is at most ``edge`` long.

    Parameters
    ----------
    vertices : (n, 3) float, m
    triangles : (m, 3) int; triangles that share vertices stay conforming
    edge : float, m

    Returns
    -------
    vertices : (n + cuts, 3) float; the given ones come first, unchanged
    triangles : (m', 3) int, wound as their parents
    parents : (m',) int, the given triangle that each is a part of
    """
    parents = np.arange(len(triangles))
    finished: list[tuple[IntArray, IntArray]] = []
    while len(triangles):
        triangles, lengths = longest_first(vertices, triangles)
        long = lengths > edge
        finished.append((triangles[~long], parents[~long]))
        triangles, parents = triangles[long], parents[long]
        vertices, triangles, parents = _cut_round(vertices, triangles, parents)
    whole = np.concatenate([part for part, _ in finished]) if finished else triangles
    origin = np.concatenate([part for _, part in finished]) if finished else parents
    order = np.argsort(origin, kind="stable")
    return vertices, whole[order], origin[order]


def longest_first(vertices: FloatArray, triangles: IntArray) -> tuple[IntArray, FloatArray]:
    """Turn triangles so that their longest edge leaves corner 0, and measure it (n,).

    Equal lengths are told apart by the edge itself, so that two neighbours always agree on which is longer.
    """
    start, end = directed_edges(triangles)
    low, high = np.minimum(start, end), np.maximum(start, end)
    lengths = np.linalg.norm(vertices[high] - vertices[low], axis=1)
    rank = np.empty(len(start), dtype=np.int64)
    rank[np.lexsort((high, low, lengths))] = np.arange(len(start))
    keys, where = np.unique(edge_keys(start, end), return_inverse=True)
    shared_rank = np.zeros(len(keys), dtype=np.int64)
    np.maximum.at(shared_rank, where, rank)
    longest = np.argmax(shared_rank[where].reshape(-1, 3), axis=1)
    rows = np.arange(len(triangles))
    turned = np.stack([triangles[rows, (longest + k) % 3] for k in range(3)], axis=1)
    return turned, lengths.reshape(-1, 3)[rows, longest]


def _cut_round(
    vertices: FloatArray, triangles: IntArray, parents: IntArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Cut every edge that is the longest of all triangles around it; the first edge is each one's longest."""
    if len(triangles) == 0:
        return vertices, triangles, parents
    cut, middles, points = _terminal_cuts(vertices, triangles)
    a, b, c = triangles[cut].T
    halves = np.concatenate([np.stack([a, middles, c], axis=1), np.stack([middles, b, c], axis=1)])
    return (
        np.concatenate([vertices, points]),
        np.concatenate([triangles[~cut], halves]),
        np.concatenate([parents[~cut], parents[cut], parents[cut]]),
    )


def _terminal_cuts(vertices: FloatArray, triangles: IntArray) -> tuple[BoolArray, IntArray, FloatArray]:
    """Choose the triangles to cut (n,), the vertex each gets (cuts,) and the new points (k, 3)."""
    longest, terminal = terminal_edges(triangles)
    cut = terminal[longest]
    number = np.cumsum(terminal) - 1
    points = np.empty((int(terminal.sum()), 3))
    points[number[longest[cut]]] = vertices[triangles[cut, :2]].mean(axis=1)
    return cut, len(vertices) + number[longest[cut]], points


def terminal_edges(triangles: IntArray) -> tuple[IntArray, BoolArray]:
    """Give edges numbers and find those that are the longest of all triangles around them.

    Parameters
    ----------
    triangles : (m, 3) int, as `longest_first` turns them

    Returns
    -------
    longest : (m,) int, number of each triangle's longest edge
    terminal : (edges,) bool
    """
    keys, where = np.unique(edge_keys(*directed_edges(triangles)), return_inverse=True)
    longest = where.reshape(-1, 3)[:, 0]
    around = np.bincount(where, minlength=len(keys))
    claims = np.bincount(longest, minlength=len(keys))
    return longest, claims == around
