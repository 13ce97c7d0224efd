"""Reading a result folder back: its figures, and its field with the scene it belongs to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from lelight.errors import OutputError
from lelight.metrics.table import rows


def read_metrics(out: Path) -> dict[str, Any]:
    """Figures of a result folder as ``metrics.json`` holds them."""
    return _read_json(out / "metrics.json", out)


def read_run(out: Path) -> dict[str, Any]:
    """Record of the run that made a result folder."""
    return _read_json(out / "run.json", out)


def _read_json(path: Path, out: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise OutputError(f"{path}: {error.strerror}; `lelight calc SCENE -o {out}` makes it") from error
    except (ValueError, RecursionError) as error:
        raise OutputError(f"{path}: not JSON ({error}); run `lelight calc SCENE -o {out}` again") from error
    if not isinstance(content, dict):
        raise OutputError(f"{path}: not an object; run `lelight calc SCENE -o {out}` again")
    return content


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
