"""Outlines of flat patches: which of them are plain convex quadrilaterals, however they are triangulated."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lelight.mesh.edges import directed_edges, on_border
from lelight.mesh.torn import TornMesh
from lelight.scene import BoolArray, FloatArray, IntArray

#: Two border edges are one straight line where they turn by less than this angle (rad).
STRAIGHT = 1e-6

#: Area of a quadrilateral by its corners and by its triangles may differ by this part.
SAME_AREA = 1e-6


class Quads(NamedTuple):
    """Patches that are flat convex quadrilaterals.

    Attributes
    ----------
    patches : (k,) int, ascending
    corners : (k, 4, 3) float, m, anticlockwise seen from the front
    """

    patches: IntArray
    corners: FloatArray


def convex_quads(torn: TornMesh) -> Quads:
    """Find flat patches with one border of four corners, all convex, without points in straight sides."""
    border = np.stack(directed_edges(torn.triangles), axis=1)[on_border(torn.triangles)]
    before = np.full(len(torn.vertices), -1)
    after = np.full(len(torn.vertices), -1)
    before[border[:, 1]], after[border[:, 0]] = border[:, 0], border[:, 1]
    turn = _turning(torn, before, after)
    corner = np.flatnonzero(np.abs(turn) > STRAIGHT)
    plain = torn.flat & ~_knotted(torn, border)
    plain &= np.bincount(torn.vertex_patches[corner], minlength=torn.patch_count) == 4
    plain &= np.bincount(torn.vertex_patches, turn < -STRAIGHT, torn.patch_count) == 0
    kept = corner[plain[torn.vertex_patches[corner]]].reshape(-1, 4)
    quads = torn.vertex_patches[kept[:, 0]]
    corners = _anticlockwise(torn.vertices[kept], torn.plane_normals[quads])
    same = np.abs(_quad_areas(corners) - torn.areas[quads]) <= SAME_AREA * torn.areas[quads]
    return Quads(quads[same], corners[same])


def _turning(torn: TornMesh, before: IntArray, after: IntArray) -> FloatArray:
    """Angle (n,) rad by which the border turns left at each vertex, zero inside the patch."""
    normals = torn.plane_normals[torn.vertex_patches]
    arriving, leaving = torn.vertices - torn.vertices[before], torn.vertices[after] - torn.vertices
    sine = np.einsum("nx,nx->n", np.cross(arriving, leaving), normals)
    cosine = np.einsum("nx,nx->n", arriving, leaving)
    return np.where(before >= 0, np.arctan2(sine, cosine), 0.0)


def _knotted(torn: TornMesh, border: IntArray) -> BoolArray:
    """Patches (patch_count,) bool whose border runs twice through a vertex, or through none."""
    passes = np.bincount(border[:, 0], minlength=len(torn.vertices))
    knots = np.bincount(torn.vertex_patches, passes > 1, torn.patch_count)
    return np.asarray((knots > 0) | (np.bincount(torn.vertex_patches, passes, torn.patch_count) == 0))


def _anticlockwise(corners: FloatArray, normals: FloatArray) -> FloatArray:
    """Order corners (k, 4, 3) by their angle around their centre, seen from where the normals point."""
    local = corners - corners.mean(axis=1, keepdims=True)
    x = local[:, :1]
    y = np.cross(normals[:, None], x)
    angle = np.arctan2(np.einsum("kcx,kdx->kc", local, y), np.einsum("kcx,kdx->kc", local, x))
    order = np.argsort(np.where(angle < -1e-12, angle + 2 * np.pi, angle), axis=1, kind="stable")
    return np.take_along_axis(corners, order[:, :, None], axis=1)


def _quad_areas(corners: FloatArray) -> FloatArray:
    """Areas (k,) m² of flat quadrilaterals: half the cross product of their diagonals."""
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return np.asarray(0.5 * np.linalg.norm(np.cross(*diagonals), axis=1))
