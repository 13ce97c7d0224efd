"""Least and greatest of noisy points: nearly unbiased, with intervals that hold the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import stdtrit

from lelight.metrics.extremes import greatest, least, least_over_greatest, least_over_mean

X, Y = np.meshgrid(np.linspace(-1, 1, 8), np.linspace(-1, 1, 8))
FIELDS = {
    "four corners alike": (500 - 100 * (X**2 + Y**2)).ravel(),
    "one dark corner": (500 - 100 * X - 60 * Y - 80 * X**2).ravel(),
    "all alike": np.full(64, 500.0),
    "a slope": (500 - 30 * X).ravel(),
}
REPETITIONS = 200


def batches_of(truth, generator, *, count, noise):
    """Batches whose mean has a relative standard error of ``noise``, half of its variance in common."""
    own = generator.normal(size=(count, len(truth)))
    common = generator.normal(size=(count, 1))
    return truth * (1 + noise * math.sqrt(count) * (own + common) / math.sqrt(2))


def hits(function, truth, exact, *, count, noise, seed=5):
    """Share of repetitions whose 95 % interval holds the exact value, and the mean error in its own errors."""
    generator = np.random.default_rng(seed)
    quantile = stdtrit(count - 2, 0.975)
    found = [function(batches_of(truth, generator, count=count, noise=noise)) for _ in range(REPETITIONS)]
    off = np.array([(value - exact) / std_error for value, std_error in found])
    return float(np.mean(np.abs(off) <= quantile)), float(np.mean(off))


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize(("count", "noise"), [(8, 0.01), (16, 0.03)])
def test_intervals_hold_the_least(name, count, noise):
    # Binomial standard error of 95 % in 200: 1.5 %; four of them below, and the halvings err to the safe side.
    truth = FIELDS[name]
    share, bias = hits(least, truth, truth.min(), count=count, noise=noise)
    assert share >= 0.95 - 4 * 0.0154
    assert abs(bias) < 0.5


@pytest.mark.parametrize("name", ["four corners alike", "one dark corner"])
def test_intervals_hold_the_ratios_and_the_greatest(name):
    truth = FIELDS[name]
    for function, exact in (
        (least_over_mean, truth.min() / truth.mean()),
        (least_over_greatest, truth.min() / truth.max()),
        (greatest, truth.max()),
    ):
        share, _ = hits(function, truth, exact, count=12, noise=0.02)
        assert share >= 0.95 - 4 * 0.0154


def test_the_plain_minimum_fails_this_test():
    # What is corrected here: the least of the means with the error of its own point.
    def plain(batches):
        place = batches.mean(axis=0).argmin()
        own = batches[:, place]
        return own.mean(), own.std(ddof=1) / math.sqrt(len(own))

    truth = FIELDS["all alike"]
    share, bias = hits(plain, truth, 500.0, count=12, noise=0.02)
    assert share < 0.8
    assert bias < -1.0


def test_without_noise_the_extremes_are_exact():
    batches = np.tile(FIELDS["one dark corner"], (6, 1))
    truth = batches[0]
    assert least(batches) == (pytest.approx(truth.min(), rel=1e-12), pytest.approx(0.0, abs=1e-9))
    assert greatest(batches)[0] == pytest.approx(truth.max(), rel=1e-12)
    assert least_over_mean(batches)[0] == pytest.approx(truth.min() / truth.mean(), rel=1e-12)
    assert least_over_greatest(batches)[0] == pytest.approx(truth.min() / truth.max(), rel=1e-12)


def test_few_batches_fall_back_on_the_jackknife():
    batches = np.array([[1.0, 3.0], [3.0, 5.0]])
    assert least(batches) == (2.0, pytest.approx(1.0))
    assert least(batches[:1]) == (1.0, None)


def test_the_dark_has_no_ratio():
    assert math.isnan(least_over_mean(np.zeros((6, 4)))[0])
    assert math.isnan(least_over_greatest(np.zeros((6, 4)))[0])
