"""Colour fidelity of CIE 224:2017, and with it Rf and Rg of ANSI/IES TM-30-18, by colour-science."""

from __future__ import annotations

import warnings

from lelight.scene import Spectrum
from lelight.spectral.colorimetry import distribution, engine


def fidelity_and_gamut(spectrum: Spectrum) -> tuple[float, float]:
    """Fidelity index Rf (0 to 100) and gamut index Rg of a light."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = engine().quality.colour_fidelity_index(
            distribution(spectrum), additional_data=True, method="ANSI/IES TM-30-18"
        )
    return float(found.R_f), float(found.R_g)
