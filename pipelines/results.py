"""Reading a result folder back: its figures, and its field with the scene it belongs to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lelight.metrics.table import rows
from lelight.resultfiles import METRICS, RUN, read_object


def read_metrics(out: Path) -> dict[str, Any]:
    """Figures of a result folder as ``metrics.json`` holds them."""
    return read_object(out / "metrics.json", METRICS, remedy=f"`lelight calc SCENE -o {out}` makes it")


def read_run(out: Path) -> dict[str, Any]:
    """Record of the run that made a result folder."""
    return read_object(out / "run.json", RUN, remedy=f"`lelight calc SCENE -o {out}` makes it")


def table_lines(table: dict[str, Any]) -> list[str]:
    """Figures as text, a line each: where, what, value ± two standard errors, verdict, source."""
    lines = []
    for row in rows(table):
        where = f"{row['group']} {row['name']}".strip()
        lines.append(
            f"{where:28} {row['figure']:31} {_measured(row):>24} {row.get('verdict') or '':9} "
            f"{row.get('clause') or ''}".rstrip()
        )
    return lines


def _measured(row: dict[str, Any]) -> str:
    if row["value"] in (None, ""):
        return "-"
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    if row["std_error"] in (None, ""):
        return f"{row['value']:.4g}{unit}"
    return f"{row['value']:.4g} ± {2 * row['std_error']:.2g}{unit}"
