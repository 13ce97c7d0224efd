"""Fronts of emitting faces, and whether anything stands before them that they could light."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_normals

#: A face with less free way than this share of the diagonal looks into a surface or out of the scene.
AT_ONCE = 0.01

#: Rays start this share of the diagonal before their face.
STAND_OFF = 1e-6


class Hits(Protocol):
    """Answer of a :class:`Caster`."""

    @property
    def triangle(self) -> IntArray:
        """(n,) int, -1 where a ray meets nothing."""


class Caster(Protocol):
    """Anything that finds the first triangle a ray meets."""

    def closest(self, origins: FloatArray, directions: FloatArray) -> Hits:
        """Cast rays from origins (n, 3) along unit directions (n, 3)."""


def blind_fronts(scene: Scene, faces: IntArray, *, caster: Caster | None = None) -> BoolArray:
    """Faces whose front lights nothing: it meets a surface at once, or looks out of the scene.

    A face looks out of the scene where its normal points away from the middle of the bounding box and
    nothing stands before it. Without a caster, what stands there is unknown, and only faces close to the
    box count.

    Parameters
    ----------
    faces : (n,) int, triangles of the scene

    Returns
    -------
    (n,) bool
    """
    corners = scene.corners[faces]
    centres, normals = corners.mean(axis=1), triangle_normals(corners)
    low, high = scene.corners.min(axis=(0, 1)), scene.corners.max(axis=(0, 1))
    outward = np.einsum("ij,ij->i", normals, centres - (low + high) / 2) > 0
    at_once = AT_ONCE * scene.diagonal
    if caster is None:
        return np.asarray(outward & (_way_out(centres, normals, low, high) < at_once))
    way = _free_way(scene, caster, centres, normals)
    return np.asarray((way < at_once) | (outward & np.isinf(way)))


def _way_out(origins: FloatArray, directions: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Distance (n,) at which rays from inside a box leave it, by its three slabs."""
    sides = np.where(directions > 0, high, low)
    distances = np.full_like(origins, np.inf)
    np.divide(sides - origins, directions, out=distances, where=np.abs(directions) > 1e-12)
    return np.asarray(distances.min(axis=1))


def _free_way(scene: Scene, caster: Caster, centres: FloatArray, normals: FloatArray) -> FloatArray:
    """Distance (n,) along the normals to the plane of the triangle that is met, infinite where none is."""
    origins = centres + STAND_OFF * scene.diagonal * normals
    hit = caster.closest(origins, normals).triangle
    met = scene.corners[hit]
    met_normals = triangle_normals(met)
    approach = np.einsum("ij,ij->i", met_normals, normals)
    offset = np.einsum("ij,ij->i", met_normals, met[:, 0] - origins)
    way = np.zeros(len(centres))
    np.divide(offset, approach, out=way, where=np.abs(approach) > 1e-12)
    return np.where(hit < 0, np.inf, way)
