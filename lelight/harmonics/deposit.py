"""Sums of harmonics over many contributions: the loop of `projection`, in step for a block of contributions.

One order m after the other climbs the recurrence of `basis` two degrees at a time. The innermost loops run over
contributions, so that processors work on several at once. They know the polynomials q_lm = s_lm p_lm but for their
scale, which leaves one product out and is multiplied to the sums:

    p_mm = 1,  p_l+1,m = z p_lm - b_lm / (a_lm a_l-1,m) p_l-1,m;   s_mm = q_mm,  s_l+1,m = a_lm s_lm.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.harmonics.basis import AHEAD, BEHIND, SECTORAL
from lelight.scene import FloatArray, IntArray

#: Contributions in step: as many as the first cache holds with all that is kept of each.
BLOCK = 512


def _unscaled() -> tuple[FloatArray, FloatArray]:
    """Factors b_lm / (a_lm a_l-1,m), and scales s_lm, at [m, l]; zero where l < m."""
    back, scale = np.zeros_like(AHEAD), np.zeros_like(AHEAD)
    for m in range(len(AHEAD)):
        back[m, m + 1 :] = BEHIND[m, m + 1 :] / (AHEAD[m, m + 1 :] * AHEAD[m, m:-1])
        scale[m, m:] = SECTORAL[m] * np.cumprod(np.concatenate([[1.0], AHEAD[m, m:-1]]))
    return back, scale


BACK, SCALE = _unscaled()

# Sums may be taken in another order than written, the same for the same contributions; nothing else is loosened.


@njit(**COMPILED)
def deposit(
    degree: int,
    offsets: IntArray,
    chosen: IntArray,
    columns: tuple[FloatArray, FloatArray, FloatArray],
    weights: FloatArray,
    out: FloatArray,
) -> None:
    """Add the contributions ``offsets[g]:offsets[g + 1]`` to the coefficients of each group g that is chosen.

    Parameters
    ----------
    degree : int, unchecked
    offsets : (groups + 1,) int
    chosen : (j,) int, groups
    columns : x, y and z (k,) of the unit directions, contiguous
    weights : (C, k) float, contiguous
    out : (groups, T, C) float, added to
    """
    x, y, z = columns
    channels = len(weights)
    cosine, sine, behind, here = np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK), np.empty(BLOCK)
    of_cosine, of_sine = np.empty((channels, BLOCK)), np.empty((channels, BLOCK))
    for g in chosen:
        for first in range(offsets[g], offsets[g + 1], BLOCK):
            last = min(first + BLOCK, offsets[g + 1])
            count = last - first
            cosine[:count], sine[:count] = 1.0, 0.0
            for m in range(degree + 1):
                for c in range(channels):
                    _times(weights[c][first:last], cosine, sine, of_cosine[c], of_sine[c])
                behind[:count], here[:count] = 0.0, 1.0
                _climb(degree, m, z[first:last], behind, here, of_cosine, of_sine, out[g])
                _turn(x[first:last], y[first:last], cosine, sine)


@njit(**COMPILED)
def _times(
    weights: FloatArray, cosine: FloatArray, sine: FloatArray, of_cosine: FloatArray, of_sine: FloatArray
) -> None:
    """Weigh Re and Im of (x + iy)^m."""
    for k in range(len(weights)):
        of_cosine[k], of_sine[k] = weights[k] * cosine[k], weights[k] * sine[k]


@njit(**COMPILED)
def _turn(x: FloatArray, y: FloatArray, cosine: FloatArray, sine: FloatArray) -> None:
    """Multiply (x + iy)^m once more."""
    for k in range(len(x)):
        turned = x[k] * cosine[k] - y[k] * sine[k]
        sine[k] = x[k] * sine[k] + y[k] * cosine[k]
        cosine[k] = turned


@njit(inline="always", **COMPILED)
def _climb(
    degree: int,
    m: int,
    z: FloatArray,
    behind: FloatArray,
    here: FloatArray,
    of_cosine: FloatArray,
    of_sine: FloatArray,
    out: FloatArray,
) -> None:
    """Add all degrees of one order; ``behind`` and ``here`` hold p_m-1,m = 0 and p_mm = 1, and are used up."""
    last_channel = len(of_cosine) - 1
    for ell in range(m, degree + 1, 2):
        back = BACK[m, ell]
        for c in range(last_channel):
            sums = _sums(back, z, behind, here, of_cosine[c], of_sine[c])
            _put(sums, degree, ell, m, c, out)
        back_above = BACK[m, ell + 1] if ell < degree else 0.0
        sums = _sums_and_climb(
            back, back_above, z, behind, here, of_cosine[last_channel], of_sine[last_channel]
        )
        _put(sums, degree, ell, m, last_channel, out)


@njit(inline="always", **COMPILED)
def _sums(
    back: float,
    z: FloatArray,
    behind: FloatArray,
    here: FloatArray,
    of_cosine: FloatArray,
    of_sine: FloatArray,
) -> tuple[float, float, float, float]:
    """Sum over the contributions for two degrees: cosine and sine of this one, and of the next."""
    cosine, sine, cosine_above, sine_above = 0.0, 0.0, 0.0, 0.0
    for k in range(len(z)):
        p = here[k]
        above = z[k] * p - back * behind[k]
        cosine += p * of_cosine[k]
        sine += p * of_sine[k]
        cosine_above += above * of_cosine[k]
        sine_above += above * of_sine[k]
    return cosine, sine, cosine_above, sine_above


@njit(inline="always", **COMPILED)
def _sums_and_climb(
    back: float,
    back_above: float,
    z: FloatArray,
    behind: FloatArray,
    here: FloatArray,
    of_cosine: FloatArray,
    of_sine: FloatArray,
) -> tuple[float, float, float, float]:
    """Do as `_sums`, and two steps of the recurrence."""
    cosine, sine, cosine_above, sine_above = 0.0, 0.0, 0.0, 0.0
    for k in range(len(z)):
        p = here[k]
        above = z[k] * p - back * behind[k]
        cosine += p * of_cosine[k]
        sine += p * of_sine[k]
        cosine_above += above * of_cosine[k]
        sine_above += above * of_sine[k]
        behind[k] = above
        here[k] = z[k] * above - back_above * p
    return cosine, sine, cosine_above, sine_above


@njit(**COMPILED)
def _put(
    sums: tuple[float, float, float, float], degree: int, ell: int, m: int, c: int, out: FloatArray
) -> None:
    """Add the sums of two degrees where they belong; at m = 0 there are no sines."""
    cosine, sine, cosine_above, sine_above = sums
    centre = ell * ell + ell
    out[centre + m, c] += SCALE[m, ell] * cosine
    if m > 0:
        out[centre - m, c] += SCALE[m, ell] * sine
    if ell < degree:
        centre += 2 * (ell + 1)
        out[centre + m, c] += SCALE[m, ell + 1] * cosine_above
        if m > 0:
            out[centre - m, c] += SCALE[m, ell + 1] * sine_above
