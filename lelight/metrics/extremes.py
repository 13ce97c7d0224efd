"""Least and greatest value over noisy points, by cross-fitting, with an error that means something.

The minimum of noisy estimates lies low: it picks the point whose noise is most negative. So the batches are
halved; each half is read at the place that is least in the other half, which knows nothing of its noise. The
mean of both readings is free of that bias, and its error is that of the readings within their halves. This
is repeated for a number of halvings, and value and variance are averaged. Where places are nearly level the
choice sometimes falls on the wrong one; the value then lies high by a fraction of its standard error.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lelight.metrics.figure import from_replicates, ratio
from lelight.scene import BoolArray, FloatArray

#: How it is said in a figure's method.
CROSS_FITTED = "place chosen by one half of the batches and read by the other, both ways, over 20 halvings"
#: Fewer batches cannot be halved and leave a spread in each half.
LEAST_BATCHES = 4
_HALVINGS = 20
_SEED = 12464

#: Estimate of one halving: from batches (R, k) and the half (R,) a batch is in, value and variance.
_Estimate = Callable[[FloatArray, BoolArray], tuple[float, float]]


def counted(batches: int) -> int:
    """Batches that a mean's error of the same degrees of freedom would come from: halving costs one more."""
    return batches - 1 if batches >= LEAST_BATCHES else batches


def least(batches: FloatArray) -> tuple[float, float | None]:
    """Least value over k points of batches (R, k) with its standard error, R - 2 degrees of freedom.

    With fewer than four batches it is the least of the means, biased low, with the jackknife's error.
    """
    if len(batches) < LEAST_BATCHES:
        return from_replicates(lambda e: float(e.min()), batches)
    return _over_halvings(batches, _least_of_halving)


def greatest(batches: FloatArray) -> tuple[float, float | None]:
    """Greatest value over k points of batches (R, k) with its standard error."""
    value, std_error = least(-batches)
    return -value, std_error


def least_over_mean(batches: FloatArray) -> tuple[float, float | None]:
    """Uniformity, least / mean, with the error of the ratio; NaN where the mean is not positive."""
    if not batches.mean() > 0:
        return math.nan, None
    if len(batches) < LEAST_BATCHES:
        return from_replicates(lambda e: ratio(e.min(), e.mean()), batches)
    return _over_halvings(
        batches, lambda each, half: _ratio(_readings(each, half), each.mean(axis=1), half=half)
    )


def least_over_greatest(batches: FloatArray) -> tuple[float, float | None]:
    """Diversity, least / greatest, with the error of the ratio; NaN where nothing is lit."""
    if not batches.mean(axis=0).max() > 0:
        return math.nan, None
    if len(batches) < LEAST_BATCHES:
        return from_replicates(lambda e: ratio(e.min(), e.max()), batches)
    return _over_halvings(
        batches, lambda each, half: _ratio(_readings(each, half), -_readings(-each, half), half=half)
    )


def _over_halvings(batches: FloatArray, estimate: _Estimate) -> tuple[float, float]:
    """Average value and variance over halvings that depend on the number of batches only."""
    generator = np.random.default_rng(_SEED)
    pattern = np.arange(len(batches)) % 2 == 0
    parts = [estimate(batches, generator.permutation(pattern)) for _ in range(_HALVINGS)]
    values, variances = np.array(parts).T
    return float(values.mean()), float(np.sqrt(variances.mean()))


def _least_of_halving(batches: FloatArray, half: BoolArray) -> tuple[float, float]:
    readings = _readings(batches, half)
    return _mean_of_halves(readings, half), _variance(readings, half)


def _readings(batches: FloatArray, half: BoolArray) -> FloatArray:
    """Each batch (R,) read at the point that is least in the other half's mean."""
    places = np.where(half, batches[~half].mean(axis=0).argmin(), batches[half].mean(axis=0).argmin())
    return np.asarray(batches[np.arange(len(batches)), places])


def _ratio(numerators: FloatArray, denominators: FloatArray, *, half: BoolArray) -> tuple[float, float]:
    """Ratio of two means over batches, its variance by the delta method on the paired batches."""
    bottom = _mean_of_halves(denominators, half)
    quotient = _mean_of_halves(numerators, half) / bottom
    return quotient, _variance((numerators - quotient * denominators) / bottom, half)


def _mean_of_halves(readings: FloatArray, half: BoolArray) -> float:
    return float(readings[half].mean() + readings[~half].mean()) / 2


def _variance(readings: FloatArray, half: BoolArray) -> float:
    """Variance of the mean of both halves' means."""
    parts = [readings[half], readings[~half]]
    return math.fsum(float(part.var(ddof=1)) / len(part) for part in parts) / 4
