"""First page of a report: what it is about, what was found, and whether that is what was asked for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from datetime import datetime
from typing import Any

from lelight.reports.folder import ResultFolder, Subject
from lelight.reports.reading import Reading
from lelight.reports.rounding import MISSING

#: How figures are printed and judged.
ERROR_STATEMENT = (
    "± is two standard errors of the calculation, about 95 % confidence; values are rounded to it, and a "
    "figure without it has no estimate of its error. A requirement counts as passed or failed only where the "
    "whole 95 % interval lies on one side of it."
)

#: Figures on the first page whether they are required or not.
MAIN = frozenset({"mean_illuminance", "uniformity", "mean_cylindrical_illuminance", "ugr"})


def cover(folder: ResultFolder, *, title: str, author: str | None) -> dict[str, Any]:
    """Title block: project, scene, who, when and with what."""
    run = folder.run
    date = str(run.get("date") or "")
    facts = [
        ("Scene", str(run.get("scene") or MISSING)),
        ("Calculated", printed_date(date)),
        ("Program", f"lelight {run.get('lelight') or MISSING}"),
    ]
    named = [("Author", author)] if author else []
    return {"title": title, "author": author or "", "facts": [*named, *facts]}


def result_table(subjects: Sequence[Subject], *, kind: str) -> list[dict[str, Any]]:
    """Gather all figures for a table, one group a subject that has any."""
    return [_group(subject, subject.readings, kind) for subject in subjects if subject.readings]


def summary_table(subjects: Sequence[Subject], *, kind: str) -> list[dict[str, Any]]:
    """Gather the figures that matter first: what is required, and the main ones."""
    chosen = [
        (subject, [each for each in subject.readings if each.key in MAIN or each.target is not None])
        for subject in subjects
    ]
    return [_group(subject, readings, kind) for subject, readings in chosen if readings]


def verdict_sentence(subjects: Sequence[Subject]) -> str:
    """Say how many requirements are met, missed and open."""
    verdicts = Counter(
        reading.verdict
        for subject in subjects
        for reading in subject.readings
        if reading.verdict in {"pass", "fail", "undecided"}
    )
    total = verdicts.total()
    if not total:
        return "The scene file states no requirement."
    parts = [("pass", "passed"), ("fail", "failed"), ("undecided", "undecided within the error")]
    told = ", ".join(f"{verdicts[verdict]} {word}" for verdict, word in parts if verdicts[verdict])
    return f"{total} requirement{'s' if total > 1 else ''}: {told}."


def _group(subject: Subject, readings: Sequence[Reading], kind: str) -> dict[str, Any]:
    return {"kind": kind, "name": subject.name, "rows": [reading.row() for reading in readings]}


def printed_date(date: str) -> str:
    """Date and time to the minute, with the time zone where it was recorded."""
    try:
        return f"{datetime.fromisoformat(date):%Y-%m-%d %H:%M %Z}".rstrip()
    except ValueError:
        return date or MISSING
