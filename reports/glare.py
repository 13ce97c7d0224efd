"""The glare report: every observer's rating, the sources behind it, what the picture says, tables of the luminaires."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lelight.reports.datasheets import data_sheets
from lelight.reports.figures.fisheye import glare_picture
from lelight.reports.figures.rose import glare_rose
from lelight.reports.figures.scales import LogScale
from lelight.reports.folder import ResultFolder, Subject
from lelight.reports.method import method_figures, method_page
from lelight.reports.pictures import LuminancePicture
from lelight.reports.reading import Reading, reading_named
from lelight.reports.report import Announce, Figures, Order, write_report
from lelight.reports.rounding import MISSING
from lelight.reports.sights import common_scale, picture_statistics, read_pictures
from lelight.reports.sources import source_rows, sources_of
from lelight.reports.summary import rows_of, verdict_sentence
from lelight.reports.texts import Texts
from lelight.reports.viewpoints import Layout, observer_place, read_layout
from lelight.reports.vocabulary import mark

PLAN = "plan.svg"
PLAN_WIDTH, PLAN_HEIGHT = 84.0, 62.0
#: Upper ends of the classes of DGP.
DGP_CLASSES = (0.35, 0.40, 0.45)
RATINGS = (
    "ugr", "ugr_max", "ugr_small_sources", "ggr", "ugr_non_uniform", "gr", "source_veil", "background_luminance",
    "ugr_picture", "dgp", "dgi", "dgi_modified", "cgi", "vcp", "ugp", "ugp2", "ugr_experimental",
    "veiling_luminance", "veiling_luminance_cie", "vertical_illuminance", "direct_vertical_illuminance",
    "indirect_vertical_illuminance",
)  # fmt: skip
SUMMARY = ("ugr", "ugr_max", "ugr_picture", "dgp", "background_luminance")


def write_glare_report(out: Path, order: Order | None = None) -> Path:
    """Write ``glare.pdf`` into a result folder, or its figures alone; returns the path.

    Parameters
    ----------
    out : a folder that ``lelight calc`` wrote
    order : how it is wanted; default A4 in English

    Raises
    ------
    OutputError
        Something is missing in the folder; the line says which command makes it.
    """
    return write_report(out, "glare", _content, order or Order())


def _content(folder: ResultFolder, announce: Announce) -> tuple[dict[str, Any], Figures]:
    texts = folder.texts
    announce("reading")
    layout = read_layout(folder, [])
    pictures = read_pictures(folder)
    scale = common_scale(pictures)
    sheets, _ = data_sheets(folder)
    observers, figures = [], method_figures(folder)
    if pictures:
        figures[PLAN] = layout.plan(width=PLAN_WIDTH, height=PLAN_HEIGHT, bare=True)
    for index, (observer, picture) in enumerate(zip(folder.observers, pictures, strict=True)):
        announce(f"drawing observer {index + 1} of {len(pictures)}")
        view = folder.views.get(observer.name) or {}
        entry, drawn = _observer(index, observer, picture, view, scale=scale, layout=layout)
        observers.append(entry)
        figures.update(drawn)
    content = {
        "empty": "" if observers else texts["no_observers"],
        "verdict": verdict_sentence(folder.observers, texts),
        "summary": [_summary_row(index, observer, texts) for index, observer in enumerate(folder.observers)],
        "plan": PLAN,
        "observers": observers,
        "sheets": sheets,
        "method": method_page(folder),
        "glossary": texts.glossary,
    }
    return content, figures


def _observer(
    index: int,
    observer: Subject,
    picture: LuminancePicture,
    view: Mapping[str, Any],
    *,
    scale: LogScale,
    layout: Layout,
) -> tuple[dict[str, Any], Figures]:
    texts = layout.texts
    sources = sources_of(observer)
    outlines = [source.outline for source in sources]
    letter = mark(index)
    figures = {
        f"glare-{letter}.svg": glare_picture(picture, scale, [outline for outline in outlines if outline]),
        f"cones-{letter}.svg": layout.cones(index, width=PLAN_WIDTH, height=PLAN_HEIGHT),
    }
    rating = reading_named(observer.readings, "ugr")
    limit = rating.target if rating else None
    rose = _rose(view, limit)
    if rose:
        figures[f"rose-{letter}.svg"] = rose
    entry = {
        "place": observer_place(index, observer),
        "picture": f"glare-{letter}.svg",
        "cones": f"cones-{letter}.svg",
        "rose": f"rose-{letter}.svg" if rose else "",
        "rose_limit": texts["rose_limit"] if limit is not None else "",
        "statistics": picture_statistics(picture, texts),
        "rows": rows_of(observer, keys=RATINGS),
        "dgp_class": _dgp_class(reading_named(observer.readings, "dgp"), texts),
        "sources": source_rows(sources, texts),
        "none_in_view": "" if any(source.in_view for source in sources) else texts["no_source_in_view"],
    }
    return entry, figures


def _rose(view: Mapping[str, Any], limit: float | None) -> bytes | None:
    """Draw the ratings by bearing; None where none was found."""
    petals = [petal for petal in view.get("rose") or [] if isinstance(petal, dict)]
    ratings = np.array(
        [np.nan if petal.get("ugr") is None else petal["ugr"] for petal in petals], dtype=float
    )
    if not petals or np.all(np.isnan(ratings)):
        return None
    return glare_rose(np.array([petal["turn"] for petal in petals], dtype=float), ratings, limit=limit)


def _dgp_class(reading: Reading | None, texts: Texts) -> str:
    if reading is None or reading.value is None:
        return ""
    return texts[f"dgp_{int(np.searchsorted(DGP_CLASSES, reading.value, side='right'))}"]


def _summary_row(index: int, observer: Subject, texts: Texts) -> dict[str, Any]:
    """Row of the summary: the ratings side by side, with the requirement and the verdict on UGR."""
    readings = {key: reading_named(observer.readings, key) for key in SUMMARY}
    rating = readings["ugr"]
    row = rating.row() if rating else {}
    return {
        "place": observer_place(index, observer),
        **{key: reading.number if reading else (MISSING, "") for key, reading in readings.items()},
        "dgp_class": _dgp_class(readings["dgp"], texts),
        "requirement": row.get("requirement", ""),
        "verdict": row.get("verdict", ""),
        "verdict_text": row.get("verdict_text", ""),
    }
