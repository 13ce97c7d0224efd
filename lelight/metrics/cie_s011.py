"""General sky of CIE S 011 / ISO 15469: relative luminance of the 15 types, and the traditional overcast sky.

The parameters reproduce the published tables of CIE 171:2006 for the types that these sample.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.scene import FloatArray

#: a, b, c, d, e by type.
PARAMETERS = {
    1: (4.0, -0.7, 0.0, -1.0, 0.0),
    2: (4.0, -0.7, 2.0, -1.5, 0.15),
    3: (1.1, -0.8, 0.0, -1.0, 0.0),
    4: (1.1, -0.8, 2.0, -1.5, 0.15),
    5: (0.0, -1.0, 0.0, -1.0, 0.0),
    6: (0.0, -1.0, 2.0, -1.5, 0.15),
    7: (0.0, -1.0, 5.0, -2.5, 0.3),
    8: (0.0, -1.0, 10.0, -3.0, 0.45),
    9: (-1.0, -0.55, 2.0, -1.5, 0.15),
    10: (-1.0, -0.55, 5.0, -2.5, 0.3),
    11: (-1.0, -0.55, 10.0, -3.0, 0.45),
    12: (-1.0, -0.32, 10.0, -3.0, 0.45),
    13: (-1.0, -0.32, 16.0, -3.0, 0.3),
    14: (-1.0, -0.15, 16.0, -3.0, 0.3),
    15: (-1.0, -0.15, 24.0, -2.8, 0.15),
}
#: The overcast sky of Moon & Spencer, (1 + 2 cos Z) / 3.
TRADITIONAL_OVERCAST = 16


def relative_luminance(
    sky: int, zenith_angle: FloatArray, azimuth: FloatArray, *, sun_zenith: float
) -> FloatArray:
    """Luminance over that of the zenith, ``f(χ) φ(Z) / (f(Z_s) φ(0))``.

    Parameters
    ----------
    sky : 1 to 15, or 16 for the traditional overcast sky
    zenith_angle, azimuth : (...) float, rad; azimuth from the sun's
    sun_zenith : float, rad
    """
    if sky == TRADITIONAL_OVERCAST:
        return np.asarray((1 + 2 * np.cos(zenith_angle)) / 3 + 0 * azimuth)
    if sky not in PARAMETERS:
        raise ValueError(f"sky: found {sky}, allowed is 1 to 16")
    a, b, c, d, e = PARAMETERS[sky]
    cos_chi = math.cos(sun_zenith) * np.cos(zenith_angle)
    cos_chi = cos_chi + math.sin(sun_zenith) * np.sin(zenith_angle) * np.cos(azimuth)
    scattering = _indicatrix(np.clip(cos_chi, -1, 1), c, d, e)
    at_zenith = _indicatrix(np.array(math.cos(sun_zenith)), c, d, e) * (1 + a * math.exp(b))
    return np.asarray(scattering * _gradation(zenith_angle, a, b) / at_zenith)


def _gradation(zenith_angle: FloatArray, a: float, b: float) -> FloatArray:
    """``1 + a exp(b / cos Z)``, 1 at and below the horizon."""
    cosine = np.cos(zenith_angle)
    above = cosine > 0
    return np.where(above, 1 + a * np.exp(b / np.where(above, cosine, 1.0)), 1.0)


def _indicatrix(cos_chi: FloatArray, c: float, d: float, e: float) -> FloatArray:
    chi = np.arccos(cos_chi)
    return np.asarray(1 + c * (np.exp(d * chi) - math.exp(d * math.pi / 2)) + e * cos_chi**2)
