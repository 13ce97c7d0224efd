from __future__ import annotations

from fractions import Fraction
from math import comb, log

import numpy as np
import pytest
from numpy.polynomial.legendre import legval

from lelight.harmonics.basis import evaluate
from lelight.harmonics.frames import mirrored
from lelight.harmonics.projection import project
from lelight.harmonics.zonal import beam_error, degree_for, largest_exponent, lobe_coefficients, reflected
from lelight.storeddegree import lobe_degree


def exact_lobe_coefficient(exponent, ell):
    """(n + 1) int_0^1 t^n P_l(t) dt as a fraction, from the coefficients of P_l."""
    total = Fraction(0)
    for j in range(ell // 2 + 1):
        power = ell - 2 * j
        coefficient = (-1) ** j * comb(ell, j) * comb(2 * ell - 2 * j, ell)
        total += coefficient * (exponent + 1) / (exponent + power + 1)
    return float(total / 2**ell)


@pytest.mark.parametrize("exponent", ["1", "5/2", "8", "16", "100", "1000", "10000"])
def test_recurrence_against_exact_fractions(exponent):
    exponent = Fraction(exponent)
    found = lobe_coefficients(float(exponent), 256)
    chosen = [0, 1, 2, 3, 9, 10, 31, 64, 127, 128, 255, 256]
    expected = [exact_lobe_coefficient(exponent, ell) for ell in chosen]
    np.testing.assert_allclose(found[chosen], expected, rtol=1e-13, atol=0)


def view_directions():
    theta, azimuth = np.meshgrid(np.linspace(0, np.pi / 2, 91), np.linspace(0, np.pi, 19), indexing="ij")
    sin_theta = np.sin(theta)
    return np.stack([sin_theta * np.cos(azimuth), sin_theta * np.sin(azimuth), np.cos(theta)], -1).reshape(
        -1, 3
    )


def beams(elevations):
    angle = np.radians(elevations)
    return np.column_stack([np.cos(angle), np.zeros(len(angle)), np.sin(angle)])


def largest_error(exponent, degree, elevation, *, lobe_exponent=None):
    """Largest error over the hemisphere of one reflected beam, in shares of the peak of its lobe."""
    beam = beams([elevation])
    radiance = reflected(
        project(degree, mirrored(beam), np.ones((1, 1))),
        np.zeros(1),
        diffuse=np.zeros(1),
        specular=np.ones(1),
        exponent=lobe_exponent or exponent,
    )
    views = np.vstack([view_directions(), mirrored(beam)])
    cos_alpha = np.clip(views @ mirrored(beam)[0], 0, None)
    peak = (exponent + 2) / (2 * np.pi)
    return np.abs(evaluate(degree, views) @ radiance[:, 0] / peak - cos_alpha**exponent).max()


@pytest.mark.parametrize("elevation", [0, 10, 45, 80, 89])
@pytest.mark.parametrize("exponent", [4, 16, 64, 256])
def test_product_of_coefficients_is_the_lobe(exponent, elevation):
    assert largest_error(exponent, lobe_degree(exponent), elevation) < 1e-3


@pytest.mark.parametrize("elevation", [0, 45, 89])
def test_weakest_lobe_converges_as_its_kink_allows(elevation):
    # The tail of the clamped cosine's series falls as 1 / L: 5.9 % at 4 and 0.95 % at 32, to two digits.
    assert 0.058 < largest_error(1, degree_for(1), elevation) < 0.060
    assert 0.0090 < largest_error(1, 32, elevation) < 0.0096


@pytest.mark.parametrize("exponent", [4, 16, 64, 256])
def test_degree_rule_is_needed_and_wrong_lobes_are_seen(exponent):
    assert largest_error(exponent, degree_for(exponent) // 2, 45) > 0.01
    degree = degree_for(exponent, eps=1e-3)
    assert largest_error(exponent, degree, 45, lobe_exponent=1.1 * exponent) > 0.03


def test_degree_rule():
    # L = ceil(sqrt(2 n ln 100)): 6.07, 12.1, 24.3, 48.6 for n = 4, 16, 64, 256.
    assert [degree_for(n) for n in (0, 4, 16, 64, 256)] == [0, 7, 13, 25, 49]
    assert degree_for(50, eps=1e-3) ** 2 >= 100 * log(1000) > (degree_for(50, eps=1e-3) - 1) ** 2


def test_many_coloured_beams_with_both_lobes():
    rng = np.random.default_rng(2)
    directions = beams(rng.uniform(0, 90, 40))
    illuminances = rng.uniform(0, 50, (40, 3))
    diffuse, specular, exponent, degree = np.array([0.5, 0.3, 0.0]), np.array([0.1, 0.0, 0.6]), 16, 15
    radiance = reflected(
        project(degree, mirrored(directions), illuminances),
        illuminances.sum(axis=0),
        diffuse=diffuse,
        specular=specular,
        exponent=exponent,
    )
    views = view_directions()
    cos_alpha = np.clip(views @ mirrored(directions).T, 0, None)
    lobe = specular * (exponent + 2) / (2 * np.pi) * (cos_alpha**exponent @ illuminances)
    expected = diffuse / np.pi * illuminances.sum(axis=0) + lobe
    # One beam is right to 6.2e-5 of its peak at this degree; all of them together to the sum of that.
    bound = 6.3e-5 * specular * (exponent + 2) / (2 * np.pi) * illuminances.sum(axis=0) + 1e-12
    error = np.abs(evaluate(degree, views) @ radiance - expected).max(axis=0)
    assert np.all(error <= bound), error / bound


def test_lambertian_surface_is_constant_up_to_the_horizon():
    beam = beams([3.0])
    illuminance = np.array([700.0])
    mirrored_light = project(20, mirrored(beam), illuminance[None])
    radiance = reflected(
        mirrored_light, illuminance, diffuse=np.array([0.8]), specular=np.zeros(1), exponent=16.0
    )
    views = beams(90 - np.array([0, 45, 80, 89, 89.9]))
    np.testing.assert_allclose(evaluate(20, views) @ radiance, 0.8 * 700 / np.pi, rtol=1e-6)


def test_leading_axes_are_kept():
    rng = np.random.default_rng(4)
    light, illuminance = rng.normal(size=(5, 2, 9, 3)), rng.uniform(size=(5, 2, 3))
    optics = {"diffuse": np.full(3, 0.4), "specular": np.full(3, 0.2), "exponent": 7.0}
    together = reflected(light, illuminance, **optics)
    np.testing.assert_array_equal(together[3, 1], reflected(light[3, 1], illuminance[3, 1], **optics))


def test_rejects_what_has_no_lobe():
    with pytest.raises(ValueError, match="exponent must be greater than -1"):
        lobe_coefficients(-1.0, 3)
    with pytest.raises(ValueError, match="exponent must be greater than -1"):
        lobe_coefficients(float("nan"), 3)
    with pytest.raises(ValueError, match="exponent must not be negative"):
        degree_for(-0.5)
    with pytest.raises(ValueError, match="eps must lie between 0 and 1"):
        degree_for(16, eps=1.0)


@pytest.mark.parametrize("exponent", [4.0, 16.0, 64.0, 256.0])
def test_stored_beams_have_no_dark_lobes(exponent):
    """The worst that can be stored, light from one direction: never below -1e-3 of its peak, at any elevation."""
    degree = lobe_degree(exponent)
    views = np.concatenate([view_directions(), view_directions() * [1.0, 1.0, -1.0]])
    peak = (exponent + 2) / (2 * np.pi)
    for elevation in (0, 1, 10, 45, 80, 89):
        radiance = reflected(
            project(degree, mirrored(beams([elevation])), np.ones((1, 1))),
            np.zeros(1),
            diffuse=np.zeros(1),
            specular=np.ones(1),
            exponent=exponent,
        )
        assert (evaluate(degree, views) @ radiance[:, 0]).min() >= -1e-3 * peak


def least_share(exponent, degree):
    """Least value of a stored beam, in shares of the peak of its lobe."""
    cosine = np.cos(np.radians(np.linspace(0, 180, 721)))
    orders = 2 * np.arange(degree + 1) + 1
    return legval(cosine, orders * lobe_coefficients(exponent, degree) / (2 * exponent + 2)).min()


def test_ripples_of_all_stored_exponents_stay_above_the_bar():
    exponents = np.concatenate([np.arange(2, 16, 0.25), np.arange(16, 256.1, 0.5)])
    assert min(least_share(n, lobe_degree(n)) for n in exponents) > -9.5e-4
    assert max(beam_error(n, lobe_degree(n)) for n in exponents) < 1e-3
    # One per cent of the peak would not be enough.
    assert least_share(24.0, degree_for(24.0)) < -1.3e-3


def test_stated_beam_error_is_that_of_the_sum_of_harmonics():
    for exponent, degree in ((1.0, 13), (16.0, 13), (256.0, 49)):
        found = max(largest_error(exponent, degree, elevation) for elevation in (10, 45, 80, 89))
        assert beam_error(exponent, degree) == pytest.approx(found, rel=0.03)
    # n = 1 has a kink: below 1e-3 of the peak from degree 317 on only, beyond anything stored.
    assert beam_error(1.0, 316) > 1e-3 > beam_error(1.0, 320)
    assert degree_for(largest_exponent(30)) == 30
