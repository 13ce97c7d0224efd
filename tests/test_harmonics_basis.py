from __future__ import annotations

from fractions import Fraction
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss
from scipy.special import eval_legendre, sph_harm_y

from lelight.harmonics.basis import MAX_DEGREE, degree_of, degrees, evaluate, index, names, orders, terms


def direction(cos_theta, azimuth):
    sin_theta = np.sqrt(1 - np.square(cos_theta))
    return np.stack([sin_theta * np.cos(azimuth), sin_theta * np.sin(azimuth), cos_theta], axis=-1)


unit_vectors = st.builds(direction, st.floats(-1, 1), st.floats(0, 2 * pi))


def test_orthonormal_to_degree_32():
    # Gauss-Legendre with 33 nodes is exact to degree 65, 65 azimuths to order 64; products have degree 64.
    nodes, weights = leggauss(33)
    cos_theta, azimuth = np.meshgrid(nodes, np.arange(65) * 2 * pi / 65, indexing="ij")
    harmonics = evaluate(32, direction(cos_theta, azimuth).reshape(-1, 3))
    gram = harmonics.T @ (harmonics * np.repeat(weights * 2 * pi / 65, 65)[:, None])
    np.testing.assert_allclose(gram, np.eye(terms(32)), rtol=0, atol=1e-12)


def test_first_degree_fixes_the_convention():
    # Y_1,-1 = c y, Y_10 = c z, Y_11 = c x with c = sqrt(3 / 4 pi): no Condon-Shortley phase, sines first.
    x, y, z = 0.48, -0.6, 0.64
    expected = np.array([1.0, sqrt(3) * y, sqrt(3) * z, sqrt(3) * x]) / sqrt(4 * pi)
    np.testing.assert_allclose(evaluate(1, np.array([[x, y, z]]))[0], expected, rtol=1e-15)


def test_agrees_with_scipy_to_degree_128():
    rng = np.random.default_rng(1)
    theta = np.append(rng.uniform(0, pi, 12), [1e-3, pi - 1e-3, pi / 2])
    azimuth = rng.uniform(-pi, pi, len(theta))
    sin_theta = np.sin(theta)
    directions = np.column_stack([sin_theta * np.cos(azimuth), sin_theta * np.sin(azimuth), np.cos(theta)])
    order = orders(MAX_DEGREE)
    phased = sph_harm_y(degrees(MAX_DEGREE), abs(order), theta[:, None], azimuth[:, None])
    parts = np.where(order >= 0, phased.real, phased.imag)
    expected = np.where(order == 0, parts, sqrt(2) * (-1.0) ** order * parts)
    np.testing.assert_allclose(evaluate(MAX_DEGREE, directions), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("ell", [0, 1, 7, 64, 128])
def test_closed_values_at_poles_and_equator(ell):
    # P_l(1) = 1, P_l(-1) = (-1)^l; Y_ll at the x axis is sqrt(2 (2l + 1)!! / ((2l)!! 4 pi)), l > 0.
    up, down, along_x = evaluate(ell, np.array([[0, 0, 1.0], [0, 0, -1], [1, 0, 0]]))
    np.testing.assert_allclose(up[index(ell, 0)], sqrt((2 * ell + 1) / (4 * pi)), rtol=1e-13)
    np.testing.assert_allclose(down[index(ell, 0)], (-1) ** ell * sqrt((2 * ell + 1) / (4 * pi)), rtol=1e-13)
    ratio = Fraction(2 if ell else 1)
    for k in range(1, ell + 1):
        ratio *= Fraction(2 * k + 1, 2 * k)
    np.testing.assert_allclose(along_x[index(ell, ell)], sqrt(ratio / 4 / pi), rtol=1e-13)
    assert np.all(np.delete(up, [index(n, 0) for n in range(ell + 1)]) == 0)


@given(unit_vectors, unit_vectors)
@settings(deadline=None, max_examples=60)
def test_addition_theorem(first, second):
    harmonics = evaluate(40, np.stack([first, second]))
    sums = np.add.reduceat(harmonics[0] * harmonics[1], np.arange(41) ** 2)
    ell = np.arange(41)
    expected = (2 * ell + 1) / (4 * pi) * eval_legendre(ell, np.clip(first @ second, -1, 1))
    np.testing.assert_allclose(sums, expected, rtol=0, atol=2e-12)


def test_numbering():
    assert names(1) == ("Y_0_0", "Y_1_-1", "Y_1_0", "Y_1_1")
    pairs = list(zip(degrees(9).tolist(), orders(9).tolist(), strict=True))
    assert [index(ell, m) for ell, m in pairs] == list(range(terms(9)))
    assert [degree_of(terms(ell)) for ell in range(20)] == list(range(20))


@pytest.mark.parametrize("degree", [-1, MAX_DEGREE + 1])
def test_rejects_degrees_beyond_the_tables(degree):
    with pytest.raises(ValueError, match="degree must lie between 0 and 128"):
        evaluate(degree, np.array([[0, 0, 1.0]]))


def test_rejects_wrong_shapes_and_numbers():
    with pytest.raises(ValueError, match=r"directions must have shape \(k, 3\)"):
        evaluate(2, np.array([0, 0, 1.0]))
    with pytest.raises(ValueError, match="order must lie between -2 and 2"):
        index(2, 3)
    with pytest.raises(ValueError, match="1, 4, 9"):
        degree_of(5)
    with pytest.raises(ValueError, match="negative"):
        terms(-1)
