"""Places that are alike: near each other and facing the same way."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from lelight.scene import BoolArray, FloatArray, IntArray

#: How many places, itself among them, stand for what is around one.
NEIGHBOURS = 7
#: Places asked at once; bounds memory.
PIECE = 1 << 16


class Alike:
    """Finds among places those that are near and face the same way."""

    def __init__(self, points: FloatArray, normals: FloatArray) -> None:
        """Other normals are as far as the extent of all places (m, 3)."""
        self._extent = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0
        self._tree = cKDTree(np.concatenate([points, self._extent * normals], axis=1))

    def nearest(self, points: FloatArray, normals: FloatArray, count: int) -> IntArray:
        """Places (k, count) nearest to points (k, 3) with unit normals (k, 3)."""
        nearest = np.empty((len(points), count), dtype=np.int64)
        for first in range(0, len(points), PIECE):
            piece = slice(first, first + PIECE)
            asked = np.concatenate([points[piece], self._extent * normals[piece]], axis=1)
            nearest[piece] = self._tree.query(asked, k=np.arange(1, count + 1))[1]
        return nearest


def most_alike(points: FloatArray, normals: FloatArray, among: IntArray) -> IntArray:
    """Find for each place the nearest of some that faces the same way: (r,), index into ``among`` (k,)."""
    return Alike(points[among], normals[among]).nearest(points, normals, 1)[:, 0]


def alike(points: FloatArray, normals: FloatArray, *, left_out: BoolArray | None = None) -> IntArray:
    """Find the nearest places that face the same way (r, 7), each place itself among them.

    Parameters
    ----------
    points, normals : (r, 3) float, m and unit length
    left_out : (r,) bool, places that are nobody's neighbour; they and places with too few others get themselves
    """
    nearest = np.tile(np.arange(len(points))[:, None], NEIGHBOURS)
    kept = np.arange(len(points)) if left_out is None else np.flatnonzero(~left_out)
    if len(kept) >= NEIGHBOURS:
        own = points[kept], normals[kept]
        nearest[kept] = kept[Alike(*own).nearest(*own, NEIGHBOURS)]
    return nearest


def half_pooled(variance: FloatArray, neighbours: IntArray) -> FloatArray:
    """Average variances (..., r) of places half and half with those around them (r, 7).

    What a few samples say of the variance of one place is uncertain, and where light comes by rare paths mostly too
    little; it changes from place to place far less than that.
    """
    return np.asarray(0.5 * variance + 0.5 * variance[..., neighbours].mean(axis=-1))
