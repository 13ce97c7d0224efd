"""Differences of two runs with their errors, and which of many differ at all.

Where replicate r of both runs used the same random numbers, the differences of the R pairs are a sample of their own:
its spread, with R - 1 degrees of freedom, is the error of the difference, and what chance did to both falls out.
Otherwise both errors add up (Welch 1947, Biometrika 34).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtr, stdtridf, stdtrit

from lelight.scene import BoolArray, FloatArray

#: Chance that a comparison in which nothing differs finds any difference.
FAMILY_LEVEL = 0.05
#: Differences below this share of their values are what is left of rounding to float32.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Difference:
    """Differences ``second - first`` of k quantities.

    Attributes
    ----------
    first, second, difference : (k,) float
    std_error : (k,) float, of the difference
    degrees_of_freedom : (k,) float
    """

    first: FloatArray
    second: FloatArray
    difference: FloatArray
    std_error: FloatArray
    degrees_of_freedom: FloatArray

    @property
    def p_values(self) -> FloatArray:
        """(k,) float: chance of a difference at least as large where there is none, Student, two-sided.

        Where nothing is random a difference is there (0) or not (1).
        """
        scale = np.maximum(np.abs(self.first), np.abs(self.second))
        certain = self.std_error <= ROUNDING * scale
        t = np.abs(self.difference) / np.where(certain, 1.0, self.std_error)
        there = np.abs(self.difference) > 10.0 * ROUNDING * scale
        return np.where(certain, np.where(there, 0.0, 1.0), 2.0 * stdtr(self.degrees_of_freedom, -t))

    @property
    def z(self) -> FloatArray:
        """(k,) float: the normal score of the same chance, signed, within ±37."""
        least = np.finfo(float).tiny
        return np.asarray(-np.sign(self.difference) * ndtri(np.clip(self.p_values, least, 1.0) / 2.0))

    def significant(self, among: int | None = None) -> BoolArray:
        """(k,) bool: which differ, by Šidák's level over ``among`` quantities (all k where not told)."""
        return np.asarray(self.p_values < sidak_level(len(self.difference) if among is None else among))

    def half_width_95(self) -> FloatArray:
        """(k,) float: half of each difference's 95 % interval."""
        return np.asarray(stdtrit(self.degrees_of_freedom, 0.975) * self.std_error)


def sidak_level(count: int, family: float = FAMILY_LEVEL) -> float:
    """Level of each of ``count`` tests such that all together err with chance ``family`` (Šidák 1967)."""
    return float(-np.expm1(np.log1p(-family) / max(count, 1)))


def paired(first: FloatArray, second: FloatArray) -> Difference:
    """Compare quantities whose replicates belong together.

    Parameters
    ----------
    first, second : (R, k) float, R at least 2
    """
    if first.shape != second.shape or len(first) < 2:
        raise ValueError(
            f"pairs need two replicates or more of one shape, found {first.shape}, {second.shape}"
        )
    each = second - first
    count = len(each)
    return Difference(
        first=first.mean(axis=0),
        second=second.mean(axis=0),
        difference=each.mean(axis=0),
        std_error=each.std(axis=0, ddof=1) / np.sqrt(count),
        degrees_of_freedom=np.full(each.shape[1], count - 1.0),
    )


def unpaired(first: FloatArray, second: FloatArray) -> Difference:
    """Compare quantities (R, k) and (S, k) whose replicates have nothing to do with each other."""
    if min(len(first), len(second)) < 2:
        raise ValueError(f"an error needs two replicates or more, found {len(first)} and {len(second)}")
    errors = [each.std(axis=0, ddof=1) / np.sqrt(len(each)) for each in (first, second)]
    freedom = [np.full(each.shape[1], len(each) - 1.0) for each in (first, second)]
    return of_estimates(first.mean(axis=0), second.mean(axis=0), *errors, *freedom)


def of_estimates(
    first: FloatArray,
    second: FloatArray,
    first_error: FloatArray,
    second_error: FloatArray,
    first_freedom: FloatArray,
    second_freedom: FloatArray,
) -> Difference:
    """Compare independent estimates (k,) by their standard errors (k,) and degrees of freedom (k,)."""
    variance = first_error**2 + second_error**2
    spread = first_error**4 / first_freedom + second_error**4 / second_freedom
    freedom = np.divide(variance**2, spread, out=np.minimum(first_freedom, second_freedom), where=spread > 0)
    return Difference(first, second, second - first, np.sqrt(variance), freedom)


def freedom_of(std_error: float, half_width_95: float) -> float:
    """Degrees of freedom by which a 95 % interval is so wide; inf where it is the normal one or there is no error."""
    ratio = half_width_95 / std_error if std_error > 0 else 0.0
    return float(stdtridf(0.975, ratio)) if ratio > -ndtri(0.025) * (1 + 1e-6) else np.inf


def rating_replicates(value: float, background: FloatArray) -> FloatArray:
    """Jackknife pseudo-values (R,) of a UGR whose background is the mean of ``background`` (R,).

    The sources are not random, so that it is ``value - 8 log10(background / mean background)``; the spread of the
    pseudo-values ``R f - (R - 1) f_r`` is that of f (Efron & Tibshirani 1993, equation 11.5). Here their mean is f.
    """
    count, mean = len(background), background.mean()
    without_each = (count * mean - background) / (count - 1)
    spread = 8.0 * (count - 1) * np.log10(without_each / mean)
    return np.asarray(value + spread - spread.mean())
