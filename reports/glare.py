"""The glare report: every observer's rating, the sources behind it, and what the picture says beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lelight.reports.figures.fisheye import glare_picture
from lelight.reports.figures.scales import LogScale
from lelight.reports.folder import ResultFolder, Subject
from lelight.reports.method import method_figures, method_page
from lelight.reports.pictures import LuminancePicture
from lelight.reports.reading import reading_named
from lelight.reports.report import Figures, write_report
from lelight.reports.rounding import MISSING
from lelight.reports.sights import common_scale, picture_statistics, read_pictures
from lelight.reports.sources import source_rows, sources_of
from lelight.reports.summary import ERROR_STATEMENT, result_table, verdict_sentence
from lelight.reports.viewpoints import Layout, observer_place, read_layout
from lelight.reports.vocabulary import GLOSSARY

TITLE = "Glare report"
PLAN_WIDTH, PLAN_HEIGHT = 82.0, 62.0

#: What these ratings are not.
SCOPE = (
    "The unified glare rating (UGR) here is that of one eye and one line of sight in this scene (observer "
    "UGR, CIE 117). It is not the tabular UGR of a luminaire in a standard room (CIE 190), by which limits "
    "are usually checked, and the two may differ by several units. Sources outside the field of Guth's "
    "position table (T/R up to 3, H/R from 0 to 1.9) are listed but do not count."
)
NO_OBSERVERS = "The scene has no observer: add [[observers]] to the scene file and calculate again."


def write_glare_report(
    out: Path, *, title: str | None = None, author: str | None = None, paper: str = "a4"
) -> Path:
    """Write ``glare.pdf`` into a result folder and return its path.

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
    return write_report(out, "glare", _content, kind=TITLE, title=title, author=author, paper=paper)


def _content(folder: ResultFolder) -> tuple[dict[str, Any], Figures]:
    layout = read_layout(folder, [])
    pictures = read_pictures(folder)
    scale = common_scale(pictures)
    observers, figures = [], method_figures(folder)
    for index, (observer, picture) in enumerate(zip(folder.observers, pictures, strict=True)):
        entry, drawn = _observer(index, observer, picture, scale=scale, layout=layout)
        observers.append(entry)
        figures.update(drawn)
    content = {
        "statement": ERROR_STATEMENT,
        "scope": SCOPE,
        "empty": "" if observers else NO_OBSERVERS,
        "verdict": verdict_sentence(folder.observers),
        "summary": [_summary_row(index, observer) for index, observer in enumerate(folder.observers)],
        "observers": observers,
        "method": method_page(folder),
        "glossary": GLOSSARY,
    }
    return content, figures


def _observer(
    index: int, observer: Subject, picture: LuminancePicture, *, scale: LogScale, layout: Layout
) -> tuple[dict[str, Any], Figures]:
    sources = sources_of(observer)
    outlines = [source.outline for source in sources]
    figures = {
        f"glare-{index}.svg": glare_picture(picture, scale, [outline for outline in outlines if outline]),
        f"plan-{index}.svg": layout.drawn(width=PLAN_WIDTH, height=PLAN_HEIGHT, only=index),
    }
    entry = {
        "place": observer_place(index, observer),
        "picture": f"glare-{index}.svg",
        "plan": f"plan-{index}.svg",
        "statistics": picture_statistics(picture),
        "table": result_table([observer], kind="Observer"),
        "sources": source_rows(sources),
    }
    return entry, figures


def _summary_row(index: int, observer: Subject) -> dict[str, Any]:
    """Row of the summary: the ratings side by side, with the requirement and the verdict on UGR."""
    readings = {
        key: reading_named(observer.readings, key)
        for key in ("ugr", "ugr_picture", "dgp", "background_luminance")
    }
    rating = readings["ugr"]
    return {
        "place": observer_place(index, observer),
        **{key: reading.text if reading else MISSING for key, reading in readings.items()},
        "requirement": rating.requirement if rating else "",
        "verdict": (rating.row()["verdict"] if rating else ""),
        "verdict_text": (rating.row()["verdict_text"] if rating else ""),
    }
