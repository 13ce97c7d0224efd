"""Configuration and form factors in closed form: what uniform Lambertian polygons give a point or a rectangle."""

from __future__ import annotations

import math

import numpy as np

from lelight.scene import FloatArray


def polygon_illuminance(
    points: FloatArray, normals: FloatArray, polygon: FloatArray, *, luminance: float
) -> FloatArray:
    """Illuminance (k,) in lx of points with normals (k, 3) in full view of a Lambertian polygon (j, 3).

    Lambert's formula (Photometria, 1760): E = L/2 sum of theta_i (n . g_i) over the edges, theta_i the angle
    an edge subtends and g_i the unit normal of the plane through edge and point. What lies below the
    point's horizon is cut off first. Which side of the polygon shines is not asked.
    """
    pairs = zip(np.atleast_2d(points), np.atleast_2d(normals), strict=True)
    return luminance * np.array([_projected_solid_angle(p, n, polygon) for p, n in pairs])


def _projected_solid_angle(point: FloatArray, normal: FloatArray, polygon: FloatArray) -> float:
    """Solid angle of a polygon, projected on the plane of ``normal`` (3,), in sr."""
    seen = _above_horizon(polygon - point, normal)
    if len(seen) < 3:
        return 0.0
    following = np.roll(seen, -1, axis=0)
    across = np.cross(seen, following)
    sine, cosine = np.linalg.norm(across, axis=1), np.einsum("kx,kx->k", seen, following)
    along = np.divide(across @ normal, sine, out=np.zeros(len(sine)), where=sine > 0)
    return abs(0.5 * float(np.arctan2(sine, cosine) @ along))


def _above_horizon(corners: FloatArray, normal: FloatArray) -> FloatArray:
    """Cut a polygon (k, 3) seen from the origin at the plane of ``normal`` (Sutherland & Hodgman 1974)."""
    height = corners @ normal
    kept = []
    for k in range(len(corners)):
        following = (k + 1) % len(corners)
        if height[k] >= 0:
            kept.append(corners[k])
        if (height[k] > 0) != (height[following] > 0) and height[k] != height[following]:
            share = height[k] / (height[k] - height[following])
            kept.append(corners[k] + share * (corners[following] - corners[k]))
    return np.array(kept).reshape(-1, 3)


def parallel_rectangles(a: float, b: float, distance: float) -> float:
    """Form factor between two equal rectangles a x b that face each other (Howell's catalogue, C-11)."""
    x, y = a / distance, b / distance
    root_x, root_y = math.hypot(1.0, x), math.hypot(1.0, y)
    logarithm = math.log(root_x * root_y / math.sqrt(1.0 + x * x + y * y))
    angles = x * root_y * math.atan(x / root_y) + y * root_x * math.atan(y / root_x)
    return 2.0 / (math.pi * x * y) * (logarithm + angles - x * math.atan(x) - y * math.atan(y))


def perpendicular_rectangles(width: float, height: float, common: float) -> float:
    """Form factor from a rectangle ``width`` x ``common`` to one ``height`` x ``common`` upright on it.

    They share the edge ``common`` (Howell's catalogue, C-14).
    """
    w, h = width / common, height / common
    w2, h2 = w * w, h * h
    both, all_ = w2 + h2, 1.0 + w2 + h2
    angles = w * math.atan(1.0 / w) + h * math.atan(1.0 / h)
    angles -= math.sqrt(both) * math.atan(1.0 / math.sqrt(both))
    logarithm = math.log((1.0 + w2) * (1.0 + h2) / all_)
    logarithm += w2 * math.log(w2 * all_ / ((1.0 + w2) * both))
    logarithm += h2 * math.log(h2 * all_ / ((1.0 + h2) * both))
    return (angles + 0.25 * logarithm) / (math.pi * w)
