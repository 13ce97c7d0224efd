"""Every warp against the density it states, by chi-square, and the numbers that feed them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss
from verdicts import follows

from lelight.tracing import sampling
from lelight.tracing.reflection import lobe_density

SAMPLES = 20_000
RINGS, SECTORS = 12, 8
EXACT = 1e-12


def drawn(warp, *parameters, seed=0):
    """Directions (SAMPLES, 3) from independent uniform numbers."""
    numbers = np.random.default_rng(seed).random((SAMPLES, 2))
    return np.array([warp(u, v, *parameters) for u, v in numbers])


def counted(directions, heights):
    """Directions in rings between heights (rings + 1,) of z, and in sectors of azimuth."""
    azimuth = np.arctan2(directions[:, 1], directions[:, 0])
    cells = (heights, np.linspace(-math.pi, math.pi, SECTORS + 1))
    inside = np.clip(directions[:, 2], heights[0], heights[-1])
    return np.histogram2d(inside, azimuth, bins=cells)[0]


def probabilities(density, heights):
    """Probability of each cell: a density of z alone, integrated over solid angle, d omega = dz d phi."""
    nodes, weights = leggauss(20)
    low, high = heights[:-1, None], heights[1:, None]
    z = 0.5 * (low + high) + 0.5 * (high - low) * nodes
    values = np.vectorize(density)(z)
    ring = (0.5 * (high - low) * weights * values).sum(axis=1)
    return np.tile((ring * 2 * math.pi / SECTORS)[:, None], (1, SECTORS))


def ring_heights(exponent):
    """Rings that a lobe fills alike; all but a millionth of it lies above the lowest."""
    return np.linspace(1e-6, 1, RINGS + 1) ** (1 / (exponent + 1))


def test_cosine_direction_has_density_cosine_over_pi():
    heights = np.linspace(0, 1, RINGS + 1)
    expected = probabilities(lambda z: z / math.pi, heights)
    assert follows(counted(drawn(sampling.cosine_direction), heights), expected)


def test_sphere_direction_has_density_one_over_four_pi():
    heights = np.linspace(-1, 1, RINGS + 1)
    expected = probabilities(lambda z: 0.25 / math.pi, heights)
    assert follows(counted(drawn(sampling.sphere_direction), heights), expected)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 32.0, 1e4])
def test_lobe_direction_has_the_density_of_the_lobe(exponent):
    heights = ring_heights(exponent)
    expected = probabilities(lambda z: lobe_density(exponent, z), heights)
    assert follows(counted(drawn(sampling.lobe_direction, exponent), heights), expected)


def test_a_lobe_of_another_exponent_is_told_apart():
    heights = ring_heights(32.0)
    expected = probabilities(lambda z: lobe_density(32.0, z), heights)
    assert not follows(counted(drawn(sampling.lobe_direction, 34.0), heights), expected)


def test_cosine_directions_stand_about_their_own_normals():
    rng = np.random.default_rng(3)
    normals = rng.normal(size=(SAMPLES, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    directions = sampling.cosine_directions(rng.random((SAMPLES, 2)), normals)
    cos_theta = np.einsum("kx,kx->k", directions, normals)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, rtol=EXACT)
    # The cumulative probability of cosine / pi below theta is sin²: 1 - cos² is uniform.
    cells = np.histogram(1.0 - cos_theta**2, bins=20, range=(0, 1))[0]
    assert follows(cells, np.full(20, 1 / 20))


unit_vectors = st.tuples(st.floats(-1, 1), st.floats(-math.pi, math.pi)).map(
    lambda place: (
        math.sqrt(1 - place[0] ** 2) * math.cos(place[1]),
        math.sqrt(1 - place[0] ** 2) * math.sin(place[1]),
        place[0],
    )
)


@given(axis=unit_vectors, one=unit_vectors, other=unit_vectors)
def test_to_axis_is_a_rotation_that_takes_z_to_the_axis(axis, one, other):
    np.testing.assert_allclose(sampling.to_axis(0.0, 0.0, 1.0, *axis), axis, atol=EXACT)
    turned = [np.array(sampling.to_axis(*vector, *axis)) for vector in (one, other)]
    assert turned[0] @ turned[1] == pytest.approx(np.dot(one, other), abs=EXACT)
    cross = sampling.to_axis(*np.cross(one, other), *axis)
    np.testing.assert_allclose(np.cross(*turned), cross, atol=EXACT)


@given(direction=unit_vectors, normal=unit_vectors)
def test_mirrored_keeps_the_normal_part_and_turns_the_rest_over(direction, normal):
    d, n = np.array(direction), np.array(normal)
    mirror = np.array(sampling.mirrored(*direction, *normal))
    assert mirror @ n == pytest.approx(d @ n, abs=EXACT)
    np.testing.assert_allclose(mirror - (mirror @ n) * n, -(d - (d @ n) * n), atol=EXACT)
    np.testing.assert_allclose(sampling.mirrored(*mirror, *normal), d, atol=EXACT)


@given(u=st.floats(0, 1, exclude_max=True), shift=st.floats(0, 1, exclude_max=True))
def test_rotated_stays_in_the_half_open_interval(u, shift):
    turned = sampling.rotated(u, shift)
    assert 0.0 <= turned < 1.0
    assert turned in {u + shift, u + shift - 1.0}


def test_uniform_fills_the_interval_evenly_along_both_arguments():
    words = np.arange(SAMPLES, dtype=np.uint64)
    by_counter = [sampling.uniform(np.uint64(9), word) for word in words]
    by_key = [sampling.uniform(word, np.uint64(5)) for word in words]
    pairs = np.histogram2d(by_counter, by_key, bins=16, range=((0, 1), (0, 1)))[0]
    assert follows(pairs, np.full((16, 16), 1 / 256))


def test_mix_is_the_published_generator():
    """SplitMix64 from state 1234567 begins 6457827717110365317, 3203168211198807973 (Rosetta Code's test values).

    Its k-th output is the finaliser of state + k x golden ratio, which `mix` applies to key and counter.
    """
    golden = 0x9E3779B97F4A7C15
    state = 1234567
    outputs = [int(sampling.mix(np.uint64((state + k * golden) % 2**64), np.uint64(0))) for k in range(2)]
    assert outputs == [6457827717110365317, 3203168211198807973]


def test_solid_angle_of_an_octant_and_of_a_cube_face():
    """Eight octants make the sphere, 4 pi; two triangles make a sixth of it, the face of a cube seen from within."""
    assert sampling.solid_angle((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)) == pytest.approx(
        4 * math.pi / 8, rel=EXACT
    )
    third = math.sqrt(1 / 3)
    face = [(third * x, third * y, third) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    halves = sampling.solid_angle(face[0], face[1], face[2]) + sampling.solid_angle(face[0], face[2], face[3])
    assert halves == pytest.approx(4 * math.pi / 6, rel=EXACT)
