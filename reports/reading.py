"""One figure of ``metrics.json`` with its error and verdict, and how it is printed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lelight.reports.rounding import COVERAGE_FACTOR, MISSING, NO_BREAK_SPACE, as_given, rounded_to, with_unit
from lelight.reports.texts import Texts
from lelight.reports.vocabulary import Term

#: CIE 117 is not meant for ratings below this; they are printed as "<10".
SMALLEST_UGR = 10.0
#: An interval below this share of its value is what is left of rounding.
NEGLIGIBLE = 1e-12


@dataclass(frozen=True)
class Reading:
    """A quantity that a run found.

    Attributes
    ----------
    value, half_width, target : float in ``unit``, or None where there is none; half of the 95 % interval
    verdict : ``pass``, ``fail``, ``undecided`` or None
    clause : document and clause that the target comes from
    note : why there is no value, or what must be known besides
    """

    key: str
    term: Term
    value: float | None
    unit: str
    half_width: float | None = None
    method: str = ""
    verdict: str | None = None
    verdict_text: str = ""
    target: float | None = None
    clause: str = ""
    note: str = ""

    @property
    def number(self) -> tuple[str, str]:
        """Value and ``± half width`` as printed, to the same decimal and without unit."""
        if self.value is None:
            return MISSING, ""
        if self.key.startswith("ugr") and self.value < SMALLEST_UGR:
            return "<10", ""
        value, half_width = rounded_to(self.value, self.half_width)
        return value, f"±{NO_BREAK_SPACE}{half_width}" if half_width else ""

    @property
    def text(self) -> str:
        """Value, error and unit in one line."""
        value, error = self.number
        return with_unit(f"{value}{NO_BREAK_SPACE}{error}" if error else value, self.unit)

    @property
    def requirement(self) -> str:
        """The target with its sense and unit, empty where nothing is required."""
        if self.target is None:
            return ""
        bound = "≥" if self.term.sense == "at least" else "≤"
        return with_unit(f"{bound}{NO_BREAK_SPACE}{as_given(self.target)}", self.unit)

    def row(self) -> dict[str, str]:
        """Cells of this figure in a table."""
        value, error = self.number
        return {
            "quantity": self.term.name,
            "symbol": self.term.symbol,
            "value": value,
            "error": error,
            "unit": self.unit,
            "requirement": self.requirement,
            "clause": self.clause,
            "note": self.note,
            "found": "" if self.value is None else "yes",
            "verdict": self.verdict or "",
            "verdict_text": self.verdict_text,
        }


def readings_of(entry: Mapping[str, Any], texts: Texts) -> tuple[Reading, ...]:
    """Pick the figures out of a subject's entry, in printing order."""
    keys = [key for key, figure in entry.items() if isinstance(figure, dict) and "value" in figure]
    return tuple(_reading(key, entry[key], texts) for key in sorted(keys, key=texts.rank))


def reading_named(readings: tuple[Reading, ...], key: str) -> Reading | None:
    """Find one quantity among a subject's figures."""
    return next((reading for reading in readings if reading.key == key), None)


def _reading(key: str, figure: Mapping[str, Any], texts: Texts) -> Reading:
    verdict = figure.get("verdict")
    return Reading(
        key=key,
        term=texts.term(key),
        value=_number(figure.get("value")),
        unit=_unit(figure.get("unit")),
        half_width=_half_width(figure),
        method=str(figure.get("method") or ""),
        verdict=verdict,
        verdict_text=texts.verdicts.get(str(verdict), ""),
        target=_number(figure.get("target")),
        clause=str(figure.get("clause") or ""),
        note=str(figure.get("note") or ""),
    )


def _half_width(figure: Mapping[str, Any]) -> float | None:
    """Half of the interval; of an older file without one, two standard errors."""
    interval = figure.get("interval")
    if isinstance(interval, list) and len(interval) == 2:
        low, high = map(_number, interval)
        if low is not None and high is not None:
            half_width = (high - low) / 2.0
            return 0.0 if half_width <= NEGLIGIBLE * abs(high) else half_width
    std_error = _number(figure.get("std_error"))
    return None if std_error is None else COVERAGE_FACTOR * std_error


def _number(found: object) -> float | None:
    if isinstance(found, bool) or not isinstance(found, int | float) or not math.isfinite(found):
        return None
    return float(found)


def _unit(found: object) -> str:
    """Print unit: none for a pure number, superscripts for powers."""
    unit = str(found or "")
    return "" if unit == "1" else unit.replace("m2", "m²")
