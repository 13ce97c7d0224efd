"""Threshold increment of road lighting, CIE 31 / CIE 140 and EN 13201-3.

The form with the age factor k is from memory of EN 13201-3:2015.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.scene import FloatArray


def threshold_increment(veiling_luminance: float, road_luminance: float) -> float:
    """TI in %: ``65 Lv / Lav^0.8`` for 0.05 < Lav <= 5 cd/m², ``95 Lv / Lav^1.05`` above; NaN below."""
    if road_luminance <= 0.05:
        return math.nan
    if road_luminance <= 5:
        return 65 * veiling_luminance / math.pow(road_luminance, 0.8)
    return 95 * veiling_luminance / math.pow(road_luminance, 1.05)


def age_factor(age: float) -> float:
    """Factor ``k = 641 [1 + (A/66.4)⁴]`` of an observer of ``age`` years (EN 13201-3:2015, from memory)."""
    return 641 * (1 + (age / 66.4) ** 4)


def threshold_increment_of_age(
    illuminance: FloatArray, theta: FloatArray, road_luminance: float, *, age: float = 23.0
) -> float:
    """TI in %: ``k / Lav^0.8 sum E / θ²``, illuminances (n,) lx at the eye, θ (n,) in degrees, 1.5 to 60."""
    counts = (theta > 1.5) & (theta < 60)
    return float(age_factor(age) / road_luminance**0.8 * np.sum(illuminance[counts] / theta[counts] ** 2))
