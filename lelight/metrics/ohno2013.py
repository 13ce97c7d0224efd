"""Correlated colour temperature and distance from the Planckian locus, Ohno 2013 (LEUKOS 10(1))."""

from __future__ import annotations

import warnings

from lelight.scene import Spectrum
from lelight.spectral.colorimetry import chromaticity, engine


def temperature_and_distance(spectrum: Spectrum) -> tuple[float, float]:
    """Correlated colour temperature (K) and Duv of a light; Duv is positive above the locus."""
    colour = engine()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        uv = colour.xy_to_UCS_uv(chromaticity(spectrum))
        kelvin, duv = colour.temperature.uv_to_CCT_Ohno2013(uv)
    return float(kelvin), float(duv)
