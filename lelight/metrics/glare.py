"""Figures of an observer: glare from the known emitters, and beside it what the picture says."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from lelight.metrics.cie117 import GlareSource, glare_sum, ugr_of_sum
from lelight.metrics.daylight_glare import View, dgp, ugr
from lelight.metrics.figure import Figure, Verdict, measured
from lelight.metrics.picture import PictureGlare
from lelight.results import ObserverValues
from lelight.scene import FloatArray

_UGR = "CIE 117:1995"
_RATED = "from the known emitters, their openings and visibility"
#: A picture that holds less of the view hemisphere misses light that counts.
WHOLE = 0.99
#: What carries the error of a picture's figure.
CARRIED = "; error carried over from the indirect illuminance at the eye"


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
    return figures if picture is None else figures | picture_figures(picture, values.indirect_replicates)


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


def picture_figures(picture: PictureGlare, indirect: FloatArray | None = None) -> dict[str, Figure]:
    """Rate a luminance picture, which has no error estimate of its own.

    Parameters
    ----------
    indirect : (R,) float, lx, at the eye by batch: its relative error stands in for the picture's
    """
    method = picture_method(picture)
    if picture.covered < WHOLE:
        note = f"not defined: the picture holds {100 * picture.covered:.0f} % of the view hemisphere"
        empty = Figure(None, "1", None, method, note=note)
        return {"ugr_picture": empty, "dgp": empty}
    found = {"ugr_picture": _picture_ugr(picture, method), "dgp": _dgp(picture, method)}
    if indirect is None or not float(indirect.mean()) > 0:
        return found
    functions = {"ugr_picture": ugr, "dgp": dgp}
    return {name: _with_error(figure, functions[name], picture, indirect) for name, figure in found.items()}


def _with_error(
    figure: Figure, function: Callable[[View], float], picture: PictureGlare, indirect: FloatArray
) -> Figure:
    """Give a picture's figure the error of the indirect light, all but the sources moving with it."""
    if figure.value is None:
        return figure
    rated = measured(
        lambda share: function(picture.view.with_background(float(share))),
        indirect / indirect.mean(),
        unit=figure.unit,
        method=figure.method + CARRIED,
    )
    return replace(rated, value=figure.value, clause=figure.clause, note=figure.note)


def picture_method(picture: PictureGlare) -> str:
    """Say by which rule the sources of a picture were found."""
    count = len(picture.sources)
    return f"from the picture, {count} source{'s' * (count != 1)} above {picture.threshold:.6g} cd/m²"


def _picture_ugr(picture: PictureGlare, method: str) -> Figure:
    if picture.ugr is not None:
        return Figure(picture.ugr, "1", None, method, clause=_UGR)
    missing = "glare source" if not picture.sources else "light beside the sources"
    return Figure(None, "1", None, method, clause=_UGR, note=f"not defined: no {missing} in the picture")


def _dgp(picture: PictureGlare, method: str) -> Figure:
    inside = picture.vertical_illuminance >= 380 and 0.2 <= picture.dgp <= 0.8
    note = "" if inside else "outside the range DGP was made for: 380 lx and more, 0.2 to 0.8"
    return Figure(picture.dgp, "1", None, method, clause="Wienold & Christoffersen 2006", note=note)
