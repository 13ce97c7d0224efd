"""The luminance report: what was asked for and found, plan, pictures, planes, materials, luminaires, method."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lelight.reports.angular import angular_pages
from lelight.reports.datasheets import data_sheets
from lelight.reports.figures.distribution import cumulative_distribution
from lelight.reports.figures.fisheye import luminance_picture
from lelight.reports.figures.planechart import (
    Sheet,
    isoline_chart,
    isoline_statement,
    isolines,
    number_size,
    value_chart,
)
from lelight.reports.folder import ResultFolder, Subject
from lelight.reports.method import method_figures, method_page
from lelight.reports.planegrid import PlaneGrid
from lelight.reports.report import Announce, Figures, Order, write_report
from lelight.reports.sights import common_scale, picture_statistics, read_pictures, zone_rows
from lelight.reports.summary import is_main, rows_of, summary_table, verdict_sentence
from lelight.reports.surfaces import luminaire_table, material_rows
from lelight.reports.texts import Texts
from lelight.reports.viewpoints import observer_place, plane_place, read_grids, read_layout
from lelight.reports.vocabulary import mark

PLAN, ISOMETRIC = "plan.svg", "isometric.svg"
#: Millimetres that the plan, the view of the scene, and charts of planes beside and below each other may take.
WIDTH, PLAN_HEIGHT, ISOMETRIC_HEIGHT = 166.0, 84.0, 78.0
HALF_WIDTH, CHART_HEIGHT = 82.0, 60.0
#: Share of its size below each other that a chart has beside another one at least.
SHRINKING = 0.9
#: Ratings of glare belong to the other report; here stand luminances and illuminances at the eye.
OBSERVER_FIGURES = (
    "ugr", "background_luminance", "luminance_task", "luminance_surround", "luminance_background",
    "luminance_ratio_task_surround", "luminance_ratio_task_background", "veiling_luminance", "veiling_luminance_cie",
    "vertical_illuminance", "vertical_illuminance_left", "vertical_illuminance_back", "vertical_illuminance_right",
    "direct_vertical_illuminance", "indirect_vertical_illuminance", "scalar_illuminance", "cylindrical_illuminance",
    "semicylindrical_illuminance", "hemispherical_illuminance", "light_vector", "vector_altitude",
    "vector_over_scalar", "cct", "duv", "ra", "r9", "rf", "rg", "melanopic_edi", "melanopic_der",
)  # fmt: skip


def write_luminance_report(out: Path, order: Order | None = None) -> Path:
    """Write ``luminance.pdf`` into a result folder, or its figures alone; returns the path.

    Parameters
    ----------
    out : a folder that ``lelight calc`` wrote
    order : how it is wanted; default A4 in English

    Raises
    ------
    OutputError
        Something is missing in the folder; the line says which command makes it.
    """
    return write_report(out, "luminance", _content, order or Order())


def _content(folder: ResultFolder, announce: Announce) -> tuple[dict[str, Any], Figures]:
    texts = folder.texts
    announce("reading")
    grids = read_grids(folder)
    layout = read_layout(folder, grids)
    figures = {
        PLAN: layout.plan(width=WIDTH, height=PLAN_HEIGHT),
        ISOMETRIC: layout.isometric(width=WIDTH, height=ISOMETRIC_HEIGHT),
    }
    observers, planes = _observers(folder, announce), _planes(folder, grids)
    angular, sheets = angular_pages(folder), data_sheets(folder)
    content = {
        "verdict": verdict_sentence([*folder.planes, *folder.observers, folder.room], texts),
        "summary": [
            *summary_table(folder.planes, kind=texts["plane"]),
            *summary_table(folder.observers, kind=texts["observer"]),
            *summary_table([folder.room], kind=""),
        ],
        "plan": PLAN,
        "isometric": ISOMETRIC,
        "observers": observers[0],
        "planes": planes[0],
        "angular": angular[0],
        "room": rows_of(folder.room),
        "materials": material_rows(folder.run),
        "luminaires": luminaire_table(folder.run, texts),
        "sheets": sheets[0],
        "method": method_page(folder),
        "glossary": texts.glossary,
    }
    for _, drawn in (observers, planes, angular, sheets):
        figures.update(drawn)
    return content, {**figures, **method_figures(folder)}


def _observers(folder: ResultFolder, announce: Announce) -> tuple[list[dict[str, Any]], Figures]:
    pictures = read_pictures(folder)
    scale = common_scale(pictures)
    entries, figures = [], {}
    for index, (observer, picture) in enumerate(zip(folder.observers, pictures, strict=True)):
        announce(f"drawing observer {index + 1} of {len(pictures)}")
        names = f"view-{mark(index)}.svg", f"distribution-{mark(index)}.svg"
        figures[names[0]] = luminance_picture(picture, scale)
        figures[names[1]] = cumulative_distribution(picture, scale, folder.texts)
        entries.append(
            {
                "place": observer_place(index, observer),
                "picture": names[0],
                "distribution": names[1],
                "statistics": picture_statistics(picture, folder.texts),
                "zones": zone_rows(folder.views.get(observer.name) or {}, folder.texts),
                "rows": _with_value(rows_of(observer, keys=OBSERVER_FIGURES)),
            }
        )
    return entries, figures


def _with_value(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """Rows that have a value: why a figure is missing is said where it is rated."""
    return [row for row in rows if row["found"]]


def _planes(folder: ResultFolder, grids: list[PlaneGrid]) -> tuple[list[dict[str, Any]], Figures]:
    entries, figures = [], {}
    for index, (plane, grid) in enumerate(zip(folder.planes, grids, strict=True)):
        entry, drawn = _plane(index, plane, grid, folder.texts)
        entries.append(entry)
        figures.update(drawn)
    return entries, figures


def _plane(index: int, plane: Subject, grid: PlaneGrid, texts: Texts) -> tuple[dict[str, Any], Figures]:
    sheet = Sheet.within(grid, width=HALF_WIDTH, height=CHART_HEIGHT)
    wide = Sheet.within(grid, width=WIDTH, height=CHART_HEIGHT)
    beside = bool(sheet.scale >= SHRINKING * wide.scale)
    sheet = sheet if beside else wide
    figures = {}
    values, lines = f"values-P{index + 1}.svg", f"isolines-P{index + 1}.svg"
    if number_size(grid, sheet):
        figures[values] = value_chart(grid, sheet, texts)
    if any(isolines(grid.illuminance)):
        figures[lines] = isoline_chart(grid, sheet, texts)
    rule = plane.entry.get("grid") or {}
    entry = {
        "place": plane_place(index, plane, grid),
        "rule": str(rule.get("rule") or ""),
        "wall_band": f"{rule['wall_band']:g}\u00a0m" if rule.get("wall_band") else "",
        "rows": [
            reading.row() for reading in plane.readings if is_main(reading) or reading.key in PLANE_FIGURES
        ],
        "further": _with_value(
            [r.row() for r in plane.readings if not is_main(r) and r.key not in PLANE_FIGURES]
        ),
        "values": values if values in figures else "",
        "isolines": lines if lines in figures else "",
        "beside": beside,
        "steps": isoline_statement(grid.illuminance, texts) if lines in figures else "",
        "file": f"planes/{plane.stem}.csv",
    }
    return entry, figures


#: Figures of a plane that its first table holds beside what is required.
PLANE_FIGURES = frozenset(
    {
        "minimum_illuminance",
        "min_illuminance",
        "maximum_illuminance",
        "max_illuminance",
        "diversity",
        "modelling",
    }
)
