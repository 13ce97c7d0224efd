"""All figures of a run in one table: planes.NAME.*, observers.NAME.*, room.*, as JSON or CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from typing import Any

from lelight.metrics.en12464 import plane_figures
from lelight.metrics.figure import Figure
from lelight.metrics.glare import observer_figures
from lelight.metrics.room import room_figures

__all__ = ["metrics", "observer_figures", "plane_figures", "room_figures", "rows", "to_csv"]

Figures = Mapping[str, Figure]

COLUMNS = (
    "group",
    "name",
    "figure",
    "value",
    "unit",
    "std_error",
    "verdict",
    "target",
    "method",
    "clause",
    "note",
)


def metrics(
    planes: Mapping[str, Figures], observers: Mapping[str, Figures], *, room: Figures | None = None
) -> dict[str, Any]:
    """Nest the figures as ``metrics.json`` holds them; every leaf is a figure's object.

    Parameters
    ----------
    planes, observers : figures by name of the plane and of the observer
    """
    return {
        "planes": {name: _objects(figures) for name, figures in planes.items()},
        "observers": {name: _objects(figures) for name, figures in observers.items()},
        "room": _objects(room or {}),
    }


def _objects(figures: Figures) -> dict[str, Any]:
    return {name: figure.to_json() for name, figure in figures.items()}


def rows(table: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Flatten what `metrics` gives or ``metrics.json`` holds: one row a figure, keys of `COLUMNS`.

    Entries beside the figures (a grid, the list of glare sources) have no ``value`` and are passed over.
    """
    for group in ("planes", "observers"):
        for name, figures in table.get(group, {}).items():
            yield from _rows(group, name, figures)
    yield from _rows("room", "", table.get("room", {}))


def _rows(group: str, name: str, figures: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for figure, content in figures.items():
        if not (isinstance(content, Mapping) and "value" in content):
            continue
        place = {"group": group, "name": name, "figure": figure}
        yield place | {column: content.get(column) for column in COLUMNS[len(place) :]}


def to_csv(table: Mapping[str, Any]) -> str:
    """Write the table as CSV with a head line; what is absent or null is an empty cell."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows(table))
    return text.getvalue()
