"""The luminance report: what was asked for and found, plan, pictures, planes, materials, method."""

from __future__ import annotations

from pathlib import Path
from typing import Any

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
from lelight.reports.report import Figures, write_report
from lelight.reports.sights import common_scale, picture_statistics, read_pictures
from lelight.reports.summary import ERROR_STATEMENT, result_table, summary_table, verdict_sentence
from lelight.reports.surfaces import luminaire_rows, material_rows
from lelight.reports.viewpoints import observer_place, plane_place, read_grids, read_layout
from lelight.reports.vocabulary import GLOSSARY

TITLE = "Luminance report"
PLAN = "plan.svg"
#: Millimetres that a chart of a plane and the plan of the scene may take.
CHART_WIDTH, CHART_HEIGHT, PLAN_HEIGHT = 166.0, 84.0, 120.0


def write_luminance_report(
    out: Path, *, title: str | None = None, author: str | None = None, paper: str = "a4"
) -> Path:
    """Write ``luminance.pdf`` into a result folder and return its path.

    Parameters
    ----------
    out : a folder that ``lelight calc`` wrote
    title : name of the project; default the name of the scene
    paper : ``a3``, ``a4``, ``us-letter`` or ``us-legal``

    Raises
    ------
    OutputError
        Something is missing in the folder; the line says which command makes it.
    """
    return write_report(out, "luminance", _content, kind=TITLE, title=title, author=author, paper=paper)


def _content(folder: ResultFolder) -> tuple[dict[str, Any], Figures]:
    grids = read_grids(folder)
    layout = read_layout(folder, grids)
    observers, sight_figures = _observers(folder)
    planes, plane_figures = _planes(folder, grids)
    subjects = [*folder.planes, *folder.observers, folder.room]
    content = {
        "statement": ERROR_STATEMENT,
        "verdict": verdict_sentence(subjects),
        "summary": [
            *summary_table(folder.planes, kind="Plane"),
            *summary_table(folder.observers, kind="Observer"),
            *result_table([folder.room], kind=""),
        ],
        "plan": PLAN,
        "observers": observers,
        "planes": planes,
        "materials": material_rows(folder.run),
        "luminaires": luminaire_rows(folder.run),
        "method": method_page(folder),
        "glossary": GLOSSARY,
    }
    plan = {PLAN: layout.drawn(width=CHART_WIDTH, height=PLAN_HEIGHT)}
    return content, {**plan, **sight_figures, **plane_figures, **method_figures(folder)}


def _observers(folder: ResultFolder) -> tuple[list[dict[str, Any]], Figures]:
    pictures = read_pictures(folder)
    scale = common_scale(pictures)
    entries, figures = [], {}
    for index, (observer, picture) in enumerate(zip(folder.observers, pictures, strict=True)):
        names = f"sight-{index}.svg", f"distribution-{index}.svg"
        figures[names[0]] = luminance_picture(picture, scale)
        figures[names[1]] = cumulative_distribution(picture, scale)
        entries.append(
            {
                "place": observer_place(index, observer),
                "picture": names[0],
                "distribution": names[1],
                "statistics": picture_statistics(picture),
                "table": result_table([observer], kind="Observer"),
            }
        )
    return entries, figures


def _planes(folder: ResultFolder, grids: list[PlaneGrid]) -> tuple[list[dict[str, Any]], Figures]:
    entries, figures = [], {}
    for index, (plane, grid) in enumerate(zip(folder.planes, grids, strict=True)):
        entry, drawn = _plane(index, plane, grid)
        entries.append(entry)
        figures.update(drawn)
    return entries, figures


def _plane(index: int, plane: Subject, grid: PlaneGrid) -> tuple[dict[str, Any], Figures]:
    sheet = Sheet.within(grid, width=CHART_WIDTH, height=CHART_HEIGHT)
    figures = {}
    if number_size(grid, sheet):
        figures[f"values-{index}.svg"] = value_chart(grid, sheet)
    if isolines(grid.illuminance):
        figures[f"isolines-{index}.svg"] = isoline_chart(grid, sheet)
    entry = {
        "place": plane_place(index, plane, grid),
        "table": result_table([plane], kind="Plane"),
        "values": f"values-{index}.svg" if f"values-{index}.svg" in figures else "",
        "isolines": f"isolines-{index}.svg" if f"isolines-{index}.svg" in figures else "",
        "steps": isoline_statement(grid.illuminance),
        "file": f"planes/{plane.stem}.csv",
    }
    return entry, figures
