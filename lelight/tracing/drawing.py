"""How light is drawn from the sources: which one, and where on it.

A source is drawn with a probability that follows what it can give at the place in question, so that many lamps
cost hardly more than one.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.scene import BoolArray, FloatArray
from lelight.tracing.distributions import table_intensity
from lelight.tracing.emitters import Emitters
from lelight.tracing.lamps import lamp_importance, seen_importance, unshadowed_lamp
from lelight.tracing.sampling import Vector
from lelight.tracing.sight import Shares, importance_in_sight
from lelight.tracing.triangles import (
    sample_triangle,
    triangle_density,
    triangle_irradiance,
    triangle_solid_angle,
)

#: Up to this many sources the choice follows each one's geometry; beyond it, its power alone.
LOCAL_CHOICE_LIMIT = 256
#: A triangle is far from a receiver at so many times the radius of its corners; there its middle stands for it.
FAR = 5.0
#: Heights over a triangle's plane that are none: this share of its size, and this share of the coordinates,
#: which is a few dozen of their roundings. A lamp gives no light in its own plane.
FLAT, ROUNDING = 1e-9, 1e-14
#: Least cosine that a far triangle partly above the horizon is given, so that none is left out.
LOW = 0.1
#: Within this many radii of a triangle's middle, that middle says little: a place low over the plane may be lit
#: by the part next to it, however flat the middle is seen, and gets the least cosine.
NEAR = 2.0


@njit(**LEAF)
def _rough_importances(
    sketch: FloatArray,
    near: float,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    out: FloatArray,
) -> None:
    """Write illuminances (T,) in lx that sketches of triangles stand for, by their middles; -1 within ``near`` radii.

    A middle knows nothing of the near parts; by it the weight of a draw would have no bound. Without branches, so
    that several triangles are done at a time.
    """
    rounding = ROUNDING * (abs(x) + abs(y) + abs(z))
    for s in range(sketch.shape[1]):
        dx, dy, dz = sketch[0, s] - x, sketch[1, s] - y, sketch[2, s] - z
        rise = dx * nx + dy * ny + dz * nz
        radius = sketch[6, s]
        square = dx * dx + dy * dy + dz * dz
        distance = math.sqrt(square)
        height = -(dx * sketch[3, s] + dy * sketch[4, s] + dz * sketch[5, s])
        over = abs(height)
        cos_here = rise / distance
        cos_here = cos_here if cos_here > LOW else LOW
        light = sketch[8, s] * (over / distance) * cos_here / (square + sketch[7, s])
        light = light if distance >= near * radius else -1.0
        shining = (rise + radius > 0.0) & (over > FLAT * radius + rounding)
        shining &= (height > 0.0) | (sketch[9, s] > 0.0)
        out[s] = light if shining else 0.0


@njit(**LEAF)
def _near_importance(
    sketch: FloatArray,
    corners: FloatArray,
    source: int,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
) -> float:
    """Illuminance in lx that the sketch of a triangle stands for, where the triangle is too near for its middle."""
    exact = triangle_irradiance(corners[source], x, y, z, nx, ny, nz)
    return float(sketch[8, source] / (math.pi * sketch[7, source]) * exact)


@njit(**LEAF)
def _in_plane(height: float, size: float, x: float, y: float, z: float) -> bool:
    """Say whether rounding alone may have lifted a place to this height over a triangle's plane."""
    return abs(height) <= FLAT * size + ROUNDING * (abs(x) + abs(y) + abs(z))


@njit(**LEAF)
def _height(emitters: Emitters, source: int, x: float, y: float, z: float) -> float:
    """Height in m of a place over a triangle's plane, 0 in it and negative where it does not shine."""
    corners, normal = emitters.corners[source], emitters.normals[source]
    height = (
        (x - corners[0, 0]) * normal[0] + (y - corners[0, 1]) * normal[1] + (z - corners[0, 2]) * normal[2]
    )
    if _in_plane(height, math.sqrt(emitters.areas[source]), x, y, z):
        return 0.0
    return float(abs(height) if emitters.both_sides[source] else height)


@njit(**COMPILED)
def rough_cdfs(emitters: Emitters, points: FloatArray, normals: FloatArray, cdfs: FloatArray) -> None:
    """Write cumulative probabilities (k, T + P) of the sources at surface points (k, 3), for paths: cheap.

    Paths draw once at a place. Rows end in 0 where no source can light a place. All places are done in one call:
    handing the emitters on costs more than a place does.
    """
    sketch, corners = emitters.sketch, emitters.corners
    triangles, count = len(corners), len(emitters.power)
    if count > LOCAL_CHOICE_LIMIT:
        cdfs[:] = emitters.power_cdf
        return
    positions, tables, axes, sizes = emitters.positions, emitters.tables, emitters.axes, emitters.sizes
    distributions, strengths = emitters.distributions, _strengths(emitters)
    for k in range(len(points)):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        nx, ny, nz = normals[k, 0], normals[k, 1], normals[k, 2]
        total = 0.0
        _rough_importances(sketch, NEAR, x, y, z, nx, ny, nz, cdfs[k])
        for s in range(triangles):
            light = cdfs[k, s]
            if light < 0.0:
                light = _near_importance(sketch, corners, s, x, y, z, nx, ny, nz)
            total += light
            cdfs[k, s] = total
        for p in range(count - triangles):
            dx, dy, dz = positions[p, 0] - x, positions[p, 1] - y, positions[p, 2] - z
            rise = dx * nx + dy * ny + dz * nz
            distance = max(math.sqrt(dx * dx + dy * dy + dz * dz), 1e-12)
            t, intensity, peak = tables[p], 1.0, 1.0
            if t >= 0:
                peak = distributions.peak[t]
                intensity = table_intensity(
                    distributions,
                    t,
                    -(dx * axes[p, 0, 0] + dy * axes[p, 0, 1] + dz * axes[p, 0, 2]) / distance,
                    -(dx * axes[p, 1, 0] + dy * axes[p, 1, 1] + dz * axes[p, 1, 2]) / distance,
                    -(dx * axes[p, 2, 0] + dy * axes[p, 2, 1] + dz * axes[p, 2, 2]) / distance,
                )
            total += strengths[p] * seen_importance(distance, rise, sizes[p], intensity, peak)
            cdfs[k, triangles + p] = total
        for s in range(count if total > 0.0 else 0):
            cdfs[k, s] /= total


@njit(**COMPILED)
def _strengths(emitters: Emitters) -> FloatArray:
    """Power over the flux of its table for each point (P,): what its intensities are multiplied by."""
    strengths = np.zeros(len(emitters.positions))
    for p in range(len(strengths)):
        t = emitters.tables[p]
        flux = 4.0 * math.pi if t < 0 else emitters.distributions.flux[t]
        if flux > 0.0:
            strengths[p] = emitters.power[len(emitters.areas) + p] / flux
    return strengths


@njit(**LEAF)
def _importance_in_space(emitters: Emitters, source: int, x: float, y: float, z: float) -> float:
    """Light in all directions from a triangle were nothing in between: exact when near, by one point when far."""
    corners, area = emitters.corners[source], emitters.areas[source]
    height = _height(emitters, source, x, y, z)
    if height <= 0.0:
        return 0.0
    brightness = emitters.power[source] / (2.0 * area if emitters.both_sides[source] else area)
    dx, dy, dz = (
        emitters.sketch[0, source] - x,
        emitters.sketch[1, source] - y,
        emitters.sketch[2, source] - z,
    )
    square = dx * dx + dy * dy + dz * dz
    if square < (FAR * emitters.sketch[6, source]) ** 2:
        return float(brightness * triangle_solid_angle(corners, x, y, z))
    return float(brightness * area * height / (square * math.sqrt(square)))


@njit(**LEAF)
def choice_cdf(
    emitters: Emitters,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    on_surface: bool,
    row: int,
    sight: Shares,
    scratch: FloatArray,
) -> bool:
    """Cumulative probabilities of the sources at a place, for receivers, which draw often: close to ideal.

    Parameters
    ----------
    on_surface : bool; without a surface (nx, ny, nz) is not looked at
    row : int, of ``sight`` (n, T + P) here, -1 where none is known
    scratch : (T + P,) float, overwritten

    Returns
    -------
    bool : False where no source can light this place
    """
    triangles = len(emitters.areas)
    count = len(emitters.power)
    if count > LOCAL_CHOICE_LIMIT:
        for source in range(count):
            scratch[source] = emitters.power_cdf[source]
        return True
    total = 0.0
    if on_surface:
        _rough_importances(emitters.sketch, FAR, x, y, z, nx, ny, nz, scratch)
    for source in range(count):
        if source < triangles and not on_surface:
            light = _importance_in_space(emitters, source, x, y, z)
        elif source < triangles:
            light = scratch[source]
            if light < 0.0:
                light = _near_importance(emitters.sketch, emitters.corners, source, x, y, z, nx, ny, nz)
        else:
            light = lamp_importance(emitters, source - triangles, x, y, z, nx, ny, nz, on_surface)
        total += light * importance_in_sight(sight, row, source)
        scratch[source] = total
    if not total > 0.0:
        return False
    for source in range(count):
        scratch[source] /= total
    return True


@njit(**LEAF)
def chosen(cdf: FloatArray, u: float) -> tuple[int, float]:
    """Source whose share of [0, 1) holds u, and its probability."""
    source = min(int(np.searchsorted(cdf, u, side="right")), len(cdf) - 1)
    return source, cdf[source] - (cdf[source - 1] if source > 0 else 0.0)


@njit(**LEAF)
def toward_face(
    corners: FloatArray,
    normals: FloatArray,
    areas: FloatArray,
    both_sides: BoolArray,
    s: int,
    x: float,
    y: float,
    z: float,
    u: float,
    v: float,
    offset: float,
) -> tuple[Vector, Vector, float, float]:
    """Draw a direction to triangle ``s``; `toward_lamp` does it for a point source.

    It takes single arrays of `Emitters`, since handing on all of them costs more than the draw.

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
    d, distance, density = sample_triangle(corners[s], normals[s], areas[s], x, y, z, u, v)
    nx, ny, nz = normals[s, 0], normals[s, 1], normals[s, 2]
    away = d[0] * nx + d[1] * ny + d[2] * nz
    lift = -math.copysign(offset, away)
    end = (
        x + distance * d[0] + lift * nx,
        y + distance * d[1] + lift * ny,
        z + distance * d[2] + lift * nz,
    )
    shining = away < 0.0 or (both_sides[s] and away > 0.0)
    return d, end, 1.0 / density if density > 0.0 and shining else 0.0, density


@njit(**LEAF)
def shines(emitters: Emitters, source: int, direction: Vector) -> bool:
    """Say whether a triangle emits against a direction that points at it."""
    away = (
        direction[0] * emitters.normals[source, 0]
        + direction[1] * emitters.normals[source, 1]
        + direction[2] * emitters.normals[source, 2]
    )
    return bool(away < 0.0 or (emitters.both_sides[source] and away > 0.0))


@njit(**LEAF)
def drawn_density(
    emitters: Emitters, cdf: FloatArray, source: int, x: float, y: float, z: float, direction: Vector
) -> float:
    """Density in 1/sr with which `chosen` and `toward_face` draw a direction that meets triangle ``source``."""
    share = cdf[source] - (cdf[source - 1] if source > 0 else 0.0)
    density = triangle_density(
        emitters.corners[source], emitters.normals[source], emitters.areas[source], x, y, z, direction
    )
    return float(share * density)


@njit(**LEAF)
def source_strength(emitters: Emitters, source: int, channel: int) -> float:
    """Luminance of a triangle (cd/m²), intensity of a point (cd) or factor of a photometric luminaire."""
    triangles = len(emitters.areas)
    if source < triangles:
        return float(emitters.luminance[source, channel])
    return float(emitters.intensity[source - triangles, channel])


@njit(**LEAF)
def add_unblocked(
    emitters: Emitters,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    control: FloatArray,
    illuminance: FloatArray,
) -> None:
    """Add the shares (T + P,) of what sources would give with nothing in between, in closed form: (C,) lx."""
    triangles = len(emitters.areas)
    for source in range(len(emitters.power)):
        if not control[source] > 0.0:
            continue
        if source < triangles:
            if _height(emitters, source, x, y, z) <= 0.0:
                continue
            factor = triangle_irradiance(emitters.corners[source], x, y, z, nx, ny, nz)
        else:
            factor = unshadowed_lamp(emitters, source - triangles, x, y, z, nx, ny, nz)
        for c in range(len(illuminance)):
            illuminance[c] += control[source] * factor * source_strength(emitters, source, c)


@njit(**LEAF)
def source_housing(emitters: Emitters, source: int) -> int:
    """Tell which surfaces do not block a source: those of this housing, 0 where all block."""
    triangles = len(emitters.areas)
    return int(emitters.housings[source - triangles]) if source >= triangles else 0
