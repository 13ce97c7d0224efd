"""Colorimetry through colour-science against reference numbers, and alpha-opic values of CIE S 026."""

from __future__ import annotations

import numpy as np
import pytest

from lelight.metrics.cie13_3 import rendering_indices
from lelight.metrics.cie224 import fidelity_and_gamut
from lelight.metrics.cies026 import (
    RECEPTORS,
    daylight_efficacy,
    daylight_efficacy_ratio,
    equivalent_daylight_illuminance,
    irradiances,
)
from lelight.metrics.melanopic_table import MELANOPIC, WAVELENGTHS
from lelight.metrics.ohno2013 import temperature_and_distance
from lelight.spectral.colorimetry import chromaticity, illuminant

# x, y, CCT (K), Duv, Ra, R9, Rf, Rg, melanopic DER.
LIGHTS = {
    "A": (0.44757, 0.40744, 2855.5, 0.0000, 100, 100, 100, 100, 0.4957),
    "D50": (0.34567, 0.35850, 5001.9, 0.0032, 100, 100, 100, 100, None),
    "D65": (0.31271, 0.32901, 6503.7, 0.0032, 100, 100, 100, 100, 1.0000),
    "E": (0.33331, 0.33329, 5456.4, -0.0044, 95.3, 82.2, 94.7, 103.7, 0.9058),
    "F1": (0.31306, 0.33710, 6428.3, 0.0071, 75.9, -47.3, 80.6, 89.8, None),
    "F2": (0.37207, 0.37512, 4224.5, 0.0018, 64.2, -83.6, 70.1, 86.4, 0.5690),
    "F7": (0.31285, 0.32917, 6495.0, 0.0032, 90.2, 61.0, 91.5, 98.9, 0.9227),
    "F11": (0.38054, 0.37691, 3998.6, 0.0000, 82.9, 24.9, 80.0, 101.1, 0.5621),
    "F12": (0.43702, 0.40421, 2999.6, 0.0000, 83.1, 0.9, 77.6, 102.4, 0.4028),
    "LED-B1": (0.45595, 0.40780, 2733.5, -0.0007, 81.8, 12.7, 84.1, 96.2, 0.4064),
    "LED-B3": (0.37561, 0.37229, 4102.5, -0.0007, 84.8, 23.8, 85.3, 97.9, 0.6324),
    "LED-BH1": (0.44741, 0.40659, 2851.3, -0.0003, 91.8, 72.6, 85.2, 106.8, None),
    "LED-RGB1": (0.45575, 0.42112, 2839.8, 0.0043, 57.4, -32.9, 71.0, 107.0, None),
    "LED-V1": (0.45476, 0.40441, 2723.7, -0.0019, 95.3, 97.8, 87.3, 101.9, 0.4960),
    "HP1": (0.53300, 0.41495, 1959.2, 0.0008, 8.5, -259.1, 34.2, 54.0, None),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_colour_of_cie_illuminants(name):
    x, y, cct, duv, ra, r9, rf, rg, der = LIGHTS[name]
    light = illuminant(name)
    assert chromaticity(light) == pytest.approx((x, y), abs=1e-4)
    assert temperature_and_distance(light) == (pytest.approx(cct, abs=0.1), pytest.approx(duv, abs=6e-5))
    indices = rendering_indices(light)
    assert (indices[0], indices[9]) == pytest.approx((ra, r9), abs=0.06)
    assert fidelity_and_gamut(light) == pytest.approx((rf, rg), abs=0.06)
    if der is not None:
        assert daylight_efficacy_ratio(light, "melanopic") == pytest.approx(der, abs=2e-3)


def test_efficacies_of_daylight():
    # mW/lm of D65 in the order of the receptors: s, m and l cones, rods, melanopsin.
    found = [1e3 * daylight_efficacy(receptor) for receptor in RECEPTORS]
    assert found == pytest.approx([0.8173, 1.4558, 1.6289, 1.4497, 1.3262], abs=6e-5)


def test_daylight_is_its_own_equivalent():
    daylight = illuminant("D65")
    for receptor in RECEPTORS:
        assert equivalent_daylight_illuminance(daylight, 320.0, receptor=receptor) == pytest.approx(320.0)
    assert irradiances(daylight, 1000.0)[-1] == pytest.approx(1.3262, abs=1e-4)
    assert equivalent_daylight_illuminance(daylight, 0.0) == 0.0


def test_the_melanopic_table_peaks_at_490():
    assert MELANOPIC.shape == WAVELENGTHS.shape == (401,)
    assert WAVELENGTHS[MELANOPIC.argmax()] == 490 and MELANOPIC.max() == 1.0
    np.testing.assert_allclose(MELANOPIC[::10], QUOTED, rtol=5e-3)
    np.testing.assert_allclose(MELANOPIC[:200:10], QUOTED[:20], rtol=5e-5)


# Every tenth entry as it is quoted at 10 nm, to three digits or more.
QUOTED = [
    0.00091816,
    0.0030944,
    0.011428,
    0.046155,
    0.13724,
    0.25387,
    0.40159,
    0.55371,
    0.70805,
    0.86029,
    0.96561,
    1.0,
    0.96595,
    0.86289,
    0.69963,
    0.51931,
    0.35171,
    0.21572,
    0.11853,
    0.058701,
    0.026875,
    0.01179,
    0.0050669,
    0.002177,
    0.00094731,
    0.00041796,
    0.00018834,
    8.66e-05,
    4.07e-05,
    1.96e-05,
    9.58e-06,
    4.79e-06,
    2.44e-06,
    1.27e-06,
    6.69e-07,
    3.6e-07,
    1.97e-07,
    1.09e-07,
    6.17e-08,
    3.53e-08,
    2.05e-08,
]


def test_unknown_illuminants_are_told_apart():
    assert illuminant("D66") is None
