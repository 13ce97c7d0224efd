"""The input surface torn along its patches: no vertex is shared by two of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lelight.mesh.patches import weld
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas

#: A patch is flat where its vertices leave its mean plane by less than this part of its extent.
FLATNESS = 1e-6


@dataclass(frozen=True)
class TornMesh:
    """Triangles in the order of their patches, welded within a patch.

    Attributes
    ----------
    vertices : (n, 3) float, m
    triangles : (m, 3) int into vertices
    vertex_patches : (n,) int, ascending
    triangle_patches : (m,) int, ascending
    patch_count : some may have no triangle (those without area)
    """

    vertices: FloatArray
    triangles: IntArray
    vertex_patches: IntArray
    triangle_patches: IntArray
    patch_count: int

    @cached_property
    def corners(self) -> FloatArray:
        """(m, 3, 3) float, m, relative to the first vertex of the patch: exact at map coordinates."""
        return np.asarray((self.vertices - self.origins[self.vertex_patches])[self.triangles])

    @cached_property
    def origins(self) -> FloatArray:
        """(patch_count, 3) float, m: the first vertex of each patch, zero without one."""
        present, first = np.unique(self.vertex_patches, return_index=True)
        origins = np.zeros((self.patch_count, 3))
        origins[present] = self.vertices[first]
        return origins

    @cached_property
    def areas(self) -> FloatArray:
        """(patch_count,) float, m²."""
        areas = triangle_areas(self.corners)
        return np.bincount(self.triangle_patches, areas, self.patch_count).astype(np.float64)

    @cached_property
    def diagonals(self) -> FloatArray:
        """(patch_count,) float, m: diagonals of the bounding boxes, zero without vertices."""
        spans = np.zeros((self.patch_count, 3))
        present, first = np.unique(self.vertex_patches, return_index=True)
        if len(present):
            highest = np.maximum.reduceat(self.vertices, first)
            spans[present] = highest - np.minimum.reduceat(self.vertices, first)
        return np.asarray(np.linalg.norm(spans, axis=1))

    @cached_property
    def plane_normals(self) -> FloatArray:
        """(patch_count, 3) float: mean normal by area, unit, zero where the patch has no side it faces."""
        sides = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        total = np.stack(
            [np.bincount(self.triangle_patches, axis, self.patch_count) for axis in sides.T], axis=1
        )
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return np.asarray(np.divide(total, length, out=np.zeros_like(total), where=length > 0))

    @cached_property
    def flat(self) -> BoolArray:
        """(patch_count,) bool: every vertex lies in the plane of the patch."""
        local = self.vertices - self.origins[self.vertex_patches]
        height = np.abs(np.einsum("nx,nx->n", local, self.plane_normals[self.vertex_patches]))
        rounding = 4 * np.spacing(np.abs(self.vertices).max(initial=0.0))
        uneven = height > FLATNESS * self.diagonals[self.vertex_patches] + rounding
        bent = np.bincount(self.vertex_patches, uneven, self.patch_count) > 0
        return np.asarray(~bent & (self.plane_normals != 0).any(axis=1))

    def piece(self, patch: int) -> tuple[FloatArray, IntArray]:
        """Vertices (n, 3) and triangles (m, 3) of one patch."""
        low, high = np.searchsorted(self.vertex_patches, [patch, patch + 1])
        first, last = np.searchsorted(self.triangle_patches, [patch, patch + 1])
        return self.vertices[low:high], self.triangles[first:last] - low


def tear(scene: Scene, labels: IntArray) -> TornMesh:
    """Take the surface apart into patches, without triangles that have no area.

    Parameters
    ----------
    labels : (n_t,) int, patch of each triangle of the scene
    """
    order = np.argsort(labels, kind="stable")
    points = weld(scene.vertices)[scene.triangles[order]]
    solid = (points != np.roll(points, 1, axis=1)).all(axis=1) & (triangle_areas(scene.corners[order]) > 0)
    order, points = order[solid], points[solid]
    own = labels[order, None] * (points.max(initial=0) + 1) + points
    _, first, corners = np.unique(own, return_index=True, return_inverse=True)
    return TornMesh(
        vertices=scene.vertices[scene.triangles[order].ravel()[first]],
        triangles=corners.reshape(-1, 3),
        vertex_patches=labels[order[first // 3]],
        triangle_patches=labels[order],
        patch_count=int(labels.max(initial=-1)) + 1,
    )
