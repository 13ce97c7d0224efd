"""The sheet of a sweep: one page of curves, words and the table of runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lelight.reports.document import write_document
from lelight.reports.figures.tradeoffchart import predicted_chart, time_error_chart
from lelight.reports.rounding import MISSING, NO_BREAK_SPACE, fixed, significant
from lelight.reports.summary import printed_date
from lelight.writing.files import whole

TITLE = "Speed against accuracy"
CURVE, PREDICTED = "pareto.svg", "predicted.svg"


def write_tradeoff_sheet(out: Path, record: Mapping[str, Any], *, paper: str = "a4") -> Path:
    """Write ``tradeoff.pdf`` and its charts as SVG into ``out``; returns the path of the PDF.

    Parameters
    ----------
    record : what ``tradeoff.json`` holds
    """
    runs = record["runs"]
    figures = {CURVE: time_error_chart(runs, record["slopes"]), PREDICTED: predicted_chart(runs)}
    for name, svg in figures.items():
        with whole(out / name) as beside:
            beside.write_bytes(svg)
    program = f"lelight {record['lelight']}"
    content = {
        "kind": TITLE,
        "paper": paper,
        "cover": {"title": record["scene"], "author": "", "facts": [], "program": program},
        "facts": _facts(record, program),
        "words": record["words"],
        "curve": CURVE,
        "predicted": PREDICTED,
        "rows": [_row(row) for row in sorted(runs, key=lambda row: float(row["cpu_seconds"]))],
    }
    return write_document(
        out / "tradeoff.pdf", template="tradeoff.typ", content=content, figures=figures, date=record["date"]
    )


def _facts(record: Mapping[str, Any], program: str) -> str:
    told = [
        f"{len(record['runs'])} runs in {fixed(record['seconds'], 0)}{NO_BREAK_SPACE}s",
        f"held against: {record['truth']['basis']}",
        f"at {record['truth']['points']} points over all lit surfaces",
        printed_date(record["date"]),
        program,
    ]
    if record.get("left_out"):
        told.append(f"left out for want of time: {', '.join(record['left_out'])}")
    return "; ".join(told) + "."


def _row(row: Mapping[str, Any]) -> list[str]:
    radiance = row["radiance_error"]
    return [
        f"{row['knob']}: {row['value']}{' *' if row['front'] else ''}",
        str(row["nodes"]),
        _percent(row["std_error"]),
        _percent(row["predicted_error"]),
        _percent(row["error"]),
        MISSING if radiance is None else _percent(radiance),
        significant(row["seconds"], 3),
        significant(row["cpu_seconds"], 3),
        fixed(row["memory"] / 1e6, 0),
        fixed(row["size"] / 1e6, 1),
    ]


def _percent(share: float) -> str:
    return f"{significant(100.0 * share, 3)}{NO_BREAK_SPACE}%"
