"""First page of a report: what it is about, what was found, and whether that is what was asked for."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Sequence
from datetime import datetime
from typing import Any

from lelight.reports.folder import ResultFolder, Subject
from lelight.reports.reading import Reading
from lelight.reports.rounding import MISSING
from lelight.reports.texts import Texts

#: Figures on the first page whether they are required or not.
MAIN = frozenset(
    {
        "mean_illuminance", "uniformity", "mean_cylindrical_illuminance", "ugr", "mean_room_surface_exitance",
        "wall_illuminance", "ceiling_illuminance", "maintenance_factor",
    }
)  # fmt: skip
VERDICTS = ("pass", "fail", "undecided")
#: What a standard is called at the head of a clause, and the editions that lelight follows where none is named.
STANDARD = re.compile(r"(?:ANSI/IES|EN|CIE|ISO)(?: S)? (?:TM-)?\d[\d.-]*\d(?::\d{4})?")
EDITIONS = {"EN 12464-1": "EN 12464-1:2021"}


def cover(folder: ResultFolder, *, title: str, author: str | None) -> dict[str, Any]:
    """Title block: project, scene, who, when, with what and by which standards."""
    run, texts = folder.run, folder.texts
    date = str(run.get("date") or "")
    program = f"lelight {run.get('lelight') or MISSING}"
    named = [(texts["author"], author)] if author else []
    by = standards([*folder.planes, *folder.observers, folder.room])
    facts = [
        (texts["scene"], str(run.get("scene") or MISSING)),
        *named,
        (texts["calculated"], printed_date(date)),
        (texts["program"], program),
        *([(texts["standards"], by)] if by else []),
    ]
    return {"title": title, "author": author or "", "facts": facts, "program": program}


def standards(subjects: Sequence[Subject]) -> str:
    """Standards that the figures with a value follow, with their editions, each once."""
    readings = (reading for subject in subjects for reading in subject.readings)
    clauses = (reading.clause for reading in readings if reading.value is not None)
    found = {match[0] for clause in clauses for match in STANDARD.finditer(clause)}
    return ", ".join(sorted({EDITIONS.get(name, name) for name in found}))


def result_table(subjects: Sequence[Subject], *, kind: str) -> list[dict[str, Any]]:
    """Gather all figures for a table, one group a subject that has any."""
    return [_group(subject, subject.readings, kind) for subject in subjects if subject.readings]


def summary_table(subjects: Sequence[Subject], *, kind: str) -> list[dict[str, Any]]:
    """Gather the figures that matter first: what is required, and the main ones."""
    chosen = [(subject, [each for each in subject.readings if is_main(each)]) for subject in subjects]
    return [_group(subject, readings, kind) for subject, readings in chosen if readings]


def is_main(reading: Reading) -> bool:
    """Tell whether a figure belongs on the first page."""
    return reading.key in MAIN or reading.target is not None


def rows_of(subject: Subject, *, keys: Collection[str] | None = None) -> list[dict[str, str]]:
    """Cells of a subject's figures that have a value or say why not, of these keys only."""
    return [reading.row() for reading in subject.readings if keys is None or reading.key in keys]


def verdict_sentence(subjects: Sequence[Subject], texts: Texts) -> str:
    """Say how many requirements are met, missed and open."""
    verdicts = Counter(
        reading.verdict for subject in subjects for reading in subject.readings if reading.verdict in VERDICTS
    )
    total = verdicts.total()
    if not total:
        return texts["no_requirement"]
    labels = {"pass": "passed", "fail": "failed", "undecided": "undecided"}
    told = ", ".join(
        texts.filled(label, count=verdicts[verdict]) for verdict, label in labels.items() if verdicts[verdict]
    )
    return texts.filled("requirement" if total == 1 else "requirements", count=total, verdicts=told)


def _group(subject: Subject, readings: Sequence[Reading], kind: str) -> dict[str, Any]:
    return {"kind": kind, "name": subject.name, "rows": [reading.row() for reading in readings]}


def printed_date(date: str) -> str:
    """Date and time to the minute, with the time zone where it was recorded."""
    try:
        return f"{datetime.fromisoformat(date):%Y-%m-%d %H:%M %Z}".rstrip()
    except ValueError:
        return date or MISSING
