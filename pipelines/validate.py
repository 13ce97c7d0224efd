"""``lelight validate``: every case with a known answer, computed and judged."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from fnmatch import fnmatchcase
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import lelight
from lelight.analytic.case import Case
from lelight.analytic.catalogue import cases
from lelight.analytic.verdicts import LEVEL, Judgement, Verdict, judge, noise
from lelight.calculation import calculate
from lelight.settings import Settings
from lelight.versions import package_versions
from lelight.writing.files import make_folder, write_text

#: Runs of a case until it is as precise as it asks for; each aims at what the one before missed.
MOST_RUNS = 5
#: How much better than needed the next run aims, and the least share of a target it may go down to.
MARGIN, LEAST_STEP = 0.75, 0.25


@dataclass(frozen=True)
class Outcome:
    """A case, what was found, and what it took: seconds and rays of all runs."""

    case: Case
    judgement: Judgement
    seconds: float
    rays: int
    runs: int

    @property
    def verdict(self) -> Verdict:
        """The worst of all values."""
        return self.judgement.verdict


def chosen_cases(*, full: bool, only: str = "*") -> list[Case]:
    """Find the cases whose name matches a shell pattern."""
    return [case for case in cases(full=full) if fnmatchcase(case.name, only)]


def outcomes(chosen: list[Case], *, seed: int = 0, threads: int = 0) -> Iterator[Outcome]:
    """Compute cases one after the other."""
    for case in chosen:
        yield run_case(case, seed=seed, threads=threads)


def run_case(case: Case, *, seed: int = 0, threads: int = 0) -> Outcome:
    """Compute a case until its values are as precise as it asks for, and judge them.

    Only the standard error decides on another run, never the value.
    """
    started = perf_counter()
    target, rays, runs = case.target, 0, 0
    while True:
        run = calculate(
            case.scene,
            Settings(edge=case.edge, target=target, estimator=case.estimator, seed=seed, threads=threads),
        )
        readings = case.read(run)
        rays, runs = rays + run.replicates.rays, runs + 1
        excess = noise(case, readings)
        if excess <= 1.0 or runs == MOST_RUNS:
            return Outcome(case, judge(case, readings), perf_counter() - started, rays, runs)
        target *= max(LEAST_STEP, MARGIN / excess)


def overall(found: list[Outcome]) -> Verdict:
    """Find the worst verdict of all cases."""
    worst = {outcome.verdict for outcome in found}
    return "fail" if "fail" in worst else "undecided" if "undecided" in worst else "pass"


def validation_record(found: list[Outcome], *, full: bool, seed: int) -> dict[str, Any]:
    """Gather everything, ready for JSON; numbers that are not there are null."""
    return {
        "lelight": lelight.__version__,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "full": full,
        "seed": seed,
        "level": LEVEL,
        "verdict": overall(found),
        "seconds": round(sum(outcome.seconds for outcome in found), 3),
        "cases": [_case_record(outcome) for outcome in found],
        "versions": package_versions(),
    }


def _case_record(outcome: Outcome) -> dict[str, Any]:
    case, judgement = outcome.case, outcome.judgement
    readings = judgement.readings
    return {
        "name": case.name,
        "group": case.group,
        "title": case.title,
        "basis": case.basis,
        "quantity": case.quantity,
        "unit": case.unit,
        "estimator": case.estimator,
        "tolerance": case.tolerance,
        "precision": case.precision,
        "degrees_of_freedom": readings.freedom,
        "tested": readings.tested,
        "t_limit": judgement.limit,
        "verdict": outcome.verdict,
        "seconds": round(outcome.seconds, 3),
        "rays": outcome.rays,
        "runs": outcome.runs,
        "points": [_point_record(case, judgement, k) for k in range(len(readings.labels))],
    }


def _point_record(case: Case, judgement: Judgement, k: int) -> dict[str, Any]:
    readings = judgement.readings
    return {
        "label": readings.labels[k],
        "value": _number(readings.found[k]),
        "reference": _number(readings.reference[k]),
        "allowance": _number(readings.allowance[k]),
        "std_error": _number(readings.std_error[k]),
        "tolerance": case.tolerance * float(readings.slack[k]),
        "relative_difference": _number(judgement.difference[k]),
        "relative_std_error": _number(judgement.std_error[k]),
        "t": _number(judgement.t[k]),
        "verdict": judgement.verdicts[k],
    }


def _number(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None


def write_record(out: Path, record: dict[str, Any]) -> Path:
    """Write ``validation.json`` into a folder, made where it is missing."""
    path = make_folder(out) / "validation.json"
    write_text(path, json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    return path


def table_lines(outcome: Outcome) -> list[str]:
    """One case as text: a heading, and a line for each value."""
    case, judgement = outcome.case, outcome.judgement
    readings = judgement.readings
    heading = f"{case.name}: {case.group}, {case.title}"
    note = f"  {case.basis}; tolerance {case.tolerance:.1%}, |t| up to {judgement.limit:.1f}"
    columns = (
        f"  {'':34} {case.unit:>12} {'reference':>12} {'difference':>10} {'std error':>9} {'t':>6}  verdict"
    )
    lines = [
        f"  {label:34} {readings.found[k]:12.6g} {readings.reference[k]:12.6g} "
        f"{_percent(judgement.difference[k], 3):>10} {_percent(judgement.std_error[k], 3).lstrip('+'):>9} "
        f"{_t(judgement.t[k]):>6}  {judgement.verdicts[k]}"
        for k, label in enumerate(readings.labels)
    ]
    return [heading, note, columns, *lines, f"  {outcome.verdict} in {outcome.seconds:.1f} s", ""]


def _percent(share: float, decimals: int) -> str:
    # Adding zero turns a rounded -0 into 0.
    return f"{round(100.0 * share, decimals) + 0.0:+.{decimals}f} %"


def _t(t: float) -> str:
    return f"{t:.1f}" if np.isfinite(t) else "-"
