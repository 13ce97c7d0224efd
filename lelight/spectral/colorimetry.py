"""The one door to colour-science: what it is given, and what is asked of it.

It takes a second to import, so nothing here is touched by a scene without spectra.
"""

from __future__ import annotations

import warnings
from functools import cache
from typing import Any

import numpy as np

from lelight.scene import FloatArray, Spectrum

#: lm/W (CIE 018:2019), for a spectral V(λ) of 1.
LUMINOUS_EFFICACY = 683.002


@cache
def engine() -> Any:
    """colour-science, imported without what it warns of (optional packages)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
        import colour.quality
    return colour


def interpolated(
    wavelengths: FloatArray, known: FloatArray, amounts: FloatArray, *, left: float, right: float
) -> FloatArray:
    """Amounts (n,) at wavelengths (n,) from a table, linear between its entries."""
    return np.asarray(np.interp(wavelengths, known, amounts, left=left, right=right), dtype=np.float64)


@cache
def _curve(group: str, name: str, column: int | None) -> tuple[FloatArray, FloatArray]:
    table = getattr(engine(), group)[name]
    amounts = table.values if column is None else table.values[:, column]
    return np.asarray(table.wavelengths, dtype=np.float64), np.asarray(amounts, dtype=np.float64)


def photopic(wavelengths: FloatArray) -> FloatArray:
    """V(λ) (n,) of the CIE 1924 standard observer at wavelengths (n,) in nm."""
    known, amounts = _curve("SDS_LEFS", "CIE 1924 Photopic Standard Observer", None)
    return interpolated(wavelengths, known, amounts, left=0.0, right=0.0)


def scotopic(wavelengths: FloatArray) -> FloatArray:
    """V'(λ) (n,) of the CIE 1951 standard observer."""
    known, amounts = _curve("SDS_LEFS", "CIE 1951 Scotopic Standard Observer", None)
    return interpolated(wavelengths, known, amounts, left=0.0, right=0.0)


def cone_fundamental(cone: int, wavelengths: FloatArray) -> FloatArray:
    """Fundamental (n,) of the 10 degree observer: cone 0 is long, 1 middle, 2 short (CIE 170-1:2006)."""
    known, amounts = _curve("MSDS_CMFS", "Stockman & Sharpe 10 Degree Cone Fundamentals", cone)
    return interpolated(wavelengths, known, np.nan_to_num(amounts), left=0.0, right=0.0)


def illuminant(name: str) -> Spectrum | None:
    """Spectrum of a CIE illuminant by its name, "D65", "F11" or "LED-B3"; None where it is not known."""
    tables = engine().SDS_ILLUMINANTS
    for candidate in (name, name.replace("F", "FL", 1) if name.startswith("F") else name):
        if candidate in tables:
            table = tables[candidate]
            wavelengths = np.asarray(table.wavelengths, dtype=np.float64)
            return Spectrum(name, wavelengths, np.asarray(table.values, dtype=np.float64))
    return None


def distribution(spectrum: Spectrum) -> Any:
    """Give a spectrum to colour-science, every 5 nm, or every 1 nm where it is sampled closer."""
    closest = float(np.min(np.diff(spectrum.wavelengths)))
    wavelengths = np.arange(380.0, 780.5, 5.0 if closest >= 4.999 else 1.0)
    peak = float(np.max(spectrum.amounts))
    amounts = spectrum.at(wavelengths) / peak
    return engine().SpectralDistribution(
        dict(zip(wavelengths, amounts, strict=True)),
        name=spectrum.name,
        interpolator=engine().LinearInterpolator,
    )


def chromaticity(spectrum: Spectrum) -> FloatArray:
    """Chromaticity x, y (2,) of the CIE 1931 observer."""
    colour = engine()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tristimulus = colour.sd_to_XYZ(distribution(spectrum))
    return np.asarray(colour.XYZ_to_xy(tristimulus))
