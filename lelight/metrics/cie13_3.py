"""Colour rendering indices of CIE 13.3:1995, as colour-science computes them every 5 nm."""

from __future__ import annotations

import warnings

import numpy as np

from lelight.scene import FloatArray, Spectrum
from lelight.spectral.colorimetry import distribution, engine


def rendering_indices(spectrum: Spectrum) -> FloatArray:
    """Ra and R1 to R14, (15,), of a light; an index may be below zero."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = engine().quality.colour_rendering_index(distribution(spectrum), additional_data=True)
    special = [found.Q_as[number].Q_a for number in sorted(found.Q_as)]
    return np.array([found.Q_a, *special], dtype=np.float64)
