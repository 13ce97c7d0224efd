"""The two lobes: what they reflect, that they are reciprocal, and how a walk chooses between them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss
from rooms import grey, lit
from shapes import box

from lelight.channels import channel_matrix
from lelight.scene import Material
from lelight.tracing.reflection import collect_reflectances, diffuse_probability, lobe, lobe_density
from lelight.tracing.sampling import mirrored

EXACT = 1e-9
exponents = st.floats(0, 1e4)
directions = st.tuples(st.floats(0.01, 1), st.floats(-math.pi, math.pi)).map(
    lambda place: (
        math.sqrt(1 - place[0] ** 2) * math.cos(place[1]),
        math.sqrt(1 - place[0] ** 2) * math.sin(place[1]),
        place[0],
    )
)


def directional_albedo(exponent, cos_in, *, order=150):
    """What a lobe of ks = 1 reflects of light from a direction: integral of lobe x cosine over the hemisphere."""
    nodes, weights = leggauss(order)
    # Heights about the mirror direction on which the lobe is spread evenly, t = cos^(n + 1).
    t = (nodes + 1) / 2
    cos_alpha = t ** (1 / (exponent + 1))
    azimuth = (np.arange(order) + 0.5) * 2 * math.pi / order
    sin_in = math.sqrt(1 - cos_in**2)
    cos_out = cos_in * cos_alpha[:, None] + sin_in * np.outer(np.sqrt(1 - cos_alpha**2), np.cos(azimuth))
    ratio = np.array([lobe(exponent, c) / lobe_density(exponent, c) for c in cos_alpha])
    return float(np.sum(weights / 2 * ratio * np.maximum(cos_out, 0).mean(axis=1)))


@pytest.mark.parametrize("exponent", [0.0, 1.0, 8.0, 100.0, 1e4])
def test_a_lobe_reflects_all_of_ks_along_the_normal(exponent):
    """(n + 2) / (2 pi) times the integral of cos^(n + 1) over the hemisphere, 2 pi / (n + 2), is 1."""
    assert directional_albedo(exponent, 1.0) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 8.0, 100.0])
@pytest.mark.parametrize("cos_in", [0.05, 0.3, 0.7])
def test_a_lobe_never_reflects_more_than_ks(exponent, cos_in):
    assert 0.0 < directional_albedo(exponent, cos_in) < 1.0


def test_the_lobe_at_known_angles():
    """n = 2 at 60 degrees: 4 / (2 pi) / 4; behind the mirror direction's horizon nothing."""
    assert lobe(2.0, 0.5) == pytest.approx(0.5 / math.pi, rel=EXACT)
    assert lobe(0.0, 0.3) == pytest.approx(1 / math.pi, rel=EXACT)
    assert lobe(8.0, 0.0) == lobe(8.0, -0.5) == lobe_density(8.0, -0.5) == 0.0


@given(exponent=exponents, one=directions, other=directions)
def test_the_lobe_is_reciprocal(exponent, one, other):
    """The angle between a direction and the other's mirror image is the same either way."""
    there = np.dot(mirrored(*one, 0.0, 0.0, 1.0), other)
    back = np.dot(mirrored(*other, 0.0, 0.0, 1.0), one)
    assert there == pytest.approx(back, abs=1e-15)
    # A power of up to 10 000 magnifies the last digit of the cosine as many times.
    assert lobe(exponent, there) == pytest.approx(lobe(exponent, back), rel=1e-10, abs=1e-300)


@given(exponent=exponents, cos_alpha=st.floats(1e-3, 1))
def test_lobe_and_density_differ_by_the_ratio_of_their_norms(exponent, cos_alpha):
    expected = lobe_density(exponent, cos_alpha) * (exponent + 2) / (exponent + 1)
    assert lobe(exponent, cos_alpha) == pytest.approx(expected, rel=EXACT)


def test_reflectances_in_the_channels_that_are_carried():
    """Luminance of (0.5, 0.2, 0.1) by Rec. 709: 0.2126 x 0.5 + 0.7152 x 0.2 + 0.0722 x 0.1 = 0.25656."""
    material = Material("red", np.array([0.5, 0.2, 0.1]), specular=np.array([0.1, 0.1, 0.1]), exponent=20.0)
    scene = lit(box(), materials=[material])
    colour = collect_reflectances(scene, channel_matrix(3))
    single = collect_reflectances(scene, channel_matrix(1))
    np.testing.assert_array_equal(colour.diffuse, [[0.5, 0.2, 0.1]])
    np.testing.assert_allclose(single.diffuse, [[0.25656]], rtol=EXACT)
    for reflectances in (colour, single):
        np.testing.assert_allclose(reflectances.diffuse_share, [0.25656], rtol=EXACT)
        np.testing.assert_allclose(reflectances.specular_share, [0.1], rtol=EXACT)
        assert np.array_equal(reflectances.exponent, [20.0])


@pytest.mark.parametrize(
    ("diffuse", "specular", "expected"), [(0.3, 0.1, 0.75), (0.3, 0.0, 1.0), (0.0, 0.2, 0.0), (0.0, 0.0, 1.0)]
)
def test_walks_take_the_lobes_by_what_they_reflect(diffuse, specular, expected):
    scene = lit(box(), materials=[grey("walls", diffuse, specular=specular)])
    reflectances = collect_reflectances(scene, channel_matrix(1))
    assert diffuse_probability(reflectances, 0) == pytest.approx(expected, rel=EXACT)
