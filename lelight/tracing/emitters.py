"""Everything that emits: luminous triangles and point luminaires, and how light is drawn from them.

Sources are numbered triangles first, then points. A source is drawn with a probability that follows what it
can give at the place in question, so that many lamps cost hardly more than one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lelight.channels import luminance_weights
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas, triangle_normals
from lelight.spectral.bands import emission_in_channels
from lelight.tracing.sampling import Vector
from lelight.tracing.triangles import (
    sample_triangle,
    triangle_density,
    triangle_irradiance,
    triangle_solid_angle,
)

#: Numbers in the sketch of a source.
SKETCH = 10

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


class Emitters(NamedTuple):
    """Sources as arrays, T triangles and P points, C channels.

    Attributes
    ----------
    corners : (T, 3, 3) float, m
    normals : (T, 3) float, unit, front side
    areas : (T,) float, m²
    luminance : (T, C) float, cd/m²
    both_sides : (T,) bool
    positions : (P, 3) float, m
    intensity : (P, C) float, cd
    power : (T + P,) float, lm of each source, luminance-weighted
    power_cdf : (T + P,) float, cumulative share of power
    weights : (C,) float, luminance weights of the channels
    of_triangle : (n_t,) int, number of the source that a scene triangle is, or -1
    sketch : (T + P, 10) float, what `rough_cdf` looks at: middle (3), normal (3), radius in m around it,
        area over pi in m², pi times the largest intensity, 1 where both sides emit; points have no normal,
        radius or area
    """

    corners: FloatArray
    normals: FloatArray
    areas: FloatArray
    luminance: FloatArray
    both_sides: BoolArray
    positions: FloatArray
    intensity: FloatArray
    power: FloatArray
    power_cdf: FloatArray
    weights: FloatArray
    of_triangle: IntArray
    sketch: FloatArray

    @property
    def flux(self) -> FloatArray:
        """(T + P, C) float, lm: luminous flux of each source and channel."""
        faces = np.where(self.both_sides, 2.0, 1.0) * math.pi * self.areas
        return np.concatenate([faces[:, None] * self.luminance, 4.0 * math.pi * self.intensity])


def collect_emitters(scene: Scene, channels: FloatArray) -> Emitters:
    """Gather the sources of a scene.

    Parameters
    ----------
    channels : (3, C) float; turns linear RGB into the channels that are carried
    """
    material_luminance = emission_in_channels(
        [m.luminance for m in scene.materials], [m.emission_spectrum for m in scene.materials], channels
    )
    emitting = np.flatnonzero(material_luminance[scene.triangle_materials].max(axis=1) > 0)
    both = np.array([m.emission_sides == "both" for m in scene.materials])
    corners = scene.corners[emitting]
    materials = scene.triangle_materials[emitting]
    of_triangle = np.full(len(scene.triangles), -1, dtype=np.int64)
    of_triangle[emitting] = np.arange(len(emitting))
    count = channels.shape[1]
    unweighted = Emitters(
        corners=corners,
        normals=triangle_normals(corners),
        areas=triangle_areas(corners),
        luminance=material_luminance[materials],
        both_sides=both[materials],
        positions=np.array([lamp.position for lamp in scene.luminaires]).reshape(-1, 3),
        intensity=emission_in_channels(
            [lamp.intensity for lamp in scene.luminaires],
            [lamp.spectrum for lamp in scene.luminaires],
            channels,
        ),
        power=np.empty(0),
        power_cdf=np.empty(0),
        weights=luminance_weights(count),
        of_triangle=of_triangle,
        sketch=np.empty((0, SKETCH)),
    )
    power = unweighted.flux @ unweighted.weights
    whole = unweighted._replace(power=power, power_cdf=np.cumsum(power) / power.sum())
    return whole._replace(sketch=_sketch(whole))


def _sketch(emitters: Emitters) -> FloatArray:
    """Boil each source down to ten numbers; see `Emitters`."""
    triangles = len(emitters.areas)
    sketch = np.zeros((len(emitters.power), SKETCH))
    middle = emitters.corners.mean(axis=1)
    sketch[:triangles, :3] = middle
    sketch[:triangles, 3:6] = emitters.normals
    sketch[:triangles, 6] = np.linalg.norm(emitters.corners - middle[:, None], axis=2).max(
        axis=1, initial=0.0
    )
    sketch[:triangles, 7] = emitters.areas / math.pi
    sketch[:triangles, 9] = emitters.both_sides
    sketch[triangles:, :3] = emitters.positions
    sketch[:triangles, 8] = emitters.power[:triangles] / np.where(emitters.both_sides, 2.0, 1.0)
    sketch[triangles:, 8] = emitters.power[triangles:] / 4.0
    return sketch


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
def _point_importance(
    sketch: FloatArray, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> float:
    """Illuminance in lx that a point source's sketch (10,) stands for."""
    dx, dy, dz = sketch[0] - x, sketch[1] - y, sketch[2] - z
    rise = dx * nx + dy * ny + dz * nz
    if rise <= 0.0:
        return 0.0
    square = dx * dx + dy * dy + dz * dz
    return float(sketch[8] * rise / (square * math.sqrt(square)))


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
            total += _point_importance(sketch[s], x, y, z, nx, ny, nz)
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
            p = source - triangles
            dx, dy, dz = (
                emitters.positions[p, 0] - x,
                emitters.positions[p, 1] - y,
                emitters.positions[p, 2] - z,
            )
            square = dx * dx + dy * dy + dz * dz
            cos_here = (dx * nx + dy * ny + dz * nz) / math.sqrt(square) if on_surface else 1.0
            if square > 0.0 and cos_here > 0.0:
                total += emitters.power[source] * cos_here / (4.0 * square)
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
    factor : float; times the source's luminance (triangle) or intensity (point) it is the radiance over the
        density of the draw: 1/density for a triangle, 1/distance² for a point, 0 where it does not shine here
    density : float, 1/sr; 0 for a point
    """
    triangles = len(emitters.areas)
    if source >= triangles:
        p = source - triangles
        dx, dy, dz = (
            emitters.positions[p, 0] - x,
            emitters.positions[p, 1] - y,
            emitters.positions[p, 2] - z,
        )
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        if distance == 0.0:
            return (1.0, 0.0, 0.0), (x, y, z), 0.0, 0.0
        d = (dx / distance, dy / distance, dz / distance)
        return d, _at(x, y, z, d, distance - 2.0 * offset), 1.0 / (distance * distance), 0.0
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
    """Luminance of a triangle (cd/m²) or intensity of a point (cd)."""
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
            p = source - triangles
            dx, dy, dz = (
                emitters.positions[p, 0] - x,
                emitters.positions[p, 1] - y,
                emitters.positions[p, 2] - z,
            )
            square = dx * dx + dy * dy + dz * dz
            # A place where a lamp hangs has no direction to it, and is given none of its light.
            factor = (
                max(0.0, dx * nx + dy * ny + dz * nz) / (square * math.sqrt(square)) if square > 0 else 0.0
            )
        for c in range(len(illuminance)):
            illuminance[c] += factor * source_strength(emitters, source, c)
