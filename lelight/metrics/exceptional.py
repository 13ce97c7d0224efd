"""Where plain UGR does not apply: small and large sources (CIE 147) and non-uniform ones (CIE 232), beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from lelight.metrics.cie117 import GlareSource, glare_sum, ugr_of_sum
from lelight.metrics.cie147 import COVERAGE_RANGE, LARGE_AREA, SMALL_AREA, great_room_glare_rating
from lelight.metrics.cie232 import EFFECTIVE_LUMINANCE
from lelight.metrics.figure import Figure, measured
from lelight.results import ObserverValues
from lelight.scene import FloatArray

_SMALL, _LARGE = "CIE 147:2002 (from memory)", "CIE 147:2002, GGR (from memory)"
_NON_UNIFORM = "CIE 232:2019 (from memory)"


def exceptional_figures(
    values: ObserverValues, sources: Sequence[GlareSource], *, ceiling_coverage: float
) -> dict[str, Figure]:
    """Ratings for sources outside the limits of CIE 117; always the same names, without value where none is.

    Parameters
    ----------
    ceiling_coverage : luminous area that faces down over the area of the floor
    """
    return {
        "ugr_small_sources": _small(values, sources),
        "ggr": _large(values, sources, ceiling_coverage),
        "ugr_non_uniform": _non_uniform(values, sources),
    }


def _counted(sources: Sequence[GlareSource]) -> list[GlareSource]:
    return [source for source in sources if source.glare > 0]


def _small(values: ObserverValues, sources: Sequence[GlareSource]) -> Figure:
    method = "sources below 0.005 m² rated as if they had that area: 200 I² / r²"
    small = [source for source in _counted(sources) if 0 < source.projected_area < SMALL_AREA]
    if not small:
        return Figure(None, "1", None, method, clause=_SMALL, note="does not apply: no source below 0.005 m²")
    # L² ω = I² / (A r²), so that 200 I² / r² is L² ω A / 0.005 m².
    less = math.fsum(source.glare * (1 - source.projected_area / SMALL_AREA) for source in small)
    return _rated(values, glare_sum(sources) - less, method, _SMALL, note=f"{len(small)} small sources")


def _large(values: ObserverValues, sources: Sequence[GlareSource], coverage: float) -> Figure:
    method = "UGR + (1.18 - 0.18/CC) 8 log10[2.55 (1 + Ed/220) / (1 + Ed/Ei)]"
    large = [source for source in _counted(sources) if source.projected_area > LARGE_AREA]
    low, high = COVERAGE_RANGE
    if not large or not low <= coverage <= high:
        reason = (
            "no source above 1.5 m²" if not large else f"ceiling coverage {coverage:.2g} outside 0.15 to 1"
        )
        return Figure(None, "1", None, method, clause=_LARGE, note=f"does not apply: {reason}")
    total = glare_sum(sources)

    def rating(indirect: FloatArray) -> float:
        light = float(indirect)
        if not light > 0:
            return math.nan
        return great_room_glare_rating(
            ugr_of_sum(total, light / math.pi),
            ceiling_coverage=coverage,
            direct=values.direct,
            indirect=light,
        )

    return measured(
        rating,
        values.indirect_replicates,
        unit="1",
        method=method,
        clause=_LARGE,
        undefined="not defined: no indirect light reaches the eye",
        note=f"{len(large)} large sources, ceiling coverage {coverage:.2g}",
    )


def _non_uniform(values: ObserverValues, sources: Sequence[GlareSource]) -> Figure:
    method = "k² L² ω / p² over sources above 500 cd/m²; each has one luminance, so that k² = 1"
    bright = [source for source in _counted(sources) if source.luminance > EFFECTIVE_LUMINANCE]
    if not bright:
        note = "no glare source above 500 cd/m²"
        return Figure(None, "1", None, method, clause=_NON_UNIFORM, note=note)
    return _rated(values, glare_sum(bright), method, _NON_UNIFORM, note="sources are uniform: equals UGR")


def _rated(values: ObserverValues, total: float, method: str, clause: str, *, note: str) -> Figure:
    return measured(
        lambda indirect: ugr_of_sum(total, float(indirect) / math.pi),
        values.indirect_replicates,
        unit="1",
        method=method,
        clause=clause,
        undefined="not defined: no indirect light reaches the eye",
        note=note,
    )
