"""Luminous intensity distributions as tables: looked up, and drawn from with density I / Φ in solid angle.

The intensity is bilinear in C and γ. A direction is drawn by inverting first the marginal in γ, whose density is
(mean intensity over C) x sin γ, then the piecewise linear density in C at that γ. The inverse is exact and
continuous, so even points stay even, and every direction drawn carries the same flux.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from lelight.compilation import LEAF
from lelight.photometry.photometry import Photometry
from lelight.photometry.zones import cumulative_flux
from lelight.scene import FloatArray, IntArray
from lelight.tracing.sampling import Vector

#: Halvings of a band in γ; the rest is below the rounding of an angle.
HALVINGS = 50
#: Finest step that decides how often a near opening is divided, rad.
FINEST_STEP = math.radians(0.5)


class Distributions(NamedTuple):
    """D tables behind one another.

    Attributes
    ----------
    first_c, count_c : (D,) int, where a table's C angles begin, and how many there are with the closing one
    first_gamma, count_gamma : (D,) int, likewise γ
    first : (D,) int, where its intensities begin, row by row of C
    c, gamma : float, rad
    candela : float, cd
    plane_cdf : float, like candela: integral over C up to a plane, cd rad, at each γ
    mean : float, like gamma: mean intensity over C, cd
    cdf : float, like gamma: share of the flux up to each γ
    flux : (D,) float, lm
    peak : (D,) float, cd, largest intensity
    step : (D,) float, rad, smallest step in γ that matters
    """

    first_c: IntArray
    count_c: IntArray
    first_gamma: IntArray
    count_gamma: IntArray
    first: IntArray
    c: FloatArray
    gamma: FloatArray
    candela: FloatArray
    plane_cdf: FloatArray
    mean: FloatArray
    cdf: FloatArray
    flux: FloatArray
    peak: FloatArray
    step: FloatArray


def collect_distributions(tables: Sequence[Photometry]) -> Distributions:
    """Put tables behind one another; those without light are there too and are never drawn."""
    parts = [_prepared(table) for table in tables]
    counts_c = np.array([len(part["c"]) for part in parts], dtype=np.int64)
    counts_gamma = np.array([len(part["gamma"]) for part in parts], dtype=np.int64)
    columns = {
        name: np.concatenate([np.zeros(0), *(part[name].ravel() for part in parts)])
        for name in ("c", "gamma", "candela", "plane_cdf", "mean", "cdf")
    }
    single = {name: np.array([float(part[name]) for part in parts]) for name in ("flux", "peak", "step")}
    return Distributions(
        first_c=_starts(counts_c),
        count_c=counts_c,
        first_gamma=_starts(counts_gamma),
        count_gamma=counts_gamma,
        first=_starts(counts_c * counts_gamma),
        **columns,
        **single,
    )


def _starts(counts: IntArray) -> IntArray:
    return np.asarray(np.cumsum(counts) - counts, dtype=np.int64)


def _prepared(table: Photometry) -> dict[str, FloatArray]:
    c, candela = table.closed()
    turn = np.radians(c)
    areas = 0.5 * np.diff(turn)[:, None] * (candela[1:] + candela[:-1])
    plane_cdf = np.concatenate([np.zeros((1, candela.shape[1])), np.cumsum(areas, axis=0)])
    mean = plane_cdf[-1] / (2.0 * math.pi)
    cumulative = cumulative_flux(table.gamma, mean)
    flux = cumulative[-1]
    steps = np.diff(np.radians(table.gamma))
    return {
        "c": turn,
        "gamma": np.radians(table.gamma),
        "candela": candela,
        "plane_cdf": plane_cdf,
        "mean": mean,
        "cdf": cumulative / flux if flux > 0 else np.ones_like(cumulative),
        "flux": flux,
        "peak": candela.max(),
        "step": np.array(max(FINEST_STEP, float(np.median(steps)) if len(steps) else math.pi)),
    }


@njit(**LEAF)
def _below(nodes: FloatArray, first: int, count: int, at: float) -> int:
    """Index of the last of ``count`` nodes that is not above ``at``, at most the last but one."""
    low, high = 0, count - 1
    while high - low > 1:
        middle = (low + high) // 2
        if nodes[first + middle] <= at:
            low = middle
        else:
            high = middle
    return low


@njit(**LEAF)
def table_intensity(d: Distributions, t: int, x: float, y: float, z: float) -> float:
    """Intensity in cd of table ``t`` along a unit direction in the luminaire's axes C0, C90, up."""
    # From both sine and cosine: near the axis the arc cosine alone loses half the digits.
    gamma = math.atan2(math.sqrt(x * x + y * y), -z)
    first, count = d.first_gamma[t], d.count_gamma[t]
    tiny = 1e-9
    if gamma < d.gamma[first] - tiny or gamma > d.gamma[first + count - 1] + tiny:
        return 0.0
    j = _below(d.gamma, first, count, gamma) if count > 1 else 0
    v = 0.0
    if count > 1:
        low, high = d.gamma[first + j], d.gamma[first + j + 1]
        v = min(1.0, max(0.0, (gamma - low) / (high - low)))
    start = d.c[d.first_c[t]]
    turn = math.atan2(y, x) - start
    turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi))
    i = _below(d.c, d.first_c[t], d.count_c[t], turn + start)
    left, right = d.c[d.first_c[t] + i], d.c[d.first_c[t] + i + 1]
    u = min(1.0, max(0.0, (turn + start - left) / (right - left)))
    k = d.first[t] + i * count + j
    next_ = 1 if count > 1 else 0
    here = d.candela[k] * (1.0 - v) + d.candela[k + next_] * v
    there = d.candela[k + count] * (1.0 - v) + d.candela[k + count + next_] * v
    return float(here * (1.0 - u) + there * u)


@njit(**LEAF)
def table_direction(d: Distributions, t: int, u: float, v: float) -> Vector:
    """Direction in the luminaire's axes with density I / Φ in solid angle."""
    gamma = _drawn_gamma(d, t, u)
    c = _drawn_c(d, t, gamma, v)
    sine = math.sin(gamma)
    return sine * math.cos(c), sine * math.sin(c), -math.cos(gamma)


@njit(**LEAF)
def _drawn_gamma(d: Distributions, t: int, u: float) -> float:
    """Angle whose share of the flux below it is ``u``."""
    first, count = d.first_gamma[t], d.count_gamma[t]
    j = _below(d.cdf, first, count, u)
    # Bands without light have no width in the cumulative share; the last one with light may end before the table.
    while j > 0 and d.cdf[first + j + 1] <= d.cdf[first + j]:
        j -= 1
    low, high = d.gamma[first + j], d.gamma[first + j + 1]
    m0, m1 = d.mean[first + j], d.mean[first + j + 1]
    slope = (m1 - m0) / (high - low)
    wanted = (u - d.cdf[first + j]) * d.flux[t] / (2.0 * math.pi)
    start = low
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        m = m0 + slope * (middle - start)
        part = m0 * math.cos(start) - m * math.cos(middle) + slope * (math.sin(middle) - math.sin(start))
        if part < wanted:
            low = middle
        else:
            high = middle
    return float(0.5 * (low + high))


@njit(**LEAF)
def _drawn_c(d: Distributions, t: int, gamma: float, v: float) -> float:
    """Angle C with density as the intensity at ``gamma``, which is linear between planes."""
    first, count = d.first_gamma[t], d.count_gamma[t]
    j = _below(d.gamma, first, count, gamma)
    share = (gamma - d.gamma[first + j]) / (d.gamma[first + j + 1] - d.gamma[first + j])
    planes = d.count_c[t]
    wanted = v * _at(d.plane_cdf, d.first[t] + (planes - 1) * count + j, share)
    low, high = 0, planes - 1
    while high - low > 1:
        middle = (low + high) // 2
        if _at(d.plane_cdf, d.first[t] + middle * count + j, share) <= wanted:
            low = middle
        else:
            high = middle
    here = _at(d.candela, d.first[t] + low * count + j, share)
    there = _at(d.candela, d.first[t] + (low + 1) * count + j, share)
    width = d.c[d.first_c[t] + low + 1] - d.c[d.first_c[t] + low]
    rest = wanted - _at(d.plane_cdf, d.first[t] + low * count + j, share)
    # Root of here s + (there - here) s² / (2 width) = rest, in the form that no cancellation spoils.
    root = here + math.sqrt(max(0.0, here * here + 2.0 * rest * (there - here) / width))
    moved = min(width, 2.0 * rest / root) if root > 0.0 else 0.5 * width
    return float(d.c[d.first_c[t] + low] + moved)


@njit(**LEAF)
def _at(column: FloatArray, k: int, share: float) -> float:
    return float(column[k] * (1.0 - share) + column[k + 1] * share)
