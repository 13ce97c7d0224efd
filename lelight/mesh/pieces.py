"""Pieces of a mesh that know their patches, and what is measured on them: shape and normals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lelight.scene import BoolArray, FloatArray, IntArray, triangle_areas, triangle_normals


class Piece(NamedTuple):
    """Part of a mesh.

    Attributes
    ----------
    vertices : (n, 3) float, m
    triangles : (m, 3) int into vertices
    vertex_patches : (n,) int
    triangle_patches : (m,) int
    """

    vertices: FloatArray
    triangles: IntArray
    vertex_patches: IntArray
    triangle_patches: IntArray


def select(piece: Piece, chosen: BoolArray) -> Piece:
    """Keep the chosen triangles (m,) and the vertices that they use."""
    used, corners = np.unique(piece.triangles[chosen], return_inverse=True)
    return Piece(
        piece.vertices[used],
        corners.reshape(-1, 3),
        piece.vertex_patches[used],
        piece.triangle_patches[chosen],
    )


def joined(pieces: Sequence[Piece]) -> Piece:
    """Put pieces into one, vertices and triangles in the order of their patches."""
    firsts = np.cumsum([0] + [len(piece.vertices) for piece in pieces])
    triangles = np.concatenate(
        [piece.triangles + first for piece, first in zip(pieces, firsts[:-1], strict=True)]
    )
    vertex_patches = np.concatenate([piece.vertex_patches for piece in pieces])
    triangle_patches = np.concatenate([piece.triangle_patches for piece in pieces])
    by_patch = np.argsort(vertex_patches, kind="stable")
    place = np.empty(len(by_patch), dtype=np.int64)
    place[by_patch] = np.arange(len(by_patch))
    order = np.argsort(triangle_patches, kind="stable")
    vertices = np.concatenate([piece.vertices for piece in pieces])
    return Piece(
        vertices[by_patch], place[triangles[order]], vertex_patches[by_patch], triangle_patches[order]
    )


def triangle_quality(corners: FloatArray) -> FloatArray:
    """Shape (n,) of triangles (n, 3, 3): ``4 sqrt(3) area / (a² + b² + c²)``, 1 equilateral, 0 a needle.

    Bank & Smith, "Mesh smoothing using a posteriori error estimates", SIAM J. Numer. Anal. 34 (1997).
    """
    squares = ((np.roll(corners, -1, axis=1) - corners) ** 2).sum(axis=(1, 2))
    areas = 4 * np.sqrt(3) * triangle_areas(corners)
    return np.asarray(np.divide(areas, squares, out=np.zeros(len(corners)), where=squares > 0))


def corner_angles(corners: FloatArray) -> FloatArray:
    """Angles (n, 3) rad at the corners of triangles (n, 3, 3)."""
    ahead = np.roll(corners, -1, axis=1) - corners
    back = np.roll(corners, 1, axis=1) - corners
    sine = np.linalg.norm(np.cross(ahead, back), axis=2)
    return np.asarray(np.arctan2(sine, np.einsum("ncx,ncx->nc", ahead, back)))


def vertex_normals(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Average the normals of the triangles around each vertex, weighted by their angle there: (n, 3), unit.

    Thürmer & Wüthrich, "Computing vertex normals from polygonal facets", J. Graphics Tools 3 (1998): the
    angle as weight makes the mean independent of how the surface is triangulated. Where the mean vanishes,
    as at the tip of a double cone, the normal of the first triangle around stands in.
    """
    corners = vertices[triangles]
    normals = triangle_normals(corners)
    weighted = (corner_angles(corners)[:, :, None] * normals[:, None]).reshape(-1, 3)
    around = triangles.ravel()
    mean = np.stack([np.bincount(around, axis, len(vertices)) for axis in weighted.T], axis=1)
    length = np.linalg.norm(mean, axis=1)
    used, first = np.unique(around, return_index=True)
    lost = length[used] < 1e-9
    mean[used[lost]] = normals[first[lost] // 3]
    length[used[lost]] = 1.0
    return np.asarray(mean / np.where(length > 0, length, 1.0)[:, None])
