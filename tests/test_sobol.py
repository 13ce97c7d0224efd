"""Scrambled Sobol points: the published sequence, scrambled so that each point is uniform and the net stays one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2, kstest, qmc

from lelight.tracing.sobol import DIGITS, MOST_DIMENSIONS, Stretch, direction_numbers, sobol

SEED = 3


def test_direction_numbers_give_the_points_that_scipy_gives_unscrambled():
    """SciPy reads the same file of Joe & Kuo; its points come in the order of Gray code too."""
    count = 512
    words = np.zeros((count, MOST_DIMENSIONS), dtype=np.uint64)
    for number in range(count):
        gray = number ^ (number >> 1)
        for digit in range(gray.bit_length()):
            if gray >> digit & 1:
                words[number] ^= direction_numbers()[:, digit]
    expected = qmc.Sobol(MOST_DIMENSIONS, scramble=False, bits=DIGITS).random(count)
    assert np.array_equal(words / 2.0**DIGITS, expected)


def test_points_are_balanced_in_every_dimension_and_repeatable():
    """2^k points put exactly one in each of 2^k equal intervals of each axis (a (0, k, 1)-net)."""
    points = sobol(29, Stretch.of(6), seed=(1, 2))
    assert points.shape == (64, 29)
    assert np.array_equal(np.sort(np.floor(points * 64), axis=0), np.tile(np.arange(64.0)[:, None], 29))
    assert np.array_equal(points, sobol(29, Stretch.of(6), seed=(1, 2)))
    assert not np.array_equal(points, sobol(29, Stretch.of(6), seed=(1, 3)))


def test_the_first_two_dimensions_are_a_net():
    """Every box of area 2^-8 that halving the unit square makes holds one of 256 points (a (0, 8, 2)-net)."""
    points = sobol(2, Stretch.of(8), seed=(SEED,))
    for across in range(9):
        box = np.floor(points * [2**across, 2 ** (8 - across)]).astype(int)
        assert len(np.unique(box[:, 0] * 2 ** (8 - across) + box[:, 1])) == 256


def test_a_sequence_that_doubles_and_goes_by_parts_is_the_same_sequence():
    whole = sobol(5, Stretch.of(7), seed=(4,))
    doubled = [sobol(5, Stretch.of(5, k), seed=(4,)) for k in range(3)]
    assert np.array_equal(np.concatenate(doubled), whole)
    parts = [sobol(5, part, seed=(4,)) for part in Stretch.of(6, 1).parts(24)]
    assert [len(part) for part in parts] == [24, 24, 16]
    assert np.array_equal(np.concatenate(parts), whole[64:])


def test_each_point_is_uniform_over_scrambles():
    """Kolmogorov-Smirnov for one number, chi-square for pairs of them; 1 of 1000 fails by chance."""
    scrambles = np.array([sobol(3, Stretch.of(2), seed=(SEED, k)) for k in range(8000)])
    assert kstest(scrambles[:, 1, 2], "uniform").pvalue > 1e-3
    for first, second in [
        (scrambles[:, 2, 0], scrambles[:, 2, 1]),
        (scrambles[:, 0, 2], scrambles[:, 3, 1]),
    ]:
        found, _, _ = np.histogram2d(first, second, bins=8, range=[[0, 1], [0, 1]])
        expected = len(scrambles) / found.size
        assert np.sum((found - expected) ** 2) / expected < chi2.ppf(0.999, found.size - 1)


def test_one_scramble_alone_is_not_uniform_enough_for_chance():
    """The net is far more even than independent points, which the test above would otherwise pass as well."""
    points = sobol(1, Stretch.of(12), seed=(SEED,))
    assert kstest(points[:, 0], "uniform").statistic <= 1.0 / 4096


def test_smooth_functions_are_integrated_better_than_by_chance():
    """The integral of a product of six linear factors is 1."""
    estimates = [
        np.prod(1.0 + 0.9 * (sobol(6, Stretch.of(8), seed=(SEED, k)) - 0.5), axis=1).mean()
        for k in range(200)
    ]
    by_chance = ((1.0 + 0.81 / 12.0) ** 6 - 1.0) / 256
    spread = np.var(estimates, ddof=1)
    assert abs(np.mean(estimates) - 1.0) < 4.0 * np.sqrt(spread / 200)
    assert spread < by_chance / 20


def test_more_dimensions_than_there_are_numbers_for_are_refused():
    with pytest.raises(ValueError, match=f"at most {MOST_DIMENSIONS}"):
        sobol(MOST_DIMENSIONS + 1, Stretch.of(2), seed=(1,))
