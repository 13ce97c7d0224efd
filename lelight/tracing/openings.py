"""Luminous openings as rays meet them: bodies of the size that `Opening.projected_area` gives them.

They are not among the triangles: a ray that meets one before any surface sees L = I / A_projected.
"""

from __future__ import annotations

import numpy as np

from lelight.luminaires import PhotometricLuminaire
from lelight.photometry.opening import LEAST_AREA
from lelight.scene import BoolArray, FloatArray, IntArray, Scene
from lelight.tracing.world import World

#: Half the thickness of a flat opening, in ray offsets.
THICKNESS = 4.0

Interval = tuple[FloatArray, FloatArray]


def seen_openings(
    world: World, scene: Scene, origins: FloatArray, directions: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Find the rays (k, 3) that meet a luminous opening first.

    Returns
    -------
    rays : (m,) int, which rays do
    luminance : (m, C) float, cd/m²
    """
    nearest = np.full(len(origins), np.inf)
    luminance = np.zeros((len(origins), world.channels))
    for number, lamp in enumerate(scene.luminaires):
        if not isinstance(lamp, PhotometricLuminaire) or lamp.photometry.opening.size <= 0:
            continue
        entry = _entry(lamp, origins, directions, THICKNESS * world.caster.offset)
        met = np.flatnonzero(entry < nearest)
        met = met[_clear(world, number, origins[met], directions[met], entry[met])]
        nearest[met] = entry[met]
        luminance[met] = _luminances(world, number, lamp, -directions[met])
    rays = np.flatnonzero(np.isfinite(nearest))
    return rays, luminance[rays]


def _luminances(world: World, number: int, lamp: PhotometricLuminaire, leaving: FloatArray) -> FloatArray:
    """Luminance (m, C) in cd/m² toward directions (m, 3)."""
    angles = lamp.direction_angles(leaving)
    intensity = lamp.photometry.intensity(*angles)
    area = lamp.photometry.opening.projected_area(*angles)
    relative = np.divide(intensity, area, out=np.zeros_like(area), where=area > LEAST_AREA)
    return np.asarray(relative[:, None] * world.emitters.intensity[number])


def _clear(
    world: World, number: int, origins: FloatArray, directions: FloatArray, entry: FloatArray
) -> BoolArray:
    """Say for which rays nothing stands before the opening."""
    reach = np.maximum(entry - world.caster.offset, 0.0)
    ends = origins + reach[:, None] * directions
    housing = np.full(len(origins), world.emitters.housings[number])
    return world.visible(origins, ends, housing=housing)


def _entry(
    lamp: PhotometricLuminaire, origins: FloatArray, directions: FloatArray, thickness: float
) -> FloatArray:
    """Distance (k,) in m at which rays enter an opening from outside, inf where they do not."""
    opening = lamp.photometry.opening
    half = np.maximum(0.5 * np.array([opening.along_c0, opening.along_c90, opening.height]), thickness)
    start = (origins - lamp.position) @ lamp.axes.T / half
    along = directions @ lamp.axes.T / half
    near, far = np.full(len(start), -np.inf), np.full(len(start), np.inf)
    for interval in _intervals(opening.shape, start, along):
        near, far = np.maximum(near, interval[0]), np.minimum(far, interval[1])
    return np.where((near <= far) & (near > 0.0), near, np.inf)


def _intervals(shape: str, start: FloatArray, along: FloatArray) -> list[Interval]:
    """Parts of a ray within the bodies whose common part is the shape, scaled to half sizes of 1."""
    rounds = {"ellipse": [[0, 1]], "ellipsoid": [[0, 1, 2]], "tube_c0": [[1, 2]], "tube_c90": [[0, 2]]}
    flats = {"ellipse": [2], "ellipsoid": [], "tube_c0": [0], "tube_c90": [1]}
    found = [_within_round(start[:, axes], along[:, axes]) for axes in rounds.get(shape, [])]
    return found + [_within_slab(start[:, axis], along[:, axis]) for axis in flats.get(shape, [0, 1, 2])]


def _within_slab(start: FloatArray, along: FloatArray) -> Interval:
    """Part of a ray between -1 and 1 of one coordinate."""
    moving = np.abs(along) > 0.0
    slope = np.where(moving, along, 1.0)
    first, second = (-1.0 - start) / slope, (1.0 - start) / slope
    inside = np.abs(start) <= 1.0
    low = np.where(moving, np.minimum(first, second), np.where(inside, -np.inf, np.inf))
    return low, np.where(moving, np.maximum(first, second), np.where(inside, np.inf, -np.inf))


def _within_round(start: FloatArray, along: FloatArray) -> Interval:
    """Part of a ray within the unit circle or sphere of two or three coordinates."""
    a = np.einsum("kx,kx->k", along, along)
    b = np.einsum("kx,kx->k", start, along)
    moving = a > 0.0
    slope = np.where(moving, a, 1.0)
    # Nearest point of the ray's line to the axis: no difference of large numbers.
    nearest = start - (b / slope)[:, None] * along
    left = 1.0 - np.einsum("kx,kx->k", nearest, nearest)
    half = np.sqrt(np.maximum(left, 0.0) / slope)
    low = np.where(left >= 0.0, np.where(moving, -b / slope - half, -np.inf), np.inf)
    return low, np.where(left >= 0.0, np.where(moving, -b / slope + half, np.inf), -np.inf)
