"""The point of a triangle that is closest to a given one, for compiled code."""

from __future__ import annotations

from numba import njit

from lelight.compilation import LEAF
from lelight.scene import FloatArray

Vector = tuple[float, float, float]


@njit(**LEAF)
def closest(x: float, y: float, z: float, corners: FloatArray, t: int) -> tuple[float, float, float]:
    """Squared distance to triangle ``t`` of (m, 3, 3) and the weights of its corners b and c at the nearest point.

    Ericson, "Real-Time Collision Detection" (2005), 5.1.5: by Voronoi regions of corners, edges and face. His
    differences of dot products are taken as the triple products they stand for, which needles need.
    """
    p = (x, y, z)
    a = (corners[t, 0, 0], corners[t, 0, 1], corners[t, 0, 2])
    b = (corners[t, 1, 0], corners[t, 1, 1], corners[t, 1, 2])
    c = (corners[t, 2, 0], corners[t, 2, 1], corners[t, 2, 2])
    ap, bp, cp = _towards(p, a), _towards(p, b), _towards(p, c)
    ab, ac = _towards(b, a), _towards(c, a)
    normal = _cross(ab, ac)
    d1, d2 = _dot(ab, ap), _dot(ac, ap)
    d3, d4 = _dot(ab, bp), _dot(ac, bp)
    d5, d6 = _dot(ab, cp), _dot(ac, cp)
    va, vb, vc = _dot(normal, _cross(bp, cp)), _dot(normal, _cross(cp, ap)), _dot(normal, _cross(ap, bp))
    if d1 <= 0.0 and d2 <= 0.0:
        wb, wc = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        wb, wc = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        wb, wc = 0.0, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        wb, wc = d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        wb, wc = 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        wc = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        wb = 1.0 - wc
    else:
        wb, wc = vb / (va + vb + vc), vc / (va + vb + vc)
    rest = (
        ap[0] - wb * ab[0] - wc * ac[0],
        ap[1] - wb * ab[1] - wc * ac[1],
        ap[2] - wb * ab[2] - wc * ac[2],
    )
    return _dot(rest, rest), wb, wc


@njit(**LEAF)
def _towards(end: Vector, start: Vector) -> Vector:
    """Vector from start to end."""
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


@njit(**LEAF)
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**LEAF)
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
