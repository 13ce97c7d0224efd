"""Edges of triangles: their ends, a number for each, and which lie on a border."""

from __future__ import annotations

import numpy as np

from lelight.scene import BoolArray, IntArray


def directed_edges(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Start and end (3 n,) of the edges of triangles (n, 3), triangle by triangle; edge k leaves corner k."""
    return triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()


def edge_keys(start: IntArray, end: IntArray) -> IntArray:
    """One number for each undirected edge: equal where the same two points are joined."""
    points = int(max(start.max(initial=0), end.max(initial=0))) + 1
    return np.asarray(np.minimum(start, end) * points + np.maximum(start, end))


def on_border(triangles: IntArray) -> BoolArray:
    """Edges (3 n,) bool that belong to one triangle only."""
    keys = edge_keys(*directed_edges(triangles))
    order = np.argsort(keys)
    another = np.diff(keys[order]) != 0
    single = np.empty(len(keys), dtype=np.bool_)
    single[order] = np.append(True, another) & np.append(another, True) if len(keys) else True
    return single
