"""What a run's values say about exact ones: Student's t over many values, a tolerance, and enough precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from lelight.analytic.case import Case, Readings
from lelight.scene import FloatArray

Verdict = Literal["pass", "fail", "undecided"]

#: Probability with which a case whose reference is right is called wrong, over all the values it tests.
LEVEL = 1e-3
#: Places darker than this share of the case's mean are measured against it, not against themselves.
DARK_SHARE = 0.05
#: Relative error of arithmetic: what differs by less does not differ.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Judgement:
    """Readings with what follows from them, k values.

    Attributes
    ----------
    difference : (k,) float, share of the reference, signed
    std_error : (k,) float, share of the reference
    t : (k,) float, difference beyond the allowance over standard error; nan where nothing is sampled
    limit : float, largest |t| that is no contradiction
    verdicts : k of them
    """

    readings: Readings
    difference: FloatArray
    std_error: FloatArray
    t: FloatArray
    limit: float
    verdicts: tuple[Verdict, ...]

    @property
    def verdict(self) -> Verdict:
        """The worst of all."""
        for worst in ("fail", "undecided"):
            if worst in self.verdicts:
                return worst
        return "pass"


def student_limit(freedom: float, tested: int, *, level: float = LEVEL) -> float:
    """Two-sided limit of Student's t when so many values are tested at once (Šidák 1967)."""
    each = -np.expm1(np.log1p(-level) / tested)
    return float(stdtrit(freedom, 1.0 - each / 2.0))


def scale_of(reference: FloatArray) -> FloatArray:
    """Find what differences (k,) are measured against: the reference, or a share of its mean if that is more."""
    size = np.abs(reference)
    return np.asarray(np.maximum(size, DARK_SHARE * size.mean()))


def judge(case: Case, readings: Readings) -> Judgement:
    """Hold readings against the case's reference.

    A value fails where it differs by more than the tolerance, or by more standard errors than chance gives; it is
    undecided where its standard error is too large to tell.
    """
    scale = scale_of(readings.reference)
    difference = readings.found - readings.reference
    allowed = readings.allowance + ROUNDING * scale
    beyond = np.sign(difference) * np.maximum(np.abs(difference) - allowed, 0.0)
    sampled = readings.std_error > ROUNDING * scale
    t = np.full(len(scale), np.nan)
    t[sampled] = beyond[sampled] / readings.std_error[sampled]
    limit = student_limit(readings.freedom, readings.tested)
    noisy = ~(readings.std_error <= case.precision * readings.slack * scale)
    off = np.abs(beyond) > case.tolerance * readings.slack * scale
    # Too noisy to be held to the tolerance is not the same as wrong.
    wrong = (np.abs(np.nan_to_num(t)) > limit) | (off & ~noisy) | ~np.isfinite(readings.found)
    verdicts: list[Verdict] = [
        "fail" if bad else "undecided" if unsure else "pass" for bad, unsure in zip(wrong, noisy, strict=True)
    ]
    return Judgement(readings, difference / scale, readings.std_error / scale, t, limit, tuple(verdicts))


def noise(case: Case, readings: Readings) -> float:
    """Largest standard error against what the case asks for: 1 where it is just met."""
    scale = scale_of(readings.reference)
    return float(np.max(readings.std_error / (case.precision * readings.slack * scale)))
