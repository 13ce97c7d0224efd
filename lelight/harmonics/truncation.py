"""What a finite degree leaves out, told from the spectrum of what is kept."""

from __future__ import annotations

import numpy as np

from lelight.harmonics.indices import degree_of
from lelight.harmonics.spectrum import energy_by_degree
from lelight.scene import FloatArray


def truncation_error(light: FloatArray, lobe: FloatArray, *, applied: bool = False) -> FloatArray:
    """Root mean square over all directions of what a lobe makes of the degrees beyond those of ``light``.

    Their energy a coefficient, |g_lm|², is taken to be that of the last quarter of the degrees kept. That is exact
    for a single beam; light that is spread has less of the high degrees, and then this is an upper bound, as it is
    where noise adds to them.

    Parameters
    ----------
    light : (r, T) float, coefficients of light at its mirrored directions, T = (L + 1)²
    lobe : (more than L + 1,) float, factors by degree; those beyond L are the ones that are left out
    applied : whether the lobe has been multiplied to ``light`` already

    Returns
    -------
    (r,) float, in the unit of the reflected radiance
    """
    degree = degree_of(light.shape[1])
    orders = 2.0 * np.arange(len(lobe)) + 1.0
    last = np.arange(degree - degree // 4, degree + 1)
    energy = energy_by_degree(light[..., None])[:, last, 0].sum(axis=1)
    carried = orders[last] * lobe[last] ** 2 if applied else orders[last]
    left_out = np.sum(orders[degree + 1 :] * lobe[degree + 1 :] ** 2)
    return np.asarray(np.sqrt(energy / max(carried.sum(), np.finfo(float).tiny) * left_out / (4.0 * np.pi)))
