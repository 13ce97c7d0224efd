"""Rays against the scene's own triangles: the one place that knows embree and float32.

Embree computes in single precision and offers no near distance. The scene is therefore recentred and scaled
to the unit cube in double precision before it is handed over, origins are moved off their surface along the
normal by a few float32 steps of the scene's size, and points hit are computed again in double precision from
the triangle's own corners, as far off its border: a point that single precision puts beyond the edge of a wall
would go on behind the next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore import EmbreeDevice
from embreex.rtcore_scene import EmbreeScene
from numba import njit
from numpy.typing import NDArray

from lelight.compilation import COMPILED
from lelight.mesh.doubles import backs
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas, triangle_normals

#: Single precision, in which embree computes.
Float32Array = NDArray[np.float32]

#: Distance from a surface at which rays start, as a share of half the scene's extent (about 60 float32
#: steps).
OFFSET_SHARE = 4e-6
#: Least weight of a triangle's corner in a point hit, at most; it keeps the point off the border.
LARGEST_INSET = 0.01
#: Shadow rays stop this share of their length before the target.
SHADOW_SHARE = 1.0 - 1e-5


@dataclass(frozen=True)
class Hits:
    """First surfaces that rays meet.

    Attributes
    ----------
    triangle : (k,) int, -1 where the ray leaves the scene
    points : (k, 3) float, m; the ray's origin where nothing is hit
    normals : (k, 3) float, unit, on the side that was hit; zero where nothing is
    front : (k,) bool, whether that side is the triangle's front
    """

    triangle: IntArray
    points: FloatArray
    normals: FloatArray
    front: BoolArray


class RayCaster:
    """Embree's view of a triangle mesh; safe to call from several threads, each call runs in its own."""

    def __init__(self, vertices: FloatArray, triangles: IntArray) -> None:
        self._mesh = vertices, triangles
        used = vertices[triangles.reshape(-1)]
        low, high = used.min(axis=0), used.max(axis=0)
        self.corners: FloatArray = vertices[triangles]
        self.normals: FloatArray = triangle_normals(self.corners)
        self.centre: FloatArray = 0.5 * (low + high)
        self.scale = 2.0 / float(np.max(high - low))
        self.offset = OFFSET_SHARE / self.scale
        #: (n,) int, the face back to back with each, which reflects on its back's behalf; -1 for none.
        self.backs: IntArray = backs(vertices, triangles)
        self._insets = np.minimum(self.offset / _least_heights(self.corners), LARGEST_INSET)
        # The device must outlive the scene that it made.
        self._device = EmbreeDevice()
        self._scene = EmbreeScene(self._device, robust=True)
        scaled = ((self.corners - self.centre) * self.scale).reshape(-1, 3).astype(np.float32)
        TriangleMesh(self._scene, scaled, np.arange(len(scaled), dtype=np.int32).reshape(-1, 3))

    def __reduce__(self) -> tuple[type[RayCaster], tuple[FloatArray, IntArray]]:
        """Build anew in another process, which has embree of its own."""
        return RayCaster, self._mesh

    @classmethod
    def of(cls, scene: Scene) -> RayCaster:
        """Trace the triangles of ``scene`` as they were read."""
        return cls(scene.vertices, scene.triangles)

    def closest(self, origins: FloatArray, directions: FloatArray) -> Hits:
        """Follow rays to the first surface.

        Parameters
        ----------
        origins : (k, 3) float, m; already off their own surface (see `leave`)
        directions : (k, 3) float, unit
        """
        found = self._scene.run(self.in_unit_cube(origins), directions.astype(np.float32), output=True)
        landed = _land(
            found["primID"],
            found["u"],
            found["v"],
            self._insets,
            self.backs,
            self.corners,
            self.normals,
            origins,
            directions,
        )
        return Hits(*landed)

    def leave(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Move surface points (k, 3) off their surface to the side that ``normals`` (k, 3) point to."""
        return points + self.offset * normals

    def visible(self, origins: FloatArray, targets: FloatArray) -> BoolArray:
        """Say for each pair of points (k, 3), m, already off their surfaces, whether nothing lies between."""
        start = self.in_unit_cube(origins)
        return self.unblocked(start, self.in_unit_cube(targets) - start)

    def unblocked(
        self,
        origins: Float32Array,
        segments: Float32Array,
    ) -> BoolArray:
        """Answer `visible` in embree's own coordinates, ``(x - centre) * scale``: starts, segments (k, 3)."""
        reach = np.full(len(origins), SHADOW_SHARE, dtype=np.float32)
        return np.asarray(self._scene.run(origins, segments, dists=reach, query="OCCLUDED") < 0)

    def in_unit_cube(self, points: FloatArray) -> Float32Array:
        """Put points (k, 3), m, in embree's own coordinates, ``(x - centre) * scale``."""
        return np.asarray(_to_unit_cube(points, self.centre, self.scale))


def _least_heights(corners: FloatArray) -> FloatArray:
    """Least height (n,) in m of triangles (n, 3, 3) over one of their edges; tiny where there is no area."""
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    tiny = np.finfo(np.float64).tiny
    return np.asarray(np.maximum(2.0 * triangle_areas(corners) / np.maximum(longest, tiny), tiny))


@njit(**COMPILED)
def _to_unit_cube(points: FloatArray, centre: FloatArray, scale: float) -> Float32Array:
    """Recentre and scale in double precision, then round."""
    scaled = np.empty(points.shape, dtype=np.float32)
    for k in range(len(points)):
        for axis in range(3):
            scaled[k, axis] = (points[k, axis] - centre[axis]) * scale
    return scaled


@njit(**COMPILED)
def _land(
    hit: NDArray[np.int32],
    u: Float32Array,
    v: Float32Array,
    insets: FloatArray,
    backs: IntArray,
    corners: FloatArray,
    normals: FloatArray,
    origins: FloatArray,
    directions: FloatArray,
) -> tuple[IntArray, FloatArray, FloatArray, BoolArray]:
    """Find triangle, point, normal and side of each hit in double precision; see `Hits`."""
    count = len(hit)
    triangles = np.empty(count, dtype=np.int64)
    points = np.empty((count, 3))
    facing = np.zeros((count, 3))
    front = np.zeros(count, dtype=np.bool_)
    for k in range(count):
        t = hit[k]
        triangles[k] = t
        if t < 0:
            points[k] = origins[k]
            continue
        wb, wc = max(insets[t], float(u[k])), max(insets[t], float(v[k]))
        wa = max(insets[t], 1.0 - wb - wc)
        total = wa + wb + wc
        wa, wb, wc = wa / total, wb / total, wc / total
        along = 0.0
        for axis in range(3):
            points[k, axis] = wa * corners[t, 0, axis] + wb * corners[t, 1, axis] + wc * corners[t, 2, axis]
            along += directions[k, axis] * normals[t, axis]
        front[k] = along < 0.0
        side = 1.0 if front[k] else -1.0
        for axis in range(3):
            facing[k, axis] = side * normals[t, axis]
        if not front[k] and backs[t] >= 0:
            triangles[k], front[k] = backs[t], True
    return triangles, points, facing, front
