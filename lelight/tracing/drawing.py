"""How light is drawn from the sources: which one, and where on it.

A source is drawn with a probability that follows what it can give at the place in question, so that many lamps
cost hardly more than one.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from lelight.scene import FloatArray
from lelight.tracing.emitters import Emitters
from lelight.tracing.lamps import lamp_importance, toward_lamp, unshadowed_lamp
from lelight.tracing.sampling import Vector
from lelight.tracing.triangles import (
    sample_triangle,
    triangle_density,
    triangle_irradiance,
    triangle_solid_angle,
)

_COMPILED = {"cache": True, "nogil": True, "error_model": "numpy"}

#: Up to this many sources the choice follows each one's geometry; beyond it, its power alone.
LOCAL_CHOICE_LIMIT = 256
#: A triangle is far where its distance squared is this many times its area; there one point stands for it.
FAR = 25.0
#: Heights over a triangle's plane that are none: this share of its size, and this share of the coordinates,
#: which is a few dozen of their roundings. A lamp gives no light in its own plane.
FLAT, ROUNDING = 1e-9, 1e-14
#: Least cosine that a far triangle partly above the horizon is given, so that none is left out.
LOW = 0.1
#: Within this many radii of a triangle's middle, that middle says little: a place low over the plane may be lit
#: by the part next to it, however flat the middle is seen, and gets the least cosine.
NEAR = 2.0


@njit(**_COMPILED)
def _rough_importance(
    sketch: FloatArray, corners: FloatArray, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> float:
    """Illuminance in lx that a triangle's sketch (10,) stands for: exact when near, by its middle when not."""
    dx, dy, dz = sketch[0] - x, sketch[1] - y, sketch[2] - z
    rise = dx * nx + dy * ny + dz * nz
    if rise + sketch[6] <= 0.0:
        return 0.0
    square = dx * dx + dy * dy + dz * dz
    distance = math.sqrt(square)
    height = -(dx * sketch[3] + dy * sketch[4] + dz * sketch[5])
    if _in_plane(height, sketch[6], x, y, z) or (height < 0.0 and sketch[9] <= 0.0):
        return 0.0
    if distance < NEAR * sketch[6]:
        # A middle knows nothing of the near parts; by it the weight of a draw would have no bound.
        return float(sketch[8] / (math.pi * sketch[7]) * triangle_irradiance(corners, x, y, z, nx, ny, nz))
    cos_there, cos_here = abs(height) / distance, max(rise / distance, LOW)
    return float(sketch[8] * cos_there * cos_here / (square + sketch[7]))


@njit(**_COMPILED)
def _in_plane(height: float, size: float, x: float, y: float, z: float) -> bool:
    """Say whether rounding alone may have lifted a place to this height over a triangle's plane."""
    return abs(height) <= FLAT * size + ROUNDING * (abs(x) + abs(y) + abs(z))


@njit(**_COMPILED)
def _height(emitters: Emitters, source: int, x: float, y: float, z: float) -> float:
    """Height in m of a place over a triangle's plane, 0 in it and negative where it does not shine."""
    corners, normal = emitters.corners[source], emitters.normals[source]
    height = (
        (x - corners[0, 0]) * normal[0] + (y - corners[0, 1]) * normal[1] + (z - corners[0, 2]) * normal[2]
    )
    if _in_plane(height, math.sqrt(emitters.areas[source]), x, y, z):
        return 0.0
    return float(abs(height) if emitters.both_sides[source] else height)


@njit(**_COMPILED)
def rough_cdf(
    emitters: Emitters, x: float, y: float, z: float, nx: float, ny: float, nz: float, scratch: FloatArray
) -> bool:
    """Cumulative probabilities of the sources at a surface point, for paths, which draw once: cheap.

    Returns
    -------
    bool : False where no source can light this place
    """
    sketch, corners = emitters.sketch, emitters.corners
    if len(sketch) > LOCAL_CHOICE_LIMIT:
        scratch[:] = emitters.power_cdf
        return True
    total = 0.0
    for s in range(len(sketch)):
        if s < len(corners):
            total += _rough_importance(sketch[s], corners[s], x, y, z, nx, ny, nz)
        else:
            total += lamp_importance(emitters, s - len(corners), x, y, z, nx, ny, nz, True)
        scratch[s] = total
    if not total > 0.0:
        return False
    for s in range(len(sketch)):
        scratch[s] /= total
    return True


@njit(**_COMPILED)
def _triangle_importance(
    emitters: Emitters,
    source: int,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    on_surface: bool,
) -> float:
    """Illuminance from a triangle were nothing in between: exact when near, by one point when far."""
    corners, area = emitters.corners[source], emitters.areas[source]
    height = _height(emitters, source, x, y, z)
    if height <= 0.0:
        return 0.0
    brightness = emitters.power[source] / (2.0 * area if emitters.both_sides[source] else area)
    mx = (corners[0, 0] + corners[1, 0] + corners[2, 0]) / 3.0 - x
    my = (corners[0, 1] + corners[1, 1] + corners[2, 1]) / 3.0 - y
    mz = (corners[0, 2] + corners[1, 2] + corners[2, 2]) / 3.0 - z
    square = mx * mx + my * my + mz * mz
    if square < FAR * emitters.sketch[source, 6] ** 2:
        if on_surface:
            return float(brightness * triangle_irradiance(corners, x, y, z, nx, ny, nz))
        return float(brightness * triangle_solid_angle(corners, x, y, z))
    distance = math.sqrt(square)
    cos_here = 1.0
    if on_surface:
        cos_here = (mx * nx + my * ny + mz * nz) / distance
        if cos_here < LOW:
            if not _rises(corners, x, y, z, nx, ny, nz):
                return 0.0
            cos_here = LOW
    return float(brightness * area * height / (square * distance) * cos_here)


@njit(**_COMPILED)
def _rises(corners: FloatArray, x: float, y: float, z: float, nx: float, ny: float, nz: float) -> bool:
    """Say whether any corner stands above the horizon of a place."""
    highest = -math.inf
    for k in range(3):
        rise = (corners[k, 0] - x) * nx + (corners[k, 1] - y) * ny + (corners[k, 2] - z) * nz
        highest = max(highest, rise)
    return highest > 0.0


@njit(**_COMPILED)
def choice_cdf(
    emitters: Emitters,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    on_surface: bool,
    scratch: FloatArray,
) -> bool:
    """Cumulative probabilities of the sources at a place, for receivers, which draw often: close to ideal.

    Parameters
    ----------
    on_surface : bool; without a surface (nx, ny, nz) is not looked at
    scratch : (T + P,) float, overwritten

    Returns
    -------
    bool : False where no source can light this place
    """
    triangles = len(emitters.areas)
    count = len(emitters.power)
    if count > LOCAL_CHOICE_LIMIT:
        scratch[:] = emitters.power_cdf
        return True
    total = 0.0
    for source in range(count):
        if source < triangles:
            total += _triangle_importance(emitters, source, x, y, z, nx, ny, nz, on_surface)
        else:
            total += lamp_importance(emitters, source - triangles, x, y, z, nx, ny, nz, on_surface)
        scratch[source] = total
    if not total > 0.0:
        return False
    for source in range(count):
        scratch[source] /= total
    return True


@njit(**_COMPILED)
def chosen(cdf: FloatArray, u: float) -> tuple[int, float]:
    """Source whose share of [0, 1) holds u, and its probability."""
    source = min(int(np.searchsorted(cdf, u, side="right")), len(cdf) - 1)
    return source, cdf[source] - (cdf[source - 1] if source > 0 else 0.0)


@njit(**_COMPILED)
def toward(
    emitters: Emitters, source: int, x: float, y: float, z: float, u: float, v: float, offset: float
) -> tuple[Vector, Vector, float, float]:
    """Draw a direction to a source.

    Parameters
    ----------
    offset : float, m; how far off the source a shadow ray is to end

    Returns
    -------
    direction : unit 3-tuple, from (x, y, z) to the source
    end : 3-tuple, m; just before the source, where a shadow ray ends
    factor : float; times `source_strength` it is the radiance over the density of the draw: 1/density for a
        triangle, 1/distance² for a point, I/distance² for a photometric one, 0 where it does not shine here
    density : float, 1/sr; 0 for a point
    """
    triangles = len(emitters.areas)
    if source >= triangles:
        lamp: tuple[Vector, Vector, float, float] = toward_lamp(
            emitters, source - triangles, x, y, z, u, v, offset
        )
        return lamp
    direction, distance, density = sample_triangle(
        emitters.corners[source], emitters.normals[source], emitters.areas[source], x, y, z, u, v
    )
    normal = emitters.normals[source]
    away = direction[0] * normal[0] + direction[1] * normal[1] + direction[2] * normal[2]
    lift = -math.copysign(offset, away)
    end = _at(x, y, z, direction, distance)
    end = (end[0] + lift * normal[0], end[1] + lift * normal[1], end[2] + lift * normal[2])
    if density <= 0.0 or not shines(emitters, source, direction):
        return direction, end, 0.0, density
    return direction, end, 1.0 / density, density


@njit(**_COMPILED)
def _at(x: float, y: float, z: float, direction: Vector, distance: float) -> Vector:
    return x + distance * direction[0], y + distance * direction[1], z + distance * direction[2]


@njit(**_COMPILED)
def shines(emitters: Emitters, source: int, direction: Vector) -> bool:
    """Say whether a triangle emits against a direction that points at it."""
    away = (
        direction[0] * emitters.normals[source, 0]
        + direction[1] * emitters.normals[source, 1]
        + direction[2] * emitters.normals[source, 2]
    )
    return bool(away < 0.0 or (emitters.both_sides[source] and away > 0.0))


@njit(**_COMPILED)
def drawn_density(
    emitters: Emitters, cdf: FloatArray, source: int, x: float, y: float, z: float, direction: Vector
) -> float:
    """Density in 1/sr with which `chosen` and `toward` draw a direction that meets triangle ``source``."""
    share = cdf[source] - (cdf[source - 1] if source > 0 else 0.0)
    density = triangle_density(
        emitters.corners[source], emitters.normals[source], emitters.areas[source], x, y, z, direction
    )
    return float(share * density)


@njit(**_COMPILED)
def source_strength(emitters: Emitters, source: int, channel: int) -> float:
    """Luminance of a triangle (cd/m²), intensity of a point (cd) or factor of a photometric luminaire."""
    triangles = len(emitters.areas)
    if source < triangles:
        return float(emitters.luminance[source, channel])
    return float(emitters.intensity[source - triangles, channel])


@njit(**_COMPILED)
def unshadowed(
    emitters: Emitters, x: float, y: float, z: float, nx: float, ny: float, nz: float, illuminance: FloatArray
) -> None:
    """Add the illuminance (C,) in lx that all sources would give with nothing in between, in closed form."""
    triangles = len(emitters.areas)
    for source in range(len(emitters.power)):
        if source < triangles:
            if _height(emitters, source, x, y, z) <= 0.0:
                continue
            factor = triangle_irradiance(emitters.corners[source], x, y, z, nx, ny, nz)
        else:
            factor = unshadowed_lamp(emitters, source - triangles, x, y, z, nx, ny, nz)
        for c in range(len(illuminance)):
            illuminance[c] += factor * source_strength(emitters, source, c)


@njit(**_COMPILED)
def source_housing(emitters: Emitters, source: int) -> int:
    """Tell which surfaces do not block a source: those of this housing, 0 where all block."""
    triangles = len(emitters.areas)
    return int(emitters.housings[source - triangles]) if source >= triangles else 0
