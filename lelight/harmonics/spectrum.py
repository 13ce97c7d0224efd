"""How an expansion's square integral is spread over degrees: what a truncation would lose."""

from __future__ import annotations

import numpy as np

from lelight.harmonics.indices import degree_of
from lelight.scene import FloatArray


def energy_by_degree(coefficients: FloatArray) -> FloatArray:
    """Share of the integral of the squared field that each degree carries (Parseval).

    Parameters
    ----------
    coefficients : (..., T, C) float

    Returns
    -------
    (..., L + 1, C) float; sums of squares over the orders of each degree
    """
    starts = np.arange(degree_of(coefficients.shape[-2]) + 1) ** 2
    return np.asarray(np.add.reduceat(np.square(coefficients, dtype=np.float64), starts, axis=-2))
