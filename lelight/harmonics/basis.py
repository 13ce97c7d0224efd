"""Values of the real orthonormal spherical harmonics, by recurrences without factorials.

With x + iy = sin(theta) exp(i phi) and t = z every harmonic is a product of a polynomial and a power,

    Y_l,m = q_lm(t) Re (x + iy)^m,   Y_l,-m = q_lm(t) Im (x + iy)^m,   m >= 0,

and the polynomials follow from their neighbours at the same order (W. H. Press et al., Numerical Recipes,
3rd ed., section 6.7; here without the Condon-Shortley phase and with the factor sqrt 2 of the real form):

    q_00 = 1 / sqrt(4 pi),  q_11 = sqrt(3) q_00,  q_mm = sqrt((2m + 1) / (2m)) q_m-1,m-1 for m > 1,
    q_l+1,m = a_lm t q_lm - b_lm q_l-1,m,
    a_lm = sqrt((4 (l+1)² - 1) / ((l+1)² - m²)),  b_lm = a_lm sqrt((l² - m²) / (4 l² - 1)).

Dividing the power of sin(theta) out of the polynomial leaves no singular point at the poles.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.harmonics.indices import degree_of, degrees, index, names, orders, terms
from lelight.scene import FloatArray

__all__ = [
    "MAX_DEGREE",
    "degree_of",
    "degrees",
    "evaluate",
    "evaluate_into",
    "index",
    "names",
    "orders",
    "terms",
]

#: Largest degree that the recurrence tables reach.
MAX_DEGREE = 128


def _sectoral() -> FloatArray:
    """Values q_mm, (MAX_DEGREE + 1,) float; the factor sqrt 2 of the real form enters at m = 1."""
    m = np.arange(1, MAX_DEGREE + 1)
    ratios = np.sqrt((2 * m + 1) / (2 * m))
    ratios[0] *= np.sqrt(2.0)
    return np.asarray(np.concatenate([[1.0], np.cumprod(ratios)]) / np.sqrt(4 * np.pi))


def _climb() -> tuple[FloatArray, FloatArray]:
    """Factors a_lm and b_lm at [m, l], each (MAX_DEGREE + 1, MAX_DEGREE + 1) float, zero where l < m."""
    m, ell = np.ogrid[: MAX_DEGREE + 1, : MAX_DEGREE + 1]
    valid = ell >= m
    above = np.where(valid, (ell + 1) ** 2 - m**2, 1)
    ahead = np.sqrt(np.where(valid, (4 * (ell + 1) ** 2 - 1) / above, 0.0))
    return ahead, ahead * np.sqrt(np.where(valid, (ell**2 - m**2) / (4 * ell**2 - 1), 0.0))


SECTORAL = _sectoral()
AHEAD, BEHIND = _climb()


@njit(**COMPILED)
def evaluate_into(degree: int, x: float, y: float, z: float, out: FloatArray) -> None:
    """Write the harmonics of one unit direction into ``out`` ((degree + 1)²,); for use inside other kernels.

    The degree is not checked: it must lie between 0 and ``MAX_DEGREE``.
    """
    cosine, sine = 1.0, 0.0
    for m in range(degree + 1):
        behind, here = 0.0, SECTORAL[m]
        for ell in range(m, degree + 1):
            centre = ell * ell + ell
            out[centre - m] = here * sine  # first, since at m = 0 both fall on the same place
            out[centre + m] = here * cosine
            behind, here = here, AHEAD[m, ell] * z * here - BEHIND[m, ell] * behind
        cosine, sine = x * cosine - y * sine, x * sine + y * cosine


@njit(**COMPILED)
def _evaluate_all(degree: int, directions: FloatArray, out: FloatArray) -> None:
    for k in range(len(directions)):
        evaluate_into(degree, directions[k, 0], directions[k, 1], directions[k, 2], out[k])


def evaluate(degree: int, directions: FloatArray) -> FloatArray:
    """Real orthonormal spherical harmonics of unit directions.

    Parameters
    ----------
    degree : int, 0 to ``MAX_DEGREE``
    directions : (k, 3) float, unit length

    Returns
    -------
    (k, (degree + 1)²) float, index l² + l + m
    """
    check_degree(degree)
    unit = np.ascontiguousarray(directions, dtype=np.float64)
    if unit.ndim != 2 or unit.shape[1] != 3:
        raise ValueError(f"directions must have shape (k, 3), got {unit.shape}")
    out = np.empty((len(unit), terms(degree)))
    _evaluate_all(degree, unit, out)
    return out


def check_degree(degree: int) -> None:
    """Raise ValueError for a degree that the recurrence tables do not reach."""
    if not 0 <= degree <= MAX_DEGREE:
        raise ValueError(f"degree must lie between 0 and {MAX_DEGREE}, got {degree}")
