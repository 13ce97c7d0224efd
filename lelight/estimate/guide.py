"""Where light comes from at the nodes of the base field, by what its own rays saw: paths go there more often.

Directions over a surface are drawn from two uniform numbers by Malley's method; the unit square of those is cut into
cells of equal projected solid angle, and each cell is drawn in proportion to the light that came through it (the idea
of Lafortune & Willems 1995, A 5D tree to reduce the variance of Monte Carlo ray tracing, and of many since). Part of
the draws stays uniform, so nothing is missed and no weight is large.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lelight.compilation import COMPILED, LEAF
from lelight.mesh.neighbours import Alike
from lelight.receivers import Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.rays import Float32Array
from lelight.tracing.sight import Shares

#: Cells across each of the two numbers, where a place has sent out at least so many rays, as power of two.
SIDES = ((8, 24), (6, 16), (0, 8))
#: Share of draws that do not care where light comes from.
EVENLY = 0.2
#: Just below one.
_LAST = math.nextafter(1.0, 0.0)


@dataclass(frozen=True)
class Guide:
    """Densities of directions at places.

    Attributes
    ----------
    density : (n, s, s) float32, of each cell over that of the cosine law; mean 1 at every place. The first axis of
        cells is that of the number that gives the elevation, the second that of the azimuth
    rings : (n, s) float32, sums over the second
    places : where they hold, in the order of some of the rows
    rows : (m,) int, of the places
    sight : (n, S) uint8, share of each source's light that comes through there; S is 0 where there are too many
    """

    density: Float32Array
    rings: Float32Array
    places: Alike
    rows: IntArray
    sight: Shares

    @classmethod
    def of(
        cls,
        density: Float32Array,
        sight: Shares,
        points: FloatArray,
        normals: FloatArray,
        *,
        hidden: BoolArray,
    ) -> Guide:
        """Take what was found at places (n, 3), some of them hidden: see `densities` and `sight.shares`."""
        rows = np.flatnonzero(~hidden)
        return cls(density, density.sum(axis=2), Alike(points[rows], normals[rows]), rows, sight)

    def leading(self, receivers: Receivers) -> Receivers:
        """Tell receivers on surfaces which row is theirs."""
        rows = np.full(len(receivers), -1)
        some = np.flatnonzero(receivers.on_surface)
        rows[some] = self.at(receivers.points[some], receivers.normals[some])
        return replace(receivers, rows=rows)

    def at(self, points: FloatArray, normals: FloatArray) -> IntArray:
        """Row (k,) of the nearest place that faces as these points (k, 3) do; -1 where there is none."""
        if not len(self.rows):
            return np.full(len(points), -1)
        return np.asarray(self.rows[self.places.nearest(points, normals, 1)[:, 0]])


def sides_for(log2_rays: int) -> int:
    """Cells across each number for places that send out so many rays, as power of two.

    Measured by the variance of the near field: in a corridor 24 cells leave three quarters of what 16 leave, and 16 two
    thirds of what 8 leave; with a quarter of the rays more than 16 are worse than 16.
    """
    return next(sides for least, sides in SIDES if log2_rays >= least)


def tables(guide: Guide | None) -> tuple[Float32Array, Float32Array]:
    """Densities and rings of a guide, or of no place."""
    if guide is None:
        return np.zeros((0, 1, 1), dtype=np.float32), np.zeros((0, 1), dtype=np.float32)
    return guide.density, guide.rings


def densities(light: FloatArray, rays: NDArray[np.integer], around: IntArray) -> Float32Array:
    """Densities (n, s, s) by what few rays saw: places around share it, and so do cells with those beside them.

    Parameters
    ----------
    light : (n, s * s) float, in any unit, that came through each cell
    rays : (n, s * s) int, how many went there; light that is the same everywhere leaves directions even
    around : (n, k) int, places that share what they saw
    """
    sides = math.isqrt(rays.shape[1])
    density = np.empty((len(around), sides, sides), dtype=np.float32)
    _fill_densities(light, rays, around, density)
    return density


@njit(**COMPILED)
def _fill_densities(
    light: FloatArray, rays: NDArray[np.integer], around: IntArray, density: Float32Array
) -> None:
    sides, cells = density.shape[1], rays.shape[1]
    bright_scales, sent_scales = np.empty(len(rays)), np.empty(len(rays))
    for n in range(len(rays)):
        all_light, all_rays = 0.0, 0.0
        for cell in range(cells):
            all_light += light[n, cell]
            all_rays += rays[n, cell]
        sent_scales[n] = cells / all_rays
        bright_scales[n] = cells / all_light if all_light > 0.0 else 0.0
    bright, sent, scratch = np.empty(cells), np.empty(cells), np.empty(cells)
    for n in range(len(around)):
        bright[:], sent[:] = 0.0, 0.0
        for place in around[n]:
            # Where all is dark, light is expected wherever rays went.
            dark = bright_scales[place] <= 0.0
            for cell in range(cells):
                share = rays[place, cell] * sent_scales[place]
                sent[cell] += share
                bright[cell] += share if dark else light[place, cell] * bright_scales[place]
        _smooth(bright, scratch, sides)
        _smooth(sent, scratch, sides)
        total = 0.0
        for cell in range(cells):
            bright[cell] = bright[cell] / sent[cell] if sent[cell] > 0.0 else 1.0
            total += bright[cell]
        for i in range(sides):
            for j in range(sides):
                density[n, i, j] = EVENLY + (1.0 - EVENLY) * cells / total * bright[i * sides + j]


@njit(**LEAF)
def _smooth(values: FloatArray, scratch: FloatArray, sides: int) -> None:
    """Average cells (s * s,) with those beside them, half and half, in place: azimuths are a circle, elevations end."""
    for i in range(sides):
        below, above = max(i - 1, 0) * sides, min(i + 1, sides - 1) * sides
        for j in range(sides):
            own = values[i * sides + j]
            scratch[i * sides + j] = 0.5 * own + 0.25 * (values[below + j] + values[above + j])
    for i in range(sides):
        row = i * sides
        for j in range(sides):
            before, after = (j - 1) % sides, (j + 1) % sides
            values[row + j] = 0.5 * scratch[row + j] + 0.25 * (scratch[row + before] + scratch[row + after])


def cells_of(numbers: FloatArray, sides: int) -> IntArray:
    """Cell (k,) of pairs of uniform numbers (k, 2)."""
    ring, sector = np.minimum((numbers * sides).astype(np.int64), sides - 1).T
    return np.asarray(ring * sides + sector)


@njit(**LEAF)
def guided(
    density: Float32Array, rings: Float32Array, row: int, u: float, v: float
) -> tuple[float, float, float]:
    """Warp two uniform numbers to the densities of a row: the two, and the density there; no row changes nothing."""
    if row < 0 or len(density) == 0:
        return u, v, 1.0
    sides = rings.shape[1]
    left, ring, weight = u * (sides * sides), 0, 0.0
    for i in range(sides):
        weight, ring = rings[row, i], i
        if left < weight:
            break
        left -= weight
    u = min((ring + min(left / weight, 1.0)) / sides, _LAST)
    left, sector, own = v * weight, 0, 0.0
    for j in range(sides):
        own, sector = density[row, ring, j], j
        if left < own:
            break
        left -= own
    v = min((sector + min(left / own, 1.0)) / sides, _LAST)
    return u, v, own
