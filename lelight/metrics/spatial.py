"""Spatial illuminances from the radiance that arrives at a point: sums over directions and SH kernels.

All are normalised so that a uniform field L gives π L: mean spherical ``1/4 ∫ L dω``, cylindrical
``1/π ∫ L sin θ dω``, semicylindrical ``1/π ∫ L sin θ (1 + cos(φ - φ_f)) dω``, hemispherical
``1/4 ∫ L (1 + cos θ) dω``; the light vector is ``∫ L d dω`` and points to the light (EN 12464-1,
EN 13201-3 and Cuttle 2003; the normalisations were checked against closed-form fields). Semicylindrical and
hemispherical illuminance follow exactly from scalar illuminance, cylindrical illuminance and light vector.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lelight.receivers import CYLINDRICAL, SCALAR, VECTOR
from lelight.scene import FloatArray


def scalar_illuminance(luminance: FloatArray, solid_angles: FloatArray) -> float:
    """Mean spherical illuminance (lx) of luminances (n,) in solid angles (n,)."""
    return float(luminance @ solid_angles) / 4


def light_vector(luminance: FloatArray, directions: FloatArray, solid_angles: FloatArray) -> FloatArray:
    """Light vector (3,) in lx; ``directions`` (n, 3) point to the light."""
    return np.asarray((luminance * solid_angles) @ directions)


def plane_illuminance(
    luminance: FloatArray, directions: FloatArray, solid_angles: FloatArray, *, normal: FloatArray
) -> float:
    """Illuminance (lx) on a plane with unit normal (3,)."""
    return float((luminance * solid_angles) @ np.maximum(directions @ normal, 0.0))


def cylindrical_illuminance(luminance: FloatArray, directions: FloatArray, solid_angles: FloatArray) -> float:
    """Mean vertical illuminance (lx) over all bearings; z is up."""
    return float((luminance * solid_angles) @ np.hypot(directions[:, 0], directions[:, 1])) / math.pi


def semicylindrical(cylindrical: FloatArray, vector: FloatArray, facing: FloatArray) -> FloatArray:
    """Semicylindrical illuminance (...) from E_z (...) and light vector (..., 3): ``E_z + E · f / π``.

    ``sin θ cos(φ - φ_f)`` is the direction's component along the horizontal unit vector f (3,), so the second
    term is the vector's component along it.
    """
    return np.asarray(cylindrical + vector @ facing / math.pi)


def hemispherical(scalar: FloatArray, vector: FloatArray) -> FloatArray:
    """Hemispherical illuminance (...), axis up, from E_sr (...) and light vector (..., 3): E_sr + E_up / 4."""
    return np.asarray(scalar + vector[..., 2] / 4)


def symmetric_scalar(scalar: FloatArray, vector: FloatArray) -> FloatArray:
    """Part of the scalar illuminance (...) that has no direction: ``E_sr - |E| / 4``."""
    return np.asarray(scalar - np.linalg.norm(vector, axis=-1) / 4)


def altitude(vector: FloatArray) -> float:
    """Angle in degrees by which a light vector (3,) comes from above the horizon."""
    return math.degrees(math.atan2(float(vector[2]), math.hypot(float(vector[0]), float(vector[1]))))


def moment_parts(moments: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Split moments (..., 6) into scalar illuminance (...), light vector (..., 3), cylindrical (...)."""
    return moments[..., SCALAR], moments[..., VECTOR : VECTOR + 3], moments[..., CYLINDRICAL]


def zonal_kernel(name: str, degree: int) -> FloatArray:
    """Coefficients k_l (degree + 1,) with ``E = sum k_l L_l0`` in orthonormal harmonics about the axis.

    ``k_l = 2π N_l ∫ w(t) P_l(t) dt`` with the receiver's weight w of t = cos θ and N_l = sqrt((2l + 1)/(4π)),
    by Gauss-Legendre quadrature in θ, exact to rounding.

    Parameters
    ----------
    name : ``plane``, ``cylindrical``, ``scalar``, ``hemispherical`` or ``vector`` (its axial component)
    """
    if name not in _WEIGHTS:
        raise ValueError(f"name: {name!r}, allowed are {', '.join(_WEIGHTS)}")
    # Two pieces in θ, so that the plane's kink lies between them; sin θ is then smooth on each.
    nodes, weights = np.polynomial.legendre.leggauss(degree + 24)
    theta = np.concatenate([(nodes + 1), (nodes + 3)]) * math.pi / 4
    measure = np.tile(weights, 2) * math.pi / 4 * np.sin(theta) * 2 * math.pi
    weighted = measure * _WEIGHTS[name](theta)
    legendre = np.polynomial.legendre.legvander(np.cos(theta), degree)
    norms = np.sqrt((2 * np.arange(degree + 1) + 1) / (4 * math.pi))
    return np.asarray(norms * (weighted @ legendre))


_WEIGHTS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "plane": lambda theta: np.maximum(np.cos(theta), 0.0),
    "cylindrical": lambda theta: np.sin(theta) / math.pi,
    "scalar": lambda theta: np.full_like(theta, 0.25),
    "hemispherical": lambda theta: (1 + np.cos(theta)) / 4,
    "vector": np.cos,
}
