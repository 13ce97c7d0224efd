"""Radiance sampled in a fixed grid of directions over the hemisphere, and expansions fitted to it.

Section 4, eqs (18) and (19), of V. P. Budak et al., Relation of Instant Radiosity Method with Local
Estimations of Monte Carlo Method (Journal of WSCG, 2016): Fourier series in the azimuth, quadrature in the
cosine of the polar angle. An expansion lives on the whole sphere and radiance on half of it, so what it does
below the horizon has to be chosen:

``least_squares``   whatever fits best above; the only one that is right up to the horizon
``zero``            nothing, as in the paper; the jump rings by half the value at the horizon, at any degree
``even``            the mirror image; half of the coefficients vanish, a kink stays at the horizon

Largest error over the hemisphere, in shares of the peak, for a constant at degree 16 and for cos^16 lobes
about 75 and 85 degrees at degree 13: least_squares 1.3e-4, 3.5e-4, 3.6e-4; zero 0.50, 0.22, 0.44; even 0,
0.13, 0.07.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
from numpy.polynomial.legendre import leggauss

from lelight.harmonics.basis import degree_of, evaluate, index, terms
from lelight.scene import FloatArray

Rule = Literal["gauss", "legendre"]
Extension = Literal["least_squares", "zero", "even"]

#: Eigenvalues of the normal equations below this share of the largest are left out: combinations of harmonics
#: that all but vanish above the horizon, and that noise would fill.
EIGENVALUE_CUTOFF = 1e-6


@dataclass(frozen=True)
class HemisphereGrid:
    """Directions of a hemisphere: zeros of Legendre polynomials in cos theta, uniform azimuths.

    Attributes
    ----------
    zenith_count, azimuth_count : int; a fit of degree L needs L + 1 and 2 L + 1
    rule : ``gauss`` for the nodes of the half range [0, 1], ``legendre`` for the positive zeros of the
        polynomial of degree 2 ``zenith_count`` (the full range of the paper)
    """

    zenith_count: int
    azimuth_count: int
    rule: Rule = "gauss"

    def __post_init__(self) -> None:
        if self.zenith_count < 1 or self.azimuth_count < 1:
            raise ValueError("zenith_count and azimuth_count must be positive")
        if self.rule not in get_args(Rule):
            raise ValueError(f"rule must be one of {get_args(Rule)}, got {self.rule!r}")

    @property
    def cos_theta(self) -> FloatArray:
        """(Z,) float, rising from the horizon to the zenith."""
        return self._quadrature[0]

    @property
    def zenith_weights(self) -> FloatArray:
        """(Z,) float, of the integral over cos theta from 0 to 1."""
        return self._quadrature[1]

    @property
    def azimuths(self) -> FloatArray:
        """(A,) float, rad, from 0."""
        return np.asarray(np.arange(self.azimuth_count) * (2 * np.pi / self.azimuth_count))

    @property
    def directions(self) -> FloatArray:
        """(Z, A, 3) float, unit, local frame."""
        cos_theta, azimuth = np.meshgrid(self.cos_theta, self.azimuths, indexing="ij")
        sin_theta = np.sqrt(1 - cos_theta**2)
        components = [sin_theta * np.cos(azimuth), sin_theta * np.sin(azimuth), cos_theta]
        return np.asarray(np.stack(components, axis=-1))

    @property
    def degree(self) -> int:
        """Largest degree that the grid can carry."""
        return min(self.zenith_count, (self.azimuth_count + 1) // 2) - 1

    @property
    def _quadrature(self) -> tuple[FloatArray, FloatArray]:
        if self.rule == "gauss":
            nodes, weights = leggauss(self.zenith_count)
            return (nodes + 1) / 2, weights / 2
        nodes, weights = leggauss(2 * self.zenith_count)
        return nodes[self.zenith_count :], weights[self.zenith_count :]

    def fit(self, radiance: FloatArray, degree: int, *, extension: Extension = "least_squares") -> FloatArray:
        """Coefficients of the expansion that represents sampled radiance above the horizon.

        Parameters
        ----------
        radiance : (..., Z, A, C) float, in the directions of the grid
        degree : int, at most the grid's
        extension : how the field goes on below the horizon

        Returns
        -------
        (..., T, C) float, T = (degree + 1)²
        """
        self._check_fit(np.shape(radiance), degree, extension)
        spectrum = np.fft.rfft(radiance, axis=-2) * (2 / self.azimuth_count)
        shape = (*spectrum.shape[:-3], terms(degree), spectrum.shape[-1])
        coefficients = np.empty(shape)
        for m, operator in enumerate(_operators(self, degree, extension)):
            cosine_rows = [index(ell, m) for ell in range(m, degree + 1)]
            sine_rows = [index(ell, -m) for ell in range(m, degree + 1)]
            profile = spectrum[..., m, :] if m else spectrum[..., 0, :] / 2
            coefficients[..., sine_rows, :] = (
                operator @ -profile.imag
            )  # first: at m = 0 the rows are the same
            coefficients[..., cosine_rows, :] = operator @ profile.real
        return coefficients

    def evaluate(self, coefficients: FloatArray) -> FloatArray:
        """Values (..., Z, A, C) of expansions (..., T, C) in the directions of the grid."""
        degree = degree_of(coefficients.shape[-2])
        basis = evaluate(degree, self.directions.reshape(-1, 3))
        values = np.einsum("dt,...tc->...dc", basis, coefficients)
        shape = (*coefficients.shape[:-2], self.zenith_count, self.azimuth_count, coefficients.shape[-1])
        return np.asarray(values.reshape(shape))

    def _check_fit(self, shape: tuple[int, ...], degree: int, extension: str) -> None:
        if shape[-3:-1] != (self.zenith_count, self.azimuth_count):
            wanted = f"(..., {self.zenith_count}, {self.azimuth_count}, C)"
            raise ValueError(f"radiance must have shape {wanted}, got {shape}")
        if not 0 <= degree <= self.degree:
            raise ValueError(f"degree must lie between 0 and {self.degree} on this grid, got {degree}")
        if extension not in get_args(Extension):
            raise ValueError(f"extension must be one of {get_args(Extension)}, got {extension!r}")


@lru_cache(maxsize=16)
def _operators(grid: HemisphereGrid, degree: int, extension: Extension) -> tuple[FloatArray, ...]:
    """For each order m the matrix (L - m + 1, Z) from a profile in cos theta to its coefficients.

    The weights contain the integral of cos²(m phi): pi, or 2 pi for m = 0.
    """
    profiles = _profiles(grid, degree)
    weights = [2 * np.pi * grid.zenith_weights, np.pi * grid.zenith_weights]
    build = {"least_squares": _fitted, "zero": _integrated, "even": _doubled}[extension]
    return tuple(
        build(profiles[:, [index(ell, m) for ell in range(m, degree + 1)]], weights[min(m, 1)])
        for m in range(degree + 1)
    )


def _profiles(grid: HemisphereGrid, degree: int) -> FloatArray:
    """Harmonics at azimuth 0, (Z, T): the factors of cos(m phi)."""
    sin_theta = np.sqrt(1 - grid.cos_theta**2)
    return evaluate(degree, np.column_stack([sin_theta, np.zeros_like(sin_theta), grid.cos_theta]))


def _fitted(profiles: FloatArray, weights: FloatArray) -> FloatArray:
    """Least squares over the hemisphere; singular values are roots of the eigenvalues that are cut."""
    root = np.sqrt(weights)
    inverse = np.linalg.pinv(root[:, None] * profiles, rcond=np.sqrt(EIGENVALUE_CUTOFF))
    return np.asarray(inverse * root)


def _integrated(profiles: FloatArray, weights: FloatArray) -> FloatArray:
    """Integral over the hemisphere: the field is zero below."""
    return np.asarray((profiles * weights[:, None]).T)


def _doubled(profiles: FloatArray, weights: FloatArray) -> FloatArray:
    """Integral over the sphere of the field and its mirror image: twice, or nothing where l - m is odd."""
    doubled = 2 * _integrated(profiles, weights)
    doubled[1::2] = 0.0
    return doubled
