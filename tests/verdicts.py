"""Statistical verdicts: what a fixed seed's samples say about an expectation or a density.

A tolerance is never chosen here: it follows from the spread of the samples, their number and `LEVEL`.
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc, stdtrit

from lelight.scene import FloatArray

#: Probability with which one verdict calls a right answer wrong, over all values that it judges together. The
#: tests hold some fifty verdicts: about 5 % for all of them.
LEVEL = 1e-3
#: Cells that expect fewer samples than this are put together: chi-square needs about five (Cochran 1954).
LEAST_EXPECTED = 5.0
#: What a sum of integrated probabilities may be off from one.
QUADRATURE = 1e-3


def critical_t(degrees_of_freedom: FloatArray | float, values: int) -> FloatArray:
    """Two-sided limit of Student's t when ``values`` means are judged at once (Šidák 1967)."""
    each = 1.0 - (1.0 - LEVEL) ** (1.0 / values)
    return np.asarray(stdtrit(degrees_of_freedom, 1.0 - each / 2.0))


def agrees(replicates: FloatArray, expected: FloatArray | float, *, relative_error: float) -> bool:
    """Say whether independent estimates (R, k) have the expectations (k,), all of them.

    The test must have power: a standard error above ``relative_error`` of the expectation is an error.
    """
    mean, std_error = mean_and_error(replicates)
    expected = np.broadcast_to(expected, mean.shape)
    _demand_power(std_error, expected, relative_error)
    t = np.abs(mean - expected) / std_error
    return bool(np.all(t <= critical_t(len(replicates) - 1.0, mean.size)))


def same_mean(one: FloatArray, other: FloatArray, *, relative_error: float) -> bool:
    """Say whether two sets of independent estimates (R, k) have equal expectations (Welch's t-test)."""
    (mean_1, error_1), (mean_2, error_2) = mean_and_error(one), mean_and_error(other)
    std_error = np.hypot(error_1, error_2)
    _demand_power(std_error, mean_2, relative_error)
    # Welch-Satterthwaite degrees of freedom.
    freedom = std_error**4 / (error_1**4 / (len(one) - 1) + error_2**4 / (len(other) - 1))
    return bool(np.all(np.abs(mean_1 - mean_2) <= critical_t(freedom, mean_1.size) * std_error))


def mean_and_error(replicates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean (k,) and its standard error (k,) of independent estimates (R, k)."""
    count = len(replicates)
    return replicates.mean(axis=0), replicates.std(axis=0, ddof=1) / np.sqrt(count)


def chi_square_level(counts: FloatArray, probabilities: FloatArray) -> float:
    """Probability of counts (cells,) at least as far as these from what the cells' probabilities say.

    Probabilities must sum to one as nearly as they are integrated: a density that is off by a factor is an
    error, not a low level.
    """
    observed, shares = np.ravel(counts).astype(float), np.ravel(probabilities)
    np.testing.assert_allclose(shares.sum(), 1.0, rtol=QUADRATURE)
    expected = shares / shares.sum() * observed.sum()
    rare = expected < LEAST_EXPECTED
    if np.any(observed[shares <= 0.0]):
        return 0.0
    if rare.any():
        observed = np.append(observed[~rare], observed[rare].sum())
        expected = np.append(expected[~rare], expected[rare].sum())
        observed, expected = observed[expected > 0], expected[expected > 0]
    assert len(expected) > 1, "one cell tells nothing"
    statistic = float(np.sum((observed - expected) ** 2 / expected))
    return float(chdtrc(len(expected) - 1, statistic))


def follows(counts: FloatArray, probabilities: FloatArray) -> bool:
    """Say whether counts (cells,) are a draw from the cells' probabilities (Pearson's chi-square)."""
    return chi_square_level(counts, probabilities) > LEVEL


def _demand_power(std_error: FloatArray, expected: FloatArray, relative_error: float) -> None:
    assert np.all(std_error > 0), "no spread: compare deterministic results directly"
    assert np.all(std_error <= relative_error * np.abs(expected)), "too noisy to tell right from wrong"
