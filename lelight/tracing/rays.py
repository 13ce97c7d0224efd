"""Rays against the scene's own triangles: the one place that knows embree and float32.

Embree computes in single precision and offers no near distance. The scene is therefore recentred and scaled
to the unit cube in double precision before it is handed over, origins are moved off their surface along the
normal by a few float32 steps of the scene's size, and points hit are computed again in double precision from
the triangle's own corners.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore import EmbreeDevice
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_normals

#: Single precision, in which embree computes.
Float32Array = NDArray[np.float32]

#: Distance from a surface at which rays start, as a share of half the scene's extent (about 60 float32
#: steps).
OFFSET_SHARE = 4e-6
#: Shadow rays stop this share of their length before the target.
SHADOW_SHARE = 1.0 - 1e-5


@dataclass(frozen=True)
class Hits:
    """First surfaces that rays meet.

    Attributes
    ----------
    triangle : (k,) int, -1 where the ray leaves the scene
    points : (k, 3) float, m; the ray's origin where nothing is hit
    """

    triangle: IntArray
    points: FloatArray


class RayCaster:
    """Embree's view of a triangle mesh; safe to call from several threads, each call runs in its own."""

    def __init__(self, vertices: FloatArray, triangles: IntArray) -> None:
        used = vertices[triangles.reshape(-1)]
        low, high = used.min(axis=0), used.max(axis=0)
        self.corners: FloatArray = vertices[triangles]
        self.normals: FloatArray = triangle_normals(self.corners)
        self.centre: FloatArray = 0.5 * (low + high)
        self.scale = 2.0 / float(np.max(high - low))
        self.offset = OFFSET_SHARE / self.scale
        # The device must outlive the scene that it made.
        self._device = EmbreeDevice()
        self._scene = EmbreeScene(self._device, robust=True)
        scaled = ((self.corners - self.centre) * self.scale).reshape(-1, 3).astype(np.float32)
        TriangleMesh(self._scene, scaled, np.arange(len(scaled), dtype=np.int32).reshape(-1, 3))

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
        found = self._scene.run(self._scaled(origins), directions.astype(np.float32), output=True)
        triangle = found["primID"].astype(np.int64)
        u, v = found["u"].astype(np.float64), found["v"].astype(np.float64)
        corners = self.corners[triangle]
        weights = np.stack([1.0 - u - v, u, v], axis=1)
        points = np.einsum("kc,kcx->kx", weights, corners)
        missed = triangle < 0
        points[missed] = origins[missed]
        return Hits(triangle, points)

    def leave(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Move surface points (k, 3) off their surface to the side that ``normals`` (k, 3) point to."""
        return points + self.offset * normals

    def visible(self, origins: FloatArray, targets: FloatArray) -> BoolArray:
        """Say for each pair of points (k, 3), m, already off their surfaces, whether nothing lies between."""
        start = self._scaled(origins)
        return self.unblocked(start, self._scaled(targets) - start)

    def unblocked(
        self,
        origins: Float32Array,
        segments: Float32Array,
    ) -> BoolArray:
        """Answer `visible` in embree's own coordinates, ``(x - centre) * scale``: starts, segments (k, 3)."""
        reach = np.full(len(origins), SHADOW_SHARE, dtype=np.float32)
        return np.asarray(self._scene.run(origins, segments, dists=reach, query="OCCLUDED") < 0)

    def _scaled(self, points: FloatArray) -> Float32Array:
        return ((points - self.centre) * self.scale).astype(np.float32)
