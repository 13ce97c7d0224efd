"""A figure: one number of a lighting design with its unit, its error and its verdict."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.special import ndtri, stdtrit

from lelight.scene import FloatArray

Verdict = Literal["pass", "fail", "undecided"]
Sense = Literal["at_least", "at_most"]


@dataclass(frozen=True)
class Figure:
    """A result that can be printed and judged; it never holds NaN or infinity.

    Attributes
    ----------
    value : None where the quantity is not defined, with the reason in ``note``
    unit : "1" for ratios and ratings
    std_error : one standard error, None where there is no estimate of it
    method : how the number came about
    verdict : None where there is no target
    clause : the requirement it is compared with, or the publication that defines it
    note : what a reader must know besides
    interval : ends of the 95 % interval, Student's; None without a standard error
    """

    value: float | None
    unit: str
    std_error: float | None
    method: str
    verdict: Verdict | None = None
    target: float | None = None
    clause: str = ""
    note: str = ""
    interval: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Refuse what JSON cannot hold and what nobody can read."""
        for name in ("value", "std_error", "target"):
            number = getattr(self, name)
            if number is not None and not math.isfinite(number):
                raise ValueError(f"{name} must be finite or None, found {number}")
        if self.interval is not None and not np.all(np.isfinite(self.interval)):
            raise ValueError(f"interval must be finite or None, found {self.interval}")

    def to_json(self) -> dict[str, Any]:
        """Object of ``metrics.json``; verdict and target are absent without a target, empty texts always."""
        numbers = {"value": self.value, "unit": self.unit, "std_error": self.std_error, "method": self.method}
        judged: dict[str, Any] = (
            {} if self.target is None else {"verdict": self.verdict, "target": self.target}
        )
        judged |= {} if self.interval is None else {"interval": list(self.interval)}
        texts = {"clause": self.clause, "note": self.note}
        return numbers | judged | {name: text for name, text in texts.items() if text}


def judge(
    value: float,
    std_error: float | None,
    *,
    target: float,
    sense: Sense,
    degrees_of_freedom: int | None = None,
) -> Verdict:
    """Compare a value with a requirement; undecided while its 95 % interval holds the target.

    Parameters
    ----------
    std_error : None (no estimate) leaves every comparison undecided
    degrees_of_freedom : of the standard error; the interval is then Student's, otherwise normal
    """
    if std_error is None:
        return "undecided"
    margin = value - target if sense == "at_least" else target - value
    half_width = half_width_95(std_error, degrees_of_freedom)
    if margin >= half_width:
        return "pass"
    return "fail" if margin < -half_width else "undecided"


def half_width_95(std_error: float, degrees_of_freedom: int | None) -> float:
    """Half of a 95 % interval: Student's, or the normal one without degrees of freedom."""
    quantile = ndtri(0.975) if degrees_of_freedom is None else stdtrit(degrees_of_freedom, 0.975)
    return float(quantile * std_error)


def from_replicates(
    function: Callable[[FloatArray], float], replicates: FloatArray
) -> tuple[float, float | None]:
    """Estimate a function of means, with the error of the function itself by the jackknife.

    The standard error is ``sqrt((R - 1) / R · sum (t_r - mean t)²)``, t_r the function of the mean without
    batch r (Efron & Tibshirani 1993, An Introduction to the Bootstrap, equation 11.5), so that a ratio or a
    logarithm gets its own error. Not for a minimum over noisy points, which lies low by about their noise:
    see `lelight.metrics.extremes`.

    Parameters
    ----------
    function : of an array shaped like one batch
    replicates : (R, ...) float, one independent batch of equal weight a row

    Returns
    -------
    value : the function of the mean over the batches
    std_error : None with fewer than two batches, or where the function is undefined without one of them
    """
    count = len(replicates)
    if count == 0 or not np.all(np.isfinite(replicates)):
        raise ValueError("replicates must hold at least one batch, and finite numbers only")
    value = float(function(replicates.mean(axis=0)))
    if count == 1:
        return value, None
    total = replicates.sum(axis=0)
    parts = np.array([function((total - batch) / (count - 1)) for batch in replicates])
    if not np.all(np.isfinite(parts)):
        return value, None
    return value, float(np.sqrt((count - 1) / count * np.sum((parts - parts.mean()) ** 2)))


def measured(
    function: Callable[[FloatArray], float],
    replicates: FloatArray,
    *,
    unit: str,
    method: str,
    clause: str = "",
    target: float | None = None,
    sense: Sense = "at_least",
    undefined: str = "",
    note: str = "",
) -> Figure:
    """Build the figure of a function of replicates.

    Parameters
    ----------
    function, replicates : as for `from_replicates`; a function that is not defined returns NaN
    undefined : the note of a figure without a value
    """
    value, std_error = from_replicates(function, replicates)
    return stated(
        value,
        std_error,
        batches=len(replicates),
        unit=unit,
        method=method,
        clause=clause,
        target=target,
        sense=sense,
        undefined=undefined,
        note=note,
    )


def stated(
    value: float,
    std_error: float | None,
    *,
    batches: int,
    unit: str,
    method: str,
    clause: str = "",
    target: float | None = None,
    sense: Sense = "at_least",
    undefined: str = "",
    note: str = "",
) -> Figure:
    """Build a figure from a value and its standard error over ``batches``: interval and verdict follow.

    Parameters
    ----------
    value : NaN where the quantity is not defined; ``undefined`` then becomes the note
    """
    if not math.isfinite(value):
        verdict: Verdict | None = None if target is None else "undecided"
        return Figure(None, unit, None, method, verdict, target, clause, undefined)
    interval = None
    if std_error is not None:
        half = half_width_95(std_error, batches - 1)
        interval = (value - half, value + half)
    if target is None:
        return Figure(value, unit, std_error, method, clause=clause, note=note, interval=interval)
    verdict = judge(value, std_error, target=target, sense=sense, degrees_of_freedom=batches - 1)
    return Figure(value, unit, std_error, method, verdict, target, clause, note, interval)


def ratio(numerator: float, denominator: float) -> float:
    """Quotient of two illuminances, NaN where nothing is to be divided by."""
    return float(numerator / denominator) if denominator > 0 else math.nan
