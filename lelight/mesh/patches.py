"""Patches: connected, smooth pieces of the surface that carry one material.

Creases are where light is discontinuous, so they bound what is remeshed, interpolated and averaged as one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lelight.mesh.edges import directed_edges, edge_keys
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_normals

#: Corners closer than this part of the scene's diagonal, along every axis, are one point.
WELD_TOLERANCE = 1e-9


class EdgePairs(NamedTuple):
    """Neighbours across edges that exactly two consistently wound triangles share.

    Attributes
    ----------
    first, second : (k,) int into triangles
    """

    first: IntArray
    second: IntArray


def patches(scene: Scene, *, crease: float = np.radians(20.0)) -> IntArray:
    """Label triangles by patch: one material, connected over edges flatter than the crease angle.

    Two triangles join across an edge that they alone share, run through in opposite directions (the same
    side is their front), where their normals differ by less than ``crease``. A triangle without area is a
    patch by itself.

    Parameters
    ----------
    crease : float, rad

    Returns
    -------
    (n_t,) int; patches are numbered by their first triangle
    """
    normals = triangle_normals(scene.corners)
    pairs = edge_pairs(weld(scene.vertices)[scene.triangles])
    cos_angle = np.einsum("kx,kx->k", normals[pairs.first], normals[pairs.second])
    same_material = scene.triangle_materials[pairs.first] == scene.triangle_materials[pairs.second]
    joined = same_material & (cos_angle > np.cos(crease))
    return components(len(normals), pairs.first[joined], pairs.second[joined])


def weld(vertices: FloatArray) -> IntArray:
    """Give points numbers so that points at the same place get the same number.

    Coordinates are grouped axis by axis where the sorted values leave a gap, which, unlike rounding, never
    parts two close values. At map coordinates the tolerance follows the spacing of floating point numbers.

    Parameters
    ----------
    vertices : (n, 3) float, m

    Returns
    -------
    (n,) int
    """
    if len(vertices) == 0:
        return np.zeros(0, dtype=np.int64)
    diagonal = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    tolerance = max(WELD_TOLERANCE * diagonal, 4 * float(np.spacing(np.abs(vertices).max())))
    groups = np.stack([_gap_groups(axis, tolerance) for axis in vertices.T], axis=1)
    return _row_numbers(groups)


def edge_pairs(triangles: IntArray) -> EdgePairs:
    """Find the triangles that meet two by two, wound alike, across an edge of nobody else.

    Parameters
    ----------
    triangles : (n, 3) int; triangles that name a point twice have no neighbours
    """
    proper = np.flatnonzero(~_collapsed(triangles))
    start, end = directed_edges(triangles[proper])
    keys = edge_keys(start, end)
    order = np.argsort(keys, kind="stable")
    heads = np.flatnonzero(np.diff(keys[order], prepend=-1))
    heads = heads[np.diff(heads, append=len(keys)) == 2]
    one, other = order[heads], order[heads + 1]
    opposite = start[one] == end[other]
    return EdgePairs(proper[one[opposite] // 3], proper[other[opposite] // 3])


def _collapsed(triangles: IntArray) -> BoolArray:
    return np.asarray((triangles == np.roll(triangles, 1, axis=1)).any(axis=1))


def _gap_groups(values: FloatArray, tolerance: float) -> IntArray:
    """Give values (n,) numbers by runs of sorted neighbours that lie within the tolerance of each other."""
    order = np.argsort(values, kind="stable")
    groups = np.empty(len(values), dtype=np.int64)
    groups[order] = np.cumsum(np.diff(values[order], prepend=values[order[0]]) > tolerance)
    return groups


def _row_numbers(rows: IntArray) -> IntArray:
    """Give numbers to the distinct rows of (n, 3) small non-negative integers."""
    order = np.lexsort(rows.T)
    changes = (np.diff(rows[order], axis=0) != 0).any(axis=1)
    numbers = np.empty(len(rows), dtype=np.int64)
    numbers[order] = np.concatenate([[0], np.cumsum(changes)])
    return numbers


def components(count: int, first: IntArray, second: IntArray) -> IntArray:
    """Label ``count`` things by the connected component that the links put them in, by first member."""
    links = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(count, count))
    raw = connected_components(links, directed=False)[1]
    _, firsts, labels = np.unique(raw, return_index=True, return_inverse=True)
    rank = np.empty(len(firsts), dtype=np.int64)
    rank[np.argsort(firsts)] = np.arange(len(firsts))
    return np.asarray(rank[labels])
