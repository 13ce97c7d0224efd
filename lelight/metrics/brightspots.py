"""Bright spots of a luminance picture: connected pixels, merged where only a narrow gap parts them."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import distance_transform_edt, label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lelight.scene import BoolArray, FloatArray, IntArray


def label_spots(bright: BoolArray, directions: FloatArray, *, gap: float) -> tuple[IntArray, int]:
    """Give each spot of a mask its number.

    Pixels that touch, diagonals included, are one spot; so are groups whose nearest pixels are at most
    ``gap`` apart, from group to group. The gap is taken between the pixels that are nearest in the picture.

    Parameters
    ----------
    bright : (h, w) bool
    directions : (h, w, 3) float, unit
    gap : float, rad

    Returns
    -------
    labels : (h, w) int, 0 outside the spots, 1 to count inside
    count : int
    """
    found, count = label(bright, structure=np.ones((3, 3)))
    groups = np.asarray(found, dtype=np.int64)
    if count < 2:
        return groups, int(count)
    return _merged(groups, int(count), _close_pairs(groups, directions, gap))


def _merged(groups: IntArray, count: int, pairs: IntArray) -> tuple[IntArray, int]:
    edges = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count + 1, count + 1))
    # Node 0 stands for the background; it has no edges and comes first, so it stays 0.
    components, spots = connected_components(edges, directed=False)
    return spots[groups].astype(np.int64), int(components) - 1


def _close_pairs(groups: IntArray, directions: FloatArray, gap: float) -> IntArray:
    """Pairs (m, 2) of groups that are at most ``gap`` rad apart.

    Each pixel belongs to the group nearest to it. Where two such regions meet, the two nearest pixels across
    the border span the gap between their groups.
    """
    rows, columns = distance_transform_edt(groups == 0, return_distances=False, return_indices=True)
    near = rows * groups.shape[1] + columns
    across = [(near[:, :-1], near[:, 1:]), (near[:-1], near[1:])]
    first = np.concatenate([left.ravel() for left, _ in across])
    second = np.concatenate([right.ravel() for _, right in across])
    labels = groups.ravel()
    border = labels[first] != labels[second]
    first, second = first[border], second[border]
    close = _angles(directions, first, second) <= gap
    return np.stack([labels[first[close]], labels[second[close]]], axis=1)


def _angles(directions: FloatArray, first: IntArray, second: IntArray) -> FloatArray:
    flat = directions.reshape(-1, 3)
    chords = np.linalg.norm(flat[first] - flat[second], axis=1)
    return np.asarray(2 * np.arcsin(np.clip(chords / 2, 0, 1)))
