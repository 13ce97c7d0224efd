"""ducc0's fast spherical harmonic transform between scattered directions and coefficients.

A non-uniform Fourier transform on the doubled sphere, then Legendre transforms (M. Reinecke, S. Belkner, J.
Carron, A&A 678, A165, 2023). One thread a call, so that calls can run side by side and repeat bit for bit.
"""

from __future__ import annotations

from functools import lru_cache

import ducc0
import numpy as np
from numpy.typing import NDArray

from lelight.harmonics.indices import degrees, orders
from lelight.scene import FloatArray

#: Relative rms accuracy asked of ducc0. Measured against the plain sum it leaves 2e-9 of the largest
#: coefficient, at most a fifth slower than 1e-5.
TRANSFORM_EPSILON = 1e-7


def transform(degree: int, directions: FloatArray, weights: FloatArray) -> FloatArray:
    """Coefficients of a sum of weighted deltas, sum_k w_k Y_lm(d_k).

    Parameters
    ----------
    degree : int
    directions : (k, 3) float, unit length
    weights : (k, C) float

    Returns
    -------
    (T, C) float, T = (degree + 1)²
    """
    angles = polar_angles(directions)
    columns = [_transform_channel(degree, angles, channel) for channel in np.ascontiguousarray(weights.T)]
    return np.stack(columns, axis=-1)


def _transform_channel(degree: int, angles: FloatArray, weights: FloatArray) -> FloatArray:
    """One channel's coefficients (T,)."""
    complex_coefficients = ducc0.sht.adjoint_synthesis_general(
        map=weights[None], spin=0, lmax=degree, loc=angles, epsilon=TRANSFORM_EPSILON, nthreads=1
    )[0]
    return real_form(complex_coefficients, degree)


def evaluated(coefficients: NDArray[np.floating], degree: int, directions: FloatArray) -> FloatArray:
    """Values (k, C) of one expansion (T, C) along unit directions (k, 3), by the fast transform.

    ducc0 keeps m >= 0 of complex harmonics with the Condon-Shortley phase: (-1)^m / sqrt 2 of cosine and negative
    sine coefficients are the real and imaginary parts of theirs.
    """
    angles = polar_angles(directions)
    columns = [
        ducc0.sht.synthesis_general(
            alm=complex_form(np.asarray(channel, dtype=np.float64), degree)[None],
            spin=0,
            lmax=degree,
            loc=angles,
            epsilon=TRANSFORM_EPSILON,
            nthreads=1,
        )[0]
        for channel in coefficients.T
    ]
    return np.stack(columns, axis=-1)


def real_form(complex_coefficients: NDArray[np.complexfloating], degree: int) -> FloatArray:
    """Coefficients (T,) from ducc0's complex ones, m by m.

    ducc0 keeps m >= 0 of the complex harmonics with the Condon-Shortley phase; Re and -Im of them, times
    (-1)^m sqrt 2, are the cosine and sine coefficients of the real form.
    """
    sources, cosine_factors, sine_factors = _real_form(degree)
    chosen = complex_coefficients[sources]
    return np.asarray(cosine_factors * chosen.real + sine_factors * chosen.imag)


@lru_cache(maxsize=64)
def _real_form(degree: int) -> tuple[NDArray[np.intp], FloatArray, FloatArray]:
    """Place of each real coefficient in the m-major complex array, and its factors of Re and Im."""
    order = orders(degree)
    size = np.abs(order)
    sources = size * (2 * degree + 1 - size) // 2 + degrees(degree)
    scale = np.where(order == 0, 1.0, np.sqrt(2.0) * (-1.0) ** size)
    return sources, np.where(order >= 0, scale, 0.0), np.where(order < 0, -scale, 0.0)


def complex_form(coefficients: FloatArray, degree: int) -> NDArray[np.complex128]:
    """Complex coefficients, m by m, of one channel's real ones (T,)."""
    cosine, sine, factors, places = _complex_form(degree)
    parts = np.zeros((degree + 1) * (degree + 2) // 2, dtype=np.complex128)
    scaled = factors * coefficients
    parts.real[places[cosine]] = scaled[cosine]
    parts.imag[places[sine]] = scaled[sine]
    return parts


@lru_cache(maxsize=64)
def _complex_form(degree: int) -> tuple[NDArray[np.intp], NDArray[np.intp], FloatArray, NDArray[np.intp]]:
    """Which real coefficients are of cosines and of sines, their factors, and their places among the complex ones."""
    order = orders(degree)
    size = np.abs(order)
    places = size * (2 * degree + 1 - size) // 2 + degrees(degree)
    signs = np.where(order < 0, -1.0, 1.0) * (-1.0) ** size
    factors = np.where(order == 0, 1.0, np.sqrt(0.5) * signs)
    return np.flatnonzero(order >= 0), np.flatnonzero(order < 0), factors, places


def polar_angles(directions: FloatArray) -> FloatArray:
    """Polar angle and azimuth in [0, 2 pi), (k, 2) rad, accurate at the poles."""
    x, y, z = directions.T
    polar = np.arctan2(np.hypot(x, y), z)
    return np.column_stack([polar, np.mod(np.arctan2(y, x), 2 * np.pi)])
