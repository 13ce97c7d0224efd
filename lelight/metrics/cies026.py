"""Alpha-opic quantities of CIE S 026:2018: what light does to each of the eye's five receptors.

The action spectra of cones and rods are the 10 degree cone fundamentals and V'(λ); melanopsin's is carried as
a table. An equivalent daylight illuminance (EDI) is the illuminance of D65 with the same effect.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from lelight.metrics.melanopic_table import MELANOPIC, WAVELENGTHS
from lelight.scene import FloatArray, Spectrum
from lelight.spectral.colorimetry import (
    LUMINOUS_EFFICACY,
    cone_fundamental,
    illuminant,
    photopic,
    scotopic,
)

#: Receptors by the names of the standard.
RECEPTORS = ("s_cone_opic", "m_cone_opic", "l_cone_opic", "rhodopic", "melanopic")


@cache
def _action(receptor: str) -> FloatArray:
    """Find the action spectrum (401,) at 380 to 780 nm."""
    cones = {"l_cone_opic": 0, "m_cone_opic": 1, "s_cone_opic": 2}
    if receptor in cones:
        return cone_fundamental(cones[receptor], WAVELENGTHS)
    return scotopic(WAVELENGTHS) if receptor == "rhodopic" else MELANOPIC


def _efficacy(spectrum: Spectrum, receptor: str) -> float:
    """Alpha-opic efficacy of luminous radiation, W/lm."""
    power = spectrum.at(WAVELENGTHS)
    return float(power @ _action(receptor)) / (LUMINOUS_EFFICACY * float(power @ photopic(WAVELENGTHS)))


@cache
def daylight_efficacy(receptor: str) -> float:
    """Efficacy of D65, W/lm; 1.3262e-3 for the melanopic receptor."""
    daylight = illuminant("D65")
    assert daylight is not None
    return _efficacy(daylight, receptor)


def daylight_efficacy_ratio(spectrum: Spectrum, receptor: str) -> float:
    """Alpha-opic daylight efficacy ratio (DER), 1 for D65."""
    return _efficacy(spectrum, receptor) / daylight_efficacy(receptor)


def equivalent_daylight_illuminance(
    spectrum: Spectrum, illuminance: float, *, receptor: str = "melanopic"
) -> float:
    """Equivalent daylight illuminance (lx): the illuminance times the light's efficacy ratio."""
    return illuminance * daylight_efficacy_ratio(spectrum, receptor) if illuminance > 0 else 0.0


def irradiances(spectrum: Spectrum, illuminance: float) -> FloatArray:
    """Alpha-opic irradiances (5,) in W/m², in the order of `RECEPTORS`."""
    return np.array([illuminance * _efficacy(spectrum, receptor) for receptor in RECEPTORS])
