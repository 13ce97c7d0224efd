"""A point drawn on a triangle so that its direction from an eye is uniform in solid angle.

Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995. A triangle that is far, nearly flat or tiny on
the sphere is drawn by area instead, which is as even there and costs a fifth. Both come with their density in solid
angle.
"""

from __future__ import annotations

import math

from numba import njit

from lelight.compilation import LEAF
from lelight.scene import FloatArray
from lelight.tracing.sampling import Vector, solid_angle

#: Below this solid angle (sr) the inverse of Arvo's map loses digits, while area sampling is as even.
SMALL_SOLID_ANGLE = 1e-4
#: A triangle is far where even its nearest corner is farther than so many times its longest side.
FAR_SIDES = 4.0


@njit(**LEAF)
def _unit(x: float, y: float, z: float) -> Vector:
    s = 1.0 / math.sqrt(x * x + y * y + z * z)
    return x * s, y * s, z * s


@njit(**LEAF)
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**LEAF)
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(**LEAF)
def _reject(a: Vector, b: Vector) -> Vector:
    """Keep the unit part of a that is perpendicular to the unit vector b."""
    d = _dot(a, b)
    part: Vector = _unit(a[0] - d * b[0], a[1] - d * b[1], a[2] - d * b[2])
    return part


@njit(**LEAF)
def _clamped(x: float) -> float:
    return min(1.0, max(-1.0, x))


@njit(**LEAF)
def directions_to_corners(corners: FloatArray, x: float, y: float, z: float) -> tuple[Vector, Vector, Vector]:
    """Look from the point (x, y, z) to three corners (3, 3), along unit vectors."""
    a = _unit(corners[0, 0] - x, corners[0, 1] - y, corners[0, 2] - z)
    b = _unit(corners[1, 0] - x, corners[1, 1] - y, corners[1, 2] - z)
    c = _unit(corners[2, 0] - x, corners[2, 1] - y, corners[2, 2] - z)
    return a, b, c


@njit(**LEAF)
def triangle_solid_angle(corners: FloatArray, x: float, y: float, z: float) -> float:
    """Solid angle in sr of a triangle (3, 3) seen from a point."""
    a, b, c = directions_to_corners(corners, x, y, z)
    return float(solid_angle(a, b, c))


@njit(**LEAF)
def _arvo(a: Vector, b: Vector, c: Vector, area: float, u: float, v: float) -> Vector:
    n_ab, n_ca = _unit(*_cross(a, b)), _unit(*_cross(c, a))
    alpha = math.acos(_clamped(-_dot(n_ab, n_ca)))
    # The part area u * area, cut off by a great circle through b, ends at the point c' on the arc a c.
    s, t = math.sin(u * area - alpha), math.cos(u * area - alpha)
    cos_alpha, sin_alpha = math.cos(alpha), math.sin(alpha)
    p = t - cos_alpha
    q = s + sin_alpha * _dot(a, b)
    denominator = (q * s + p * t) * sin_alpha
    ratio = ((t * q - s * p) * cos_alpha - q) / denominator if denominator != 0.0 else 1.0
    ratio = _clamped(ratio)
    across = _reject(c, a)
    root = math.sqrt(1.0 - ratio * ratio)
    cut = (
        ratio * a[0] + root * across[0],
        ratio * a[1] + root * across[1],
        ratio * a[2] + root * across[2],
    )
    z = 1.0 - v * (1.0 - _dot(cut, b))
    side = _reject(cut, b)
    r = math.sqrt(max(0.0, 1.0 - z * z))
    return z * b[0] + r * side[0], z * b[1] + r * side[1], z * b[2] + r * side[2]


@njit(**LEAF)
def point_on_ray(
    corners: FloatArray, normal: FloatArray, x: float, y: float, z: float, direction: Vector
) -> float:
    """Where a ray from (x, y, z) meets the triangle's plane, as distance along the unit direction."""
    across = _dot(direction, (normal[0], normal[1], normal[2]))
    toward = (
        (corners[0, 0] - x) * normal[0] + (corners[0, 1] - y) * normal[1] + (corners[0, 2] - z) * normal[2]
    )
    return toward / across if across != 0.0 else -1.0


@njit(**LEAF)
def _by_area(
    corners: FloatArray, normal: FloatArray, area: float, x: float, y: float, z: float, u: float, v: float
) -> tuple[Vector, float, float]:
    root = math.sqrt(u)
    wa, wb, wc = 1.0 - root, root * (1.0 - v), root * v
    dx = wa * corners[0, 0] + wb * corners[1, 0] + wc * corners[2, 0] - x
    dy = wa * corners[0, 1] + wb * corners[1, 1] + wc * corners[2, 1] - y
    dz = wa * corners[0, 2] + wb * corners[1, 2] + wc * corners[2, 2] - z
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    d = (dx / distance, dy / distance, dz / distance)
    cos_away = abs(d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2])
    return d, distance, _density_by_area(area, distance, cos_away)


@njit(**LEAF)
def _far(corners: FloatArray, x: float, y: float, z: float) -> bool:
    """Say whether area is as good as solid angle, by sides and distances: a needle may be near with one end only."""
    least, longest = math.inf, 0.0
    for k in range(3):
        j = (k + 1) % 3
        away, side = 0.0, 0.0
        for axis in range(3):
            place = x if axis == 0 else (y if axis == 1 else z)
            away += (corners[k, axis] - place) ** 2
            side += (corners[j, axis] - corners[k, axis]) ** 2
        least, longest = min(least, away), max(longest, side)
    return least > FAR_SIDES * FAR_SIDES * longest


@njit(**LEAF)
def _even_solid_angle(corners: FloatArray, x: float, y: float, z: float) -> float:
    """Solid angle in sr over which a triangle is drawn evenly; 0 where it is drawn by area."""
    if _far(corners, x, y, z):
        return 0.0
    omega = triangle_solid_angle(corners, x, y, z)
    return float(omega) if omega >= SMALL_SOLID_ANGLE else 0.0


@njit(**LEAF)
def _density_by_area(area: float, distance: float, cos_away: float) -> float:
    return distance * distance / (area * cos_away) if cos_away > 0.0 else 0.0


@njit(**LEAF)
def sample_triangle(
    corners: FloatArray, normal: FloatArray, area: float, x: float, y: float, z: float, u: float, v: float
) -> tuple[Vector, float, float]:
    """Draw a direction from (x, y, z) to a triangle.

    Returns
    -------
    direction : unit 3-tuple
    distance : float, m
    density : float, 1/sr; 0 where the triangle cannot be drawn from here (seen edge on)
    """
    omega = _even_solid_angle(corners, x, y, z)
    if omega == 0.0:
        drawn: tuple[Vector, float, float] = _by_area(corners, normal, area, x, y, z, u, v)
        return drawn
    a, b, c = directions_to_corners(corners, x, y, z)
    d = _arvo(a, b, c, omega, u, v)
    distance = point_on_ray(corners, normal, x, y, z, d)
    if not (distance > 0.0 and distance < math.inf):
        return d, 0.0, 0.0
    return d, distance, 1.0 / omega


@njit(**LEAF)
def triangle_density(
    corners: FloatArray, normal: FloatArray, area: float, x: float, y: float, z: float, direction: Vector
) -> float:
    """Density in 1/sr with which `sample_triangle` draws a direction that meets the triangle."""
    omega = _even_solid_angle(corners, x, y, z)
    if omega > 0.0:
        return 1.0 / float(omega)
    distance = point_on_ray(corners, normal, x, y, z, direction)
    cos_away = abs(direction[0] * normal[0] + direction[1] * normal[1] + direction[2] * normal[2])
    return float(_density_by_area(area, distance, cos_away))


@njit(**LEAF)
def _edge_term(a: Vector, b: Vector, n: Vector) -> float:
    """Give one edge of Lambert's formula: angle between unit vectors times their plane's normal along n."""
    g = _cross(a, b)
    sine = math.sqrt(_dot(g, g))
    if sine == 0.0:
        return 0.0
    return math.atan2(sine, _dot(a, b)) * float(_dot(g, n)) / sine


@njit(**LEAF)
def _at_horizon(a: Vector, b: Vector, height_a: float, height_b: float) -> Vector:
    """Find the unit vector where the arc from a (above) to b (below) crosses the horizon."""
    t = height_a / (height_a - height_b)
    crossing: Vector = _unit(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]))
    return crossing


@njit(**LEAF)
def triangle_irradiance(
    corners: FloatArray, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> float:
    """Illuminance at a place from a triangle of unit luminance, the part below the horizon cut off.

    Lambert's formula, E = |sum over edges of angle x (edge normal . n)| / 2 (Lambert 1760; Arvo 1995, eq.
    3.9).
    """
    n = (nx, ny, nz)
    directions = directions_to_corners(corners, x, y, z)
    total = 0.0
    first_cut, second_cut, cuts = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0
    for k in range(3):
        a, b = directions[k], directions[(k + 1) % 3]
        height_a, height_b = _dot(a, n), _dot(b, n)
        if height_a > 0.0 and height_b > 0.0:
            total += _edge_term(a, b, n)
        elif height_a > 0.0:
            first_cut = _at_horizon(a, b, height_a, height_b)
            total += _edge_term(a, first_cut, n)
            cuts += 1
        elif height_b > 0.0:
            second_cut = _at_horizon(b, a, height_b, height_a)
            total += _edge_term(second_cut, b, n)
            cuts += 1
    if cuts == 2:
        total += _edge_term(first_cut, second_cut, n)
    return 0.5 * abs(total)
