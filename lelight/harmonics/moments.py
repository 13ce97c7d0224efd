"""Illuminances of an incident field given as spherical harmonics, by zonal kernels.

A quantity that weighs the radiance L by a function K of the angle to an axis a is, by the addition theorem,

    int L(d) K(d.a) dd = sum_l k_l sqrt(4 pi / (2l + 1)) sum_m L_lm Y_lm(a),
    k_l = sqrt((2l + 1) pi) int_-1^1 K(t) P_l(t) dt.

Plane and cylindrical illuminance are exact for the field that the coefficients describe; scalar,
hemispherical and vector illuminance need degree 1 only and are exact for any field. All are normalised so
that a uniform field L gives pi L; its vector is zero.
"""

from __future__ import annotations

import numpy as np

from lelight.harmonics.basis import degree_of, degrees, evaluate
from lelight.harmonics.zonal import lobe_coefficients
from lelight.scene import FloatArray


def plane(incident: FloatArray, axis: FloatArray) -> FloatArray:
    """Illuminance of a plane element whose normal is ``axis``: int L max(cos, 0).

    Parameters
    ----------
    incident : (..., T, C) float, radiance by the direction that light comes from
    axis : (3,) float, unit, in the frame of the coefficients

    Returns
    -------
    (..., C) float, lx
    """
    return _zonal_moment(incident, axis, plane_kernel(_degree(incident)))


def cylindrical(incident: FloatArray, axis: FloatArray) -> FloatArray:
    """Mean illuminance of a small cylinder along ``axis``: 1/pi int L sin(theta); arguments as in `plane`."""
    return _zonal_moment(incident, axis, cylindrical_kernel(_degree(incident)))


def semicylindrical(incident: FloatArray, axis: FloatArray, *, facing: FloatArray) -> FloatArray:
    """Mean illuminance of a half cylinder along ``axis``: 1/pi int L sin(theta) (1 + cos(phi - phi_facing)).

    The second term is the component of the light vector along ``facing``, over pi.

    Parameters
    ----------
    incident : (..., T, C) float
    axis, facing : (3,) float, unit, perpendicular; the flat side looks away from ``facing``

    Returns
    -------
    (..., C) float, lx
    """
    towards = np.einsum("...ic,i->...c", vector(incident), facing)
    return np.asarray(cylindrical(incident, axis) + towards / np.pi)


def hemispherical(incident: FloatArray, axis: FloatArray) -> FloatArray:
    """Mean illuminance of a small dome with pole ``axis``: 1/4 int L (1 + cos); arguments as in `plane`."""
    towards = np.einsum("...ic,i->...c", vector(incident), axis)
    return np.asarray(scalar(incident) + towards / 4)


def scalar(incident: FloatArray) -> FloatArray:
    """Mean illuminance of a small sphere, 1/4 int L, (..., C) lx, of ``incident`` (..., T, C)."""
    return np.asarray(incident[..., 0, :] * np.sqrt(np.pi) / 2)


def vector(incident: FloatArray) -> FloatArray:
    """Light vector int L(d) d, pointing to where the light comes from.

    Parameters
    ----------
    incident : (..., T, C) float, of degree 1 at least

    Returns
    -------
    (..., 3, C) float, lx, axes of the frame of the coefficients
    """
    if _degree(incident) < 1:
        raise ValueError("incident must have degree 1 at least for a light vector, got degree 0")
    y_z_x = incident[..., 1:4, :] * np.sqrt(4 * np.pi / 3)
    return np.asarray(y_z_x[..., [2, 0, 1], :])


def plane_kernel(degree: int) -> FloatArray:
    """Factors k_l of plane illuminance, (degree + 1,) float: int_0^1 t P_l(t) dt is half of A_l(1)."""
    return _norms(degree) * lobe_coefficients(1.0, degree) / 2


def cylindrical_kernel(degree: int) -> FloatArray:
    """Factors k_l of cylindrical illuminance, (degree + 1,) float, zero at odd l.

    c_l = int_-1^1 sqrt(1 - t²) P_l(t) dt starts with c_0 = pi/2, and the gamma functions of its closed form
    (I. S. Gradshteyn, I. M. Ryzhik, Table of Integrals, 7.132.1) leave the ratio
    c_l+2 / c_l = (l - 1) (l + 1) / ((l + 2) (l + 4)).
    """
    integrals = np.zeros(degree + 1)
    integrals[0] = np.pi / 2
    for ell in range(0, degree - 1, 2):
        integrals[ell + 2] = integrals[ell] * (ell - 1) * (ell + 1) / ((ell + 2) * (ell + 4))
    return _norms(degree) * integrals / np.pi


def _norms(degree: int) -> FloatArray:
    """sqrt((2l + 1) pi) for l = 0 ... degree."""
    return np.asarray(np.sqrt((2 * np.arange(degree + 1) + 1) * np.pi))


def _degree(incident: FloatArray) -> int:
    return degree_of(incident.shape[-2])


def _zonal_moment(incident: FloatArray, axis: FloatArray, kernel: FloatArray) -> FloatArray:
    degree = len(kernel) - 1
    ell = degrees(degree)
    factors = kernel[ell] * np.sqrt(4 * np.pi / (2 * ell + 1)) * evaluate(degree, np.reshape(axis, (1, 3)))[0]
    return np.asarray(np.einsum("...tc,t->...c", incident, factors))
