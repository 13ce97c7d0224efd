"""What observers see: their luminance pictures, on one scale, and the figures read off them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lelight.reports.figures.scales import LogScale, luminance_scale
from lelight.reports.folder import ResultFolder
from lelight.reports.pictures import LuminancePicture, read_picture
from lelight.reports.rounding import MISSING, significant, with_unit
from lelight.reports.texts import Texts


def read_pictures(folder: ResultFolder) -> list[LuminancePicture]:
    """Read every observer's picture, in the order of ``metrics.json``."""
    return [
        read_picture(
            folder.file(
                "observers",
                f"{observer.stem}.exr",
                remedy=f"`lelight render {folder.path} --observer '{observer.name}'` writes it",
            )
        )
        for observer in folder.observers
    ]


def common_scale(pictures: Sequence[LuminancePicture]) -> LogScale:
    """One scale of luminance over all pictures of a report, so that colours can be compared."""
    return luminance_scale([picture.luminance[picture.disc] for picture in pictures])


def picture_statistics(picture: LuminancePicture, texts: Texts) -> list[tuple[str, str]]:
    """Luminances of a view by solid angle: mean, median, the brightest 5 %, extremes."""
    brightest, darkest = (picture.luminance[picture.extremum(largest)] for largest in (True, False))
    luminances = [
        (texts["mean_over_view"], picture.mean),
        (texts["median"], picture.quantile(0.5)),
        (texts["brightest_5"], picture.quantile(0.95)),
        (texts["largest"], float(brightest)),
        (texts["smallest"], float(darkest)),
    ]
    return [(name, with_unit(significant(luminance), "cd/m²")) for name, luminance in luminances]


#: Parts of the field of view, and what is told of each, by their keys under ``views`` in ``metrics.json``.
ZONES = ("task", "surround", "background", "view")
ZONE_FIGURES = ("mean", "median", "p5", "p95", "max", "solid_angle")


def zone_rows(view: Mapping[str, Any], texts: Texts) -> list[list[str]]:
    """Name and luminances in cd/m² of the parts of an observer's field, and their solid angle in sr."""
    zones = view.get("luminance") or {}
    return [
        [texts[f"zone_{zone}"], *(_significant(zones[zone].get(key)) for key in ZONE_FIGURES)]
        for zone in ZONES
        if isinstance(zones.get(zone), dict)
    ]


def _significant(found: Any) -> str:
    return significant(float(found)) if isinstance(found, int | float) else MISSING
