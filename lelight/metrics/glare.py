"""Figures of an observer: glare from the known emitters, and beside it what the picture says."""

from __future__ import annotations

import math
from collections.abc import Sequence

from lelight.metrics.cie117 import GlareSource, glare_sum, ugr_of_sum
from lelight.metrics.figure import Figure, Verdict, measured
from lelight.metrics.picture import PictureGlare
from lelight.results import ObserverValues

_UGR = "CIE 117:1995"
_RATED = "from the known emitters, their openings and visibility"
#: A picture that holds less of the view hemisphere misses light that counts.
_WHOLE = 0.99


def observer_figures(
    values: ObserverValues,
    sources: Sequence[GlareSource],
    *,
    target_ugr: float | None = None,
    picture: PictureGlare | None = None,
) -> dict[str, Figure]:
    """Rate what an eye sees; always the same figures in the same order, those of the picture if there is one.

    Parameters
    ----------
    target_ugr : the rating that must not be exceeded
    """
    figures = {"ugr": _ugr_figure(values, sources, target_ugr)} | _light_figures(values)
    return figures if picture is None else figures | picture_figures(picture)


def _ugr_figure(values: ObserverValues, sources: Sequence[GlareSource], target: float | None) -> Figure:
    total = glare_sum(sources)
    if total == 0:
        # No glare at all is below every limit: UGR falls without end as the sources vanish.
        verdict: Verdict | None = None if target is None else "pass"
        note = "no glare source in the field of view"
        return Figure(None, "1", None, _RATED, verdict, target, _UGR, note)
    return measured(
        lambda indirect: ugr_of_sum(total, float(indirect) / math.pi),
        values.indirect_replicates,
        unit="1",
        method=_RATED,
        clause=_UGR,
        target=target,
        sense="at_most",
        undefined="not defined: no indirect light reaches the eye",
    )


def _light_figures(values: ObserverValues) -> dict[str, Figure]:
    batches = values.indirect_replicates
    return {
        "background_luminance": measured(
            lambda indirect: float(indirect) / math.pi,
            batches,
            unit="cd/m²",
            method="indirect illuminance at the eye / π",
            clause=_UGR,
        ),
        "vertical_illuminance": measured(
            lambda indirect: values.direct + float(indirect),
            batches,
            unit="lx",
            method="on the plane across the line of sight",
        ),
    }


def picture_figures(picture: PictureGlare) -> dict[str, Figure]:
    """Figures of a luminance picture; a picture has no error estimate of its own."""
    count = len(picture.sources)
    method = f"from the picture, {count} source{'s' * (count != 1)} above {picture.threshold:g} cd/m²"
    if picture.covered < _WHOLE:
        note = f"not defined: the picture holds {100 * picture.covered:.0f} % of the view hemisphere"
        empty = Figure(None, "1", None, method, note=note)
        return {"ugr_picture": empty, "dgp": empty}
    return {"ugr_picture": _picture_ugr(picture, method), "dgp": _dgp(picture, method)}


def _picture_ugr(picture: PictureGlare, method: str) -> Figure:
    if picture.ugr is not None:
        return Figure(picture.ugr, "1", None, method, clause=_UGR)
    missing = "glare source" if not picture.sources else "light beside the sources"
    return Figure(None, "1", None, method, clause=_UGR, note=f"not defined: no {missing} in the picture")


def _dgp(picture: PictureGlare, method: str) -> Figure:
    inside = picture.vertical_illuminance >= 380 and 0.2 <= picture.dgp <= 0.8
    note = "" if inside else "outside the range DGP was made for: 380 lx and more, 0.2 to 0.8"
    return Figure(picture.dgp, "1", None, method, clause="Wienold & Christoffersen 2006", note=note)
