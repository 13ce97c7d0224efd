from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.spatial.transform import Rotation

from lelight.harmonics.basis import evaluate, terms
from lelight.harmonics.moments import (
    cylindrical,
    cylindrical_kernel,
    hemispherical,
    plane,
    plane_kernel,
    scalar,
    semicylindrical,
    vector,
)
from lelight.harmonics.projection import project

UP = np.array([0.0, 0.0, 1.0])
AHEAD = np.array([1.0, 0.0, 0.0])


def quadrature():
    """Angles and weights of the sphere: Gauss-Legendre in theta on each half, for the kink at pi/2."""
    nodes, weights = leggauss(40)
    half = (nodes + 1) * pi / 4
    theta = np.concatenate([half, half + pi / 2])
    azimuth = np.arange(40) * 2 * pi / 40
    theta_weights = np.tile(weights, 2) * pi / 4 * np.sin(theta)
    theta, azimuth = np.meshgrid(theta, azimuth, indexing="ij")
    return theta.ravel(), azimuth.ravel(), np.repeat(theta_weights * 2 * pi / 40, 40)


@pytest.fixture(scope="module")
def turned():
    """A random band-limited field, its values on the sphere about a turned axis, and that axis."""
    theta, azimuth, weights = quadrature()
    turn = Rotation.from_rotvec([0.7, -0.4, 1.1])
    local = np.column_stack([np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), np.cos(theta)])
    field = np.random.default_rng(3).normal(size=(terms(9), 2))
    directions = turn.apply(local)
    weighted = evaluate(9, directions) @ field * weights[:, None]
    return field, weighted, theta, azimuth, directions, turn


def test_moments_about_any_axis_are_the_integrals(turned):
    field, weighted, theta, azimuth, directions, turn = turned
    axis, facing = turn.apply(UP), turn.apply(AHEAD)
    cos_theta, sin_theta = np.cos(theta), np.sin(theta)
    close = {"rtol": 0, "atol": 1e-12}
    np.testing.assert_allclose(plane(field, axis), np.clip(cos_theta, 0, None) @ weighted, **close)
    np.testing.assert_allclose(cylindrical(field, axis), sin_theta @ weighted / pi, **close)
    np.testing.assert_allclose(scalar(field), weighted.sum(axis=0) / 4, **close)
    np.testing.assert_allclose(hemispherical(field, axis), (1 + cos_theta) @ weighted / 4, **close)
    half = sin_theta * (1 + np.cos(azimuth)) @ weighted / pi
    np.testing.assert_allclose(semicylindrical(field, axis, facing=facing), half, **close)
    np.testing.assert_allclose(vector(field), directions.T @ weighted, **close)
    assert np.abs(plane(field, UP) - plane(field, axis)).max() > 0.1


def test_plane_kernel_has_the_published_values():
    # R. Ramamoorthi, P. Hanrahan, An efficient representation for irradiance environment maps, SIGGRAPH 2001,
    # eq. (8): pi, 2 pi/3, pi/4, 0, -pi/24, 0, pi/64 multiply L_lm Y_lm.
    factors = plane_kernel(6) * np.sqrt(4 * pi / (2 * np.arange(7) + 1))
    expected = np.array([1, 2 / 3, 1 / 4, 0, -1 / 24, 0, 1 / 64]) * pi
    np.testing.assert_allclose(factors, expected, rtol=1e-14, atol=1e-16)


def test_cylindrical_kernel_has_closed_values():
    # int sqrt(1 - t²) P_l dt = pi/2, 0, -pi/16, 0, -pi/128 (from int sqrt(1 - t²) t^2k = pi/2, pi/8, pi/16).
    expected = np.sqrt((2 * np.arange(5) + 1) * pi) * np.array([1 / 2, 0, -1 / 16, 0, -1 / 128])
    np.testing.assert_allclose(cylindrical_kernel(4), expected, rtol=1e-14, atol=0)


def test_uniform_field_gives_pi_in_every_measure():
    uniform = np.zeros((terms(4), 1))
    uniform[0] = sqrt(4 * pi)
    measures = [
        plane(uniform, UP),
        cylindrical(uniform, UP),
        semicylindrical(uniform, UP, facing=AHEAD),
        hemispherical(uniform, UP),
        scalar(uniform),
    ]
    np.testing.assert_allclose(measures, pi, rtol=1e-14)
    assert np.all(vector(uniform) == 0)


def test_uniform_upper_hemisphere():
    # L_00 = sqrt(pi), L_10 = pi sqrt(3 / 4 pi): scalar pi/2, dome 3 pi/4, vector pi upwards.
    sky = np.zeros((4, 1))
    sky[0], sky[2] = sqrt(pi), pi * sqrt(3 / (4 * pi))
    np.testing.assert_allclose(scalar(sky), pi / 2, rtol=1e-14)
    np.testing.assert_allclose(hemispherical(sky, UP), 3 * pi / 4, rtol=1e-14)
    np.testing.assert_allclose(vector(sky)[:, 0], [0, 0, pi], rtol=1e-14)


def test_beam_has_vector_four_times_scalar():
    direction = np.array([[0.48, 0.6, 0.64]])
    beam = project(3, direction, np.array([[5.0]]))
    np.testing.assert_allclose(vector(beam)[:, 0], 5 * direction[0], rtol=1e-13)
    np.testing.assert_allclose(scalar(beam), 5 / 4, rtol=1e-14)


def test_beam_on_cylinder_converges():
    # Ez = E sin(theta) / pi. Integrals c_l ~ l^-3, P_l(cos theta) ~ l^-1/2: terms l^-2.5, tail l^-1.5 < 1e-3.
    direction = np.array([[0.6, 0.0, 0.8]])
    beam = project(128, direction, np.ones((1, 1)))
    np.testing.assert_allclose(cylindrical(beam, UP), 0.6 / pi, rtol=0, atol=1e-3)


def test_leading_axes_are_kept():
    fields = np.random.default_rng(1).normal(size=(3, 2, 9, 4))
    assert vector(fields).shape == (3, 2, 3, 4)
    np.testing.assert_allclose(plane(fields, UP)[2, 1], plane(fields[2, 1], UP), rtol=1e-14)


def test_vector_needs_degree_one():
    with pytest.raises(ValueError, match="degree 1 at least"):
        vector(np.ones((1, 1)))
