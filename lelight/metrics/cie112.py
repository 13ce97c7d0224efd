"""Glare rating of outdoor areas and sports lighting, CIE 112:1994 (as EN 12464-2 and EN 12193 use it).

Constants from memory: not verified against the report's text.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.scene import FloatArray

#: Degrees off the line of sight between which a source veils.
ANGLES = (1.5, 60.0)


def source_veil(illuminance: FloatArray, theta: FloatArray) -> float:
    """Veiling luminance (cd/m²) of the luminaires: ``10 sum E / θ²`` over 1.5° < θ < 60°.

    Parameters
    ----------
    illuminance : (n,) float, lx, at the eye on the plane across the line of sight
    theta : (n,) float, degrees from the line of sight
    """
    counts = (theta > ANGLES[0]) & (theta < ANGLES[1])
    return 10 * math.fsum(illuminance[counts] / theta[counts] ** 2)


def environment_veil(horizontal_illuminance: float, reflectance: float) -> float:
    """Veiling luminance (cd/m²) of the ground: ``0.035 ρ E_h / π``."""
    return 0.035 * reflectance * horizontal_illuminance / math.pi


def glare_rating(sources: float, environment: float) -> float:
    """``GR = 27 + 24 log10(L_vl / L_ve^0.9)``; NaN where either veil is dark."""
    if not (sources > 0 and environment > 0):
        return math.nan
    return 27 + 24 * math.log10(sources / environment**0.9)


def looks_down(direction: FloatArray) -> bool:
    """Say whether a line of sight (3,) falls below the horizon, which the rating asks for."""
    return bool(direction[2] < -1e-9 * np.linalg.norm(direction))
