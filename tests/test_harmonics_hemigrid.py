from __future__ import annotations

import numpy as np
import pytest

from lelight.harmonics.basis import degrees, evaluate, index, orders, terms
from lelight.harmonics.hemigrid import HemisphereGrid
from lelight.harmonics.spectrum import energy_by_degree

RULES = ["gauss", "legendre"]


def hemisphere():
    theta, azimuth = np.meshgrid(np.linspace(0, np.pi / 2, 91), np.linspace(0, 2 * np.pi, 37), indexing="ij")
    sin_theta = np.sin(theta)
    directions = np.stack([sin_theta * np.cos(azimuth), sin_theta * np.sin(azimuth), np.cos(theta)], axis=-1)
    return directions.reshape(-1, 3)


def constant(directions):
    return np.ones(directions.shape[:-1])


def lobe(zenith_angle, exponent):
    angle = np.radians(zenith_angle)
    axis = np.array([np.sin(angle), 0, np.cos(angle)])
    return lambda directions: np.clip(directions @ axis, 0, None) ** exponent


def largest_error(grid, field, degree, extension):
    coefficients = grid.fit(field(grid.directions)[..., None], degree, extension=extension)
    views = hemisphere()
    return np.abs(evaluate(degree, views) @ coefficients[:, 0] - field(views)).max()


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("degree", [4, 16, 40])
def test_zero_extension_rings_by_half_at_any_degree(rule, degree):
    # The series of a jump converges to its middle: half the value at the horizon, whatever the degree.
    grid = HemisphereGrid(degree + 1, 2 * degree + 1, rule)
    assert largest_error(grid, constant, degree, "zero") == pytest.approx(0.5, abs=5e-3)


@pytest.mark.parametrize(
    ("field", "degree", "zero", "even", "least_squares"),
    [
        (constant, 16, 0.50, 0.0, 1.3e-4),
        (lobe(75, 16), 13, 0.22, 0.127, 3.5e-4),
        (lobe(85, 16), 13, 0.435, 0.070, 3.6e-4),
        (lobe(85, 64), 25, 0.327, 0.130, 1.5e-3),
    ],
    ids=["constant", "n16 at 75", "n16 at 85", "n64 at 85"],
)
def test_extensions_have_their_measured_errors(field, degree, zero, even, least_squares):
    # Measured; they agree with the theory where there is one (constant: 1/2 and 0) and guard the fit.
    grid = HemisphereGrid(2 * degree + 2, 4 * degree + 1)
    assert largest_error(grid, field, degree, "zero") == pytest.approx(zero, rel=0.03)
    assert largest_error(grid, field, degree, "even") == pytest.approx(even, rel=0.03, abs=1e-12)
    assert largest_error(grid, field, degree, "least_squares") < 1.05 * least_squares


def test_half_range_nodes_serve_least_squares_better_at_equal_count():
    degree = 16
    errors = [
        largest_error(HemisphereGrid(degree + 1, 2 * degree + 1, rule), constant, degree, "least_squares")
        for rule in RULES
    ]
    assert errors[0] < 1.4e-4
    assert 5e-3 < errors[1] < 1.5e-2


@pytest.mark.parametrize("rule", RULES)
def test_small_band_limited_field_is_recovered(rule):
    truth = np.random.default_rng(6).normal(size=(terms(2), 3))
    grid = HemisphereGrid(3, 5, rule)
    radiance = np.einsum("zat,tc->zac", evaluate(2, grid.directions.reshape(-1, 3)).reshape(3, 5, -1), truth)
    np.testing.assert_allclose(grid.fit(radiance, 2), truth, rtol=0, atol=1e-11)


def test_zero_and_even_agree_with_integrals():
    # For a field that is even about the horizon both halves carry the same: even gives it back, zero half of
    # the coefficients with l - m even.
    even_terms = (degrees(6) - orders(6)) % 2 == 0
    truth = np.where(even_terms, np.random.default_rng(8).normal(size=terms(6)), 0.0)[:, None]
    grid = HemisphereGrid(7, 13)
    radiance = (evaluate(6, grid.directions.reshape(-1, 3)) @ truth).reshape(7, 13, 1)
    np.testing.assert_allclose(grid.fit(radiance, 6, extension="even"), truth, rtol=0, atol=1e-12)
    halved = grid.fit(radiance, 6, extension="zero")
    np.testing.assert_allclose(halved[even_terms], truth[even_terms] / 2, rtol=0, atol=1e-12)


def test_exitance_by_the_grid_is_pi_for_unit_radiance():
    grid = HemisphereGrid(6, 11)
    weights = grid.zenith_weights * 2 * np.pi / grid.azimuth_count
    assert np.sum(weights * grid.cos_theta * 11) == pytest.approx(np.pi, rel=1e-14)
    np.testing.assert_allclose(np.linalg.norm(grid.directions, axis=-1), 1, rtol=1e-14)
    np.testing.assert_allclose(grid.directions[..., 2], np.repeat(grid.cos_theta[:, None], 11, 1), rtol=0)


def test_leading_axes_are_kept():
    grid = HemisphereGrid(5, 9)
    radiance = np.random.default_rng(9).uniform(size=(2, 3, 5, 9, 2))
    together = grid.fit(radiance, 3)
    assert together.shape == (2, 3, 16, 2)
    np.testing.assert_allclose(together[1, 2], grid.fit(radiance[1, 2], 3), rtol=0, atol=1e-13)


def test_energy_is_the_integral_of_the_square():
    # A constant continued evenly is 1 everywhere: all its energy, 4 pi, is in degree 0.
    grid = HemisphereGrid(9, 17)
    energy = energy_by_degree(grid.fit(np.ones((9, 17, 1)), 8, extension="even"))
    np.testing.assert_allclose(energy[:, 0], [4 * np.pi, *[0] * 8], rtol=0, atol=1e-12)


def test_azimuth_sign():
    # A field sin(phi) sin(theta) is Y_1,-1 alone.
    grid = HemisphereGrid(4, 7)
    found = grid.fit(grid.directions[..., [1]], 1)
    expected = np.zeros((4, 1))
    expected[index(1, -1)] = np.sqrt(4 * np.pi / 3)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


def test_rejects_grids_and_samples_that_do_not_fit():
    grid = HemisphereGrid(4, 9)
    assert grid.degree == 3
    with pytest.raises(ValueError, match="degree must lie between 0 and 3 on this grid, got 4"):
        grid.fit(np.ones((4, 9, 1)), 4)
    with pytest.raises(ValueError, match=r"radiance must have shape \(..., 4, 9, C\)"):
        grid.fit(np.ones((9, 4, 1)), 2)
    with pytest.raises(ValueError, match="extension must be one of"):
        grid.fit(np.ones((4, 9, 1)), 2, extension="odd")
    with pytest.raises(ValueError, match="rule must be one of"):
        HemisphereGrid(4, 9, "uniform")
    with pytest.raises(ValueError, match="must be positive"):
        HemisphereGrid(0, 9)
