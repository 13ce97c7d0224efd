"""Nothing below zero is stored: what rings or scatters there is lifted, all else keeps its bits."""

from __future__ import annotations

import numpy as np
import pytest
from rooms import normalised

from lelight.harmonics.basis import evaluate
from lelight.harmonics.dark import without_dark
from lelight.harmonics.moments import plane
from lelight.harmonics.projection import project
from lelight.harmonics.zonal import beam_error, reflected

DEGREE = 13
UP = np.array([0.0, 0.0, 1.0])
#: Least share of the peak that may be stored.
BAR = -1e-3


def views(count=20_000):
    directions = normalised(np.random.default_rng(5).normal(size=(count, 3)))
    return directions * np.where(directions[:, 2:] < 0, -1.0, 1.0)


def beam(exponent, elevation, *, diffuse=0.0, degree=DEGREE):
    """Coefficients (1, T, 1) of what one beam of 1 lx becomes."""
    angle = np.radians(elevation)
    mirrored = np.array([[-np.cos(angle), 0.0, np.sin(angle)]])
    light = project(degree, mirrored, np.ones((1, 1)))
    return reflected(
        light[None], np.ones((1, 1)), diffuse=np.full(1, diffuse), specular=np.ones(1), exponent=exponent
    )


def share(radiance):
    """Least over largest radiance over the horizon, of (T,)."""
    seen = evaluate(DEGREE, views()) @ radiance
    return seen.min() / seen.max()


@pytest.mark.parametrize("elevation", [5, 30, 60, 90])
@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 1.75])
def test_blunt_lobes_that_ring_are_lifted(exponent, elevation):
    ringing = beam(exponent, elevation)
    found = without_dark(ringing)
    assert share(found[0, :, 0]) >= BAR
    np.testing.assert_allclose(plane(found[0], UP), plane(ringing[0], UP), rtol=1e-12)
    # No further than needed: the lobe is not lost.
    lost = np.abs(evaluate(DEGREE, views()) @ (found - ringing)[0, :, 0]).max()
    assert lost < 1.5 * beam_error(exponent, DEGREE) * (exponent + 2) / (2 * np.pi)


def test_without_the_repair_they_would_be_dark():
    assert share(beam(1.0, 30)[0, :, 0]) < -5e-3
    assert share(beam(0.5, 60)[0, :, 0]) < -1e-2


def test_what_is_nowhere_dark_keeps_its_bits():
    sound = np.concatenate([beam(16.0, 40), beam(1.0, 40, diffuse=0.5), beam(4.0, 89)])
    assert np.array_equal(without_dark(sound), sound)
    lambertian = np.array([[[0.3]], [[0.0]]])
    assert np.array_equal(without_dark(lambertian), lambertian)


def test_each_node_and_channel_is_on_its_own():
    fine, ringing = beam(16.0, 40)[0, :, 0], beam(0.5, 40)[0, :, 0]
    both = np.array([[fine, ringing], [ringing, 3.0 * fine]]).transpose(0, 2, 1)
    found = without_dark(both)
    assert np.array_equal(found[0, :, 0], fine)
    assert np.array_equal(found[1, :, 1], 3.0 * fine)
    alone = without_dark(ringing[None, :, None])[0, :, 0]
    assert np.array_equal(found[0, :, 1], alone)
    assert np.array_equal(found[1, :, 0], alone)


def test_what_scatters_below_zero_comes_nearer_to_the_light_without_noise():
    rng = np.random.default_rng(2)
    from_where = normalised(rng.normal(size=(30, 3))) * [1.0, 1.0, 0.0] + [0.0, 0.0, 0.4]
    light, noise = rng.exponential(size=(2, 30, 1))
    signs = rng.choice([-1.5, 1.5], size=(30, 1))
    right, noisy = (
        reflected(
            project(DEGREE, normalised(from_where), each)[None],
            np.ones((1, 1)),
            diffuse=np.zeros(1),
            specular=np.ones(1),
            exponent=16.0,
        )[0, :, 0]
        for each in (light, light + signs * noise)
    )
    found = without_dark(noisy[None, :, None])[0, :, 0]
    assert share(right) > BAR > -0.01 > share(noisy)
    assert share(found) >= BAR
    assert np.linalg.norm(found - right) < np.linalg.norm(noisy - right)


def test_noise_about_nothing():
    """As at a node in the dark: a mean above zero is kept without a sign, one below leaves nothing."""
    noise = np.random.default_rng(1).normal(size=((DEGREE + 1) ** 2,))
    above, below = noise.copy(), noise.copy()
    for each, mean in ((above, 0.01), (below, -0.01)):
        each[0] += (mean - plane(each[:, None], UP)[0] / np.pi) * np.sqrt(4 * np.pi)
    found = without_dark(np.stack([above, below])[..., None])
    assert share(above) < -0.5
    assert share(found[0, :, 0]) >= BAR
    assert plane(found[0], UP)[0] / np.pi == pytest.approx(0.01, rel=1e-9)
    assert not found[1].any()
