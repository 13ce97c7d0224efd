"""UGR over all bearings of an eye: the line of sight turned about the vertical in steps of 15 degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from lelight.metrics.cie117 import GlareSource, glare_sum, ugr_of_sum
from lelight.metrics.figure import Figure, from_replicates, stated
from lelight.scene import FloatArray

_METHOD = "largest of 24 bearings, 15° apart; each from the known emitters and its own indirect light"


def rose(seen: Sequence[Sequence[GlareSource]], indirect: FloatArray) -> list[dict[str, Any]]:
    """UGR and background luminance by bearing.

    Parameters
    ----------
    seen : the sources of each of the 24 lines of sight
    indirect : (R, 24) float, lx, indirect illuminance across each line of sight by batch

    Returns
    -------
    One object a bearing: ``turn`` (degrees to the left of the observer's line of sight), ``ugr`` and its
    ``std_error`` (None without a source), ``background_luminance`` (cd/m²)
    """
    return [_petal(number, sources, indirect[:, number]) for number, sources in enumerate(seen)]


def _petal(number: int, sources: Sequence[GlareSource], indirect: FloatArray) -> dict[str, Any]:
    total = glare_sum(sources)
    value, std_error = from_replicates(lambda e: ugr_of_sum(total, float(e) / math.pi), indirect)
    defined = math.isfinite(value)
    return {
        "turn": 360.0 * number / 24,
        "ugr": value if defined else None,
        "std_error": std_error if defined else None,
        "background_luminance": float(indirect.mean()) / math.pi,
    }


def largest(petals: Sequence[dict[str, Any]], *, batches: int, target: float | None) -> Figure:
    """Largest UGR of a rose; the bearing is chosen by the value itself, whose noise is small against steps."""
    rated = [petal for petal in petals if petal["ugr"] is not None]
    if not rated:
        verdict = None if target is None else "pass"
        note = "no glare source in any direction"
        return Figure(None, "1", None, _METHOD, "pass" if verdict else None, target, "CIE 117:1995", note)
    worst = max(rated, key=lambda petal: float(petal["ugr"]))
    return stated(
        worst["ugr"],
        worst["std_error"],
        batches=batches,
        unit="1",
        method=_METHOD,
        clause="CIE 117:1995",
        target=target,
        sense="at_most",
        note=f"at {worst['turn']:g}° to the left of the line of sight",
    )
