"""Glare of small, large and complex sources, CIE 147:2002.

From memory of the report: not verified against its text. The abstract confirms the limits of area (0.005 and
1.5 m²) and the direction of each correction.
"""

from __future__ import annotations

import math

#: m²; a smaller projected luminous area counts as this one.
SMALL_AREA = 0.005
#: m²; a larger source is rated by the great room glare rating.
LARGE_AREA = 1.5
#: Ceiling coverage for which the great room glare rating is meant.
COVERAGE_RANGE = (0.15, 1.0)
#: Average horizontal illuminance (lx) up to which a uniform luminous ceiling keeps a UGR.
CEILING_LIMITS = {13: 300.0, 16: 600.0, 19: 1000.0, 22: 1600.0}


def small_source_term(intensity: float, distance: float) -> float:
    """``L² ω`` (cd²/m⁴ sr) of a source below 0.005 m²: ``200 I² / r²`` (CIE 147:2002, from memory).

    Parameters
    ----------
    intensity : float, cd, towards the eye
    distance : float, m
    """
    return intensity**2 / (SMALL_AREA * distance**2)


def great_room_glare_rating(ugr: float, *, ceiling_coverage: float, direct: float, indirect: float) -> float:
    """GGR of a large source or a luminous ceiling (CIE 147:2002, from memory).

    ``UGR + (1.18 - 0.18/CC) 8 log10[2.55 (1 + E_d/220) / (1 + E_d/E_i)]``

    Parameters
    ----------
    ceiling_coverage : float, CC: area of a source towards nadir over the floor area that it serves
    direct, indirect : float, lx, at the eye
    """
    low, high = COVERAGE_RANGE
    if not low <= ceiling_coverage <= high:
        raise ValueError(f"ceiling_coverage: found {ceiling_coverage:g}, allowed is {low} to {high:g}")
    if not indirect > 0:
        raise ValueError(f"indirect: found {indirect:g} lx, must be positive")
    contrast = 2.55 * (1 + direct / 220) / (1 + direct / indirect)
    return ugr + (1.18 - 0.18 / ceiling_coverage) * 8 * math.log10(contrast)
