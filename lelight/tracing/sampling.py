"""Uniform numbers and the densities they are warped to.

Directions are in a local frame whose z axis is the normal; `to_axis` turns them. Every warp states its
density in the measure of solid angle. All functions of one sample are compiled, so that kernels can call
them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.scene import FloatArray

#: Three coordinates, as compiled functions hand them on.
Vector = tuple[float, float, float]


@njit(**LEAF)
def mix(key: np.uint64, counter: np.uint64) -> np.uint64:
    """Hash two 64-bit words into one (finaliser of SplitMix64; Steele, Lea, Flood 2014)."""
    z = np.uint64(key) ^ (np.uint64(counter) * np.uint64(0x9E3779B97F4A7C15))
    z += np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit(**LEAF)
def uniform(key: np.uint64, counter: np.uint64) -> float:
    """One number in [0, 1) that depends on its two arguments only."""
    return float(mix(key, counter) >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@njit(**LEAF)
def rotated(u: float, shift: float) -> float:
    """Cranley-Patterson rotation of one number in [0, 1)."""
    s = u + shift
    return s - 1.0 if s >= 1.0 else s


@njit(**LEAF)
def cosine_direction(u: float, v: float) -> Vector:
    """Direction on the hemisphere with density cos(theta)/pi (Malley's method)."""
    r = math.sqrt(u)
    phi = 2.0 * math.pi * v
    return r * math.cos(phi), r * math.sin(phi), math.sqrt(max(0.0, 1.0 - u))


@njit(**LEAF)
def lobe_direction(u: float, v: float, exponent: float) -> Vector:
    """Direction about z with density (n + 1)/(2 pi) cos^n (Lafortune & Willems 1994)."""
    cos_alpha = (1.0 - u) ** (1.0 / (exponent + 1.0))
    sin_alpha = math.sqrt(max(0.0, 1.0 - cos_alpha * cos_alpha))
    phi = 2.0 * math.pi * v
    return sin_alpha * math.cos(phi), sin_alpha * math.sin(phi), cos_alpha


@njit(**LEAF)
def sphere_direction(u: float, v: float) -> Vector:
    """Direction on the whole sphere with density 1/(4 pi)."""
    z = 1.0 - 2.0 * u
    r = math.sqrt(max(0.0, 1.0 - z * z))
    phi = 2.0 * math.pi * v
    return r * math.cos(phi), r * math.sin(phi), z


@njit(**LEAF)
def to_axis(x: float, y: float, z: float, ax: float, ay: float, az: float) -> Vector:
    """Turn a local direction so that z becomes the unit axis a (frame of Duff et al. 2017).

    The frame jumps where az is -1/4, not where it is 0 as there: walls stand upright, and rounding must not turn them.
    """
    sign = 1.0 if az >= -0.25 else -1.0
    a = -1.0 / (sign + az)
    b = ax * ay * a
    return (
        x * (1.0 + sign * ax * ax * a) + y * b + z * ax,
        x * sign * b + y * (sign + ay * ay * a) + z * ay,
        -x * sign * ax - y * ay + z * az,
    )


@njit(**LEAF)
def mirrored(dx: float, dy: float, dz: float, nx: float, ny: float, nz: float) -> Vector:
    """Mirror a direction that points away from the surface at the normal n."""
    twice = 2.0 * (dx * nx + dy * ny + dz * nz)
    return twice * nx - dx, twice * ny - dy, twice * nz - dz


@njit(**LEAF)
def solid_angle(a: Vector, b: Vector, c: Vector) -> float:
    """Solid angle of the triangle of three unit vectors (van Oosterom & Strackee 1983)."""
    triple = (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    bc = b[0] * c[0] + b[1] * c[1] + b[2] * c[2]
    ca = c[0] * a[0] + c[1] * a[1] + c[2] * a[2]
    return 2.0 * math.atan2(abs(triple), 1.0 + ab + bc + ca)


@njit(**COMPILED)
def cosine_directions(numbers: FloatArray, normals: FloatArray) -> FloatArray:
    """Directions (k, 3) about unit normals (k, 3) with density cos(theta)/pi, from uniform numbers (k, 2)."""
    directions = np.empty((len(normals), 3))
    for k in range(len(normals)):
        x, y, z = cosine_direction(numbers[k, 0], numbers[k, 1])
        directions[k] = to_axis(x, y, z, normals[k, 0], normals[k, 1], normals[k, 2])
    return directions
