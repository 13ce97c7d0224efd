"""Closed forms of glare, veils, skies and spatial illuminance against computed reference numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lelight.metrics.cie112 import environment_veil, glare_rating, looks_down, source_veil
from lelight.metrics.cie146 import general, stiles_holladay, visible_contrast
from lelight.metrics.cie147 import great_room_glare_rating, small_source_term
from lelight.metrics.cie232 import blurred, effective, uniformity_factor
from lelight.metrics.cie_s011 import relative_luminance
from lelight.metrics.en13201 import age_factor, threshold_increment, threshold_increment_of_age
from lelight.metrics.spatial import (
    altitude,
    cylindrical_illuminance,
    hemispherical,
    light_vector,
    plane_illuminance,
    scalar_illuminance,
    semicylindrical,
    symmetric_scalar,
    zonal_kernel,
)

EXACT = 1e-9


@pytest.mark.parametrize(
    ("coverage", "direct", "indirect", "ggr"),
    [
        (0.2, 200, 200, 19.865394419334297),
        (0.5, 300, 200, 21.507106274808788),
        (1.0, 500, 250, 22.55462993058684),
        (0.15, 100, 150, 18.944413003469553),
    ],
)
def test_great_room_glare_rating(coverage, direct, indirect, ggr):
    found = great_room_glare_rating(19.0, ceiling_coverage=coverage, direct=direct, indirect=indirect)
    assert found == pytest.approx(ggr, rel=EXACT)


@pytest.mark.parametrize(
    ("coverage", "indirect"), [(0.1, 100.0), (1.2, 100.0), (math.nan, 100.0), (0.5, 0.0)]
)
def test_great_room_glare_rating_refuses_what_it_is_not_for(coverage, indirect):
    with pytest.raises(ValueError, match="found"):
        great_room_glare_rating(19.0, ceiling_coverage=coverage, direct=100.0, indirect=indirect)


def test_a_small_source():
    # I = 500 cd at 3 m, p = 4, Lb = 20 cd/m².
    term = small_source_term(500.0, 3.0)
    assert term == pytest.approx(5555555.555555556, rel=EXACT)
    assert 8 * math.log10(0.25 / 20 * term / 16) == pytest.approx(29.100140201990605, rel=EXACT)


def test_uniform_luminaires_have_a_factor_of_one():
    omega = np.full((20, 20), 1e-5)
    assert uniformity_factor(np.full((20, 20), 3000.0), omega) == pytest.approx(1.0, rel=EXACT)


def test_half_a_luminous_area_counts_twice():
    # L ω is the same, ω_eff half of ω: k² = ω / ω_eff = 2.
    luminance = np.zeros((20, 20))
    luminance[:, :10] = 6000.0
    omega = np.full((20, 20), 1e-5)
    assert effective(luminance, omega) == pytest.approx((6000.0, 2e-3), rel=EXACT)
    assert uniformity_factor(luminance, omega) == pytest.approx(2.0, rel=EXACT)
    assert uniformity_factor(np.full((20, 20), 400.0), omega) == 0.0


def test_the_blur_has_its_width_and_loses_nothing():
    image = np.zeros((201, 201))
    image[100, 100] = 1.0
    spread = blurred(image, pixel=0.001)
    assert spread.sum() == pytest.approx(1.0, abs=1e-6)
    # Half height at half the width: 6 mm off the middle.
    assert spread[100, 106] / spread[100, 100] == pytest.approx(0.5, rel=1e-3)


def test_glare_rating_outdoors():
    veil = source_veil(np.array([15.0, 8.0, 5.0, 99.0, 99.0]), np.array([10.0, 20.0, 35.0, 1.0, 61.0]))
    assert veil == pytest.approx(1.740816326530612, rel=EXACT)
    around = environment_veil(300.0, 0.25)
    assert around == pytest.approx(0.8355634512324507, rel=EXACT)
    assert glare_rating(veil, around) == pytest.approx(34.46331503030284, rel=EXACT)
    assert math.isnan(glare_rating(0.0, around)) and math.isnan(glare_rating(veil, 0.0))
    assert looks_down(np.array([1.0, 0.0, -0.02])) and not looks_down(np.array([1.0, 0.0, 0.0]))


@pytest.mark.parametrize(
    ("veil", "road", "increment"),
    [
        (0.1, 0.5, 11.317157322849615),
        (0.15, 1.0, 9.75),
        (0.3, 2.0, 11.199808961221091),
        (0.5, 8.0, 5.351174621751804),
    ],
)
def test_threshold_increment(veil, road, increment):
    assert threshold_increment(veil, road) == pytest.approx(increment, rel=EXACT)


@pytest.mark.parametrize(
    ("age", "k"),
    [(23, 650.2277762642806), (40, 725.4161764593399), (60, 1068.3568933254085), (70, 1432.7314049956065)],
)
def test_threshold_increment_grows_with_age(age, k):
    assert age_factor(age) == pytest.approx(k, rel=EXACT)
    found = threshold_increment_of_age(np.array([2.0, 9.0]), np.array([10.0, 61.0]), 1.0, age=age)
    assert found == pytest.approx(k * 0.02, rel=EXACT)


def test_a_dark_road_has_no_threshold_increment():
    assert math.isnan(threshold_increment(0.1, 0.05))


@pytest.mark.parametrize(
    ("theta", "age", "pigment", "veil"),
    [
        (0.5, 25, 0.5, 100.61581),
        (1.5, 25, 0.5, 5.27751074074074),
        (10, 25, 0.5, 0.067658),
        (10, 70, 0.5, 0.15279356480000003),
        (30, 25, 1.0, 0.011986814814814815),
        (60, 25, 1.0, 0.005680074074074075),
    ],
)
def test_general_disability_glare(theta, age, pigment, veil):
    assert general(theta, age=age, pigment=pigment) == pytest.approx(veil, rel=EXACT)


@pytest.mark.parametrize(
    ("theta", "age", "veil"), [(2, 23, 2.529137963348605), (10, 23, 0.1011655185339442), (10, 70, 0.2)]
)
def test_stiles_holladay(theta, age, veil):
    assert stiles_holladay(theta, age=age) == pytest.approx(veil, rel=EXACT)


@pytest.mark.parametrize("theta", [0.05, 101.0, math.nan])
def test_veils_are_refused_outside_their_angles(theta):
    with pytest.raises(ValueError, match="theta"):
        general(theta, age=25, pigment=0.5)
    with pytest.raises(ValueError, match="theta"):
        stiles_holladay(theta, age=25)


def test_a_veil_as_bright_as_the_background_halves_contrast():
    assert visible_contrast(0.8, background=20.0, veil=20.0) == pytest.approx(0.4, rel=EXACT)


# Type, E_hz / L_z, vertical illuminance to south, north and east over E_hz, L / L_z at (Z, azimuth from the
# sun) = (60, 0), (60, 90), (60, 180), (85, 0), (85, 180); sun 60 degrees high.
SKIES = [
    (
        1,
        2.449540874,
        0.379182305,
        0.379182305,
        0.379182305,
        0.665157701,
        0.665157701,
        0.665157701,
        0.335293270,
        0.335293270,
    ),
    (
        2,
        2.086019065,
        0.419705386,
        0.265461543,
        0.323726227,
        0.665157701,
        0.438525755,
        0.362520150,
        0.243718270,
        0.170997646,
    ),
    (
        3,
        2.769987826,
        0.446645733,
        0.446645733,
        0.446645733,
        0.817852749,
        0.817852749,
        0.817852749,
        0.669302705,
        0.669302705,
    ),
    (
        4,
        2.315414878,
        0.482277198,
        0.310985037,
        0.375835226,
        0.817852749,
        0.539194681,
        0.445741063,
        0.486503344,
        0.341340544,
    ),
    (
        5,
        3.141592654,
        0.500000000,
        0.500000000,
        0.500000000,
        1.000000000,
        1.000000000,
        1.000000000,
        1.000000000,
        1.000000000,
    ),
    (
        6,
        2.584156065,
        0.534356184,
        0.348599674,
        0.419043385,
        1.000000000,
        0.659280882,
        0.545013836,
        0.726880887,
        0.509994269,
    ),
    (
        7,
        2.421211865,
        0.546774351,
        0.284059307,
        0.371284237,
        1.000000000,
        0.508507030,
        0.403723978,
        0.586954320,
        0.398944751,
    ),
    (
        8,
        2.328356017,
        0.557109042,
        0.227367785,
        0.329731856,
        1.000000000,
        0.402475495,
        0.300619620,
        0.486906459,
        0.305069670,
    ),
    (
        9,
        3.459318697,
        0.671089944,
        0.448425998,
        0.533114885,
        1.576949810,
        1.039652862,
        0.859459465,
        1.715068632,
        1.203326693,
    ),
    (
        10,
        3.170246062,
        0.674661990,
        0.372307938,
        0.472689139,
        1.576949810,
        0.801890065,
        0.636652451,
        1.384913209,
        0.941306396,
    ),
    (
        11,
        2.989035065,
        0.677205970,
        0.301558692,
        0.418231173,
        1.576949810,
        0.634683656,
        0.474062053,
        1.148851220,
        0.719809023,
    ),
    (
        12,
        3.190546800,
        0.741941988,
        0.346107287,
        0.468693415,
        1.726149037,
        0.694732688,
        0.518914268,
        1.732772752,
        1.085663174,
    ),
    (
        13,
        3.025821689,
        0.741542496,
        0.276247984,
        0.420521110,
        1.726149037,
        0.573130275,
        0.391653200,
        1.496465293,
        0.766010400,
    ),
    (
        14,
        3.216925139,
        0.839547816,
        0.336030758,
        0.492401858,
        1.860707976,
        0.617807647,
        0.422183843,
        2.478863173,
        1.268880059,
    ),
    (
        15,
        3.015825545,
        0.842281710,
        0.246004687,
        0.438035686,
        1.860707976,
        0.517267699,
        0.292691798,
        2.213332186,
        0.759084375,
    ),
    (
        16,
        2.443460953,
        0.396177078,
        0.396177078,
        0.396177078,
        0.666666667,
        0.666666667,
        0.666666667,
        0.391437162,
        0.391437162,
    ),
]


@pytest.mark.parametrize("row", SKIES, ids=[f"type {row[0]}" for row in SKIES])
def test_general_sky(row):
    sun = math.radians(30.0)
    places = np.radians([[60, 0], [60, 90], [60, 180], [85, 0], [85, 180]])
    found = relative_luminance(row[0], places[:, 0], places[:, 1], sun_zenith=sun)
    np.testing.assert_allclose(found, row[5:], rtol=1e-7)
    zenith, azimuth, measure = hemisphere()
    luminance = relative_luminance(row[0], zenith, azimuth, sun_zenith=sun) * measure
    horizontal = float(np.sum(luminance * np.cos(zenith)))
    assert horizontal == pytest.approx(row[1], rel=2e-5)
    for bearing, expected in ((0.0, row[2]), (math.pi, row[3]), (math.pi / 2, row[4])):
        facing = np.maximum(np.sin(zenith) * np.cos(azimuth - bearing), 0.0)
        assert float(np.sum(luminance * facing)) / horizontal == pytest.approx(expected, rel=2e-5)


def hemisphere(count=200):
    """Gauss points of the upper hemisphere: zenith angle, azimuth, solid angle."""
    x, w = np.polynomial.legendre.leggauss(count)
    z = (x + 1) * math.pi / 4
    azimuth = (np.arange(4 * count) + 0.5) * 2 * math.pi / (4 * count)
    zenith, around = np.meshgrid(z, azimuth, indexing="ij")
    return zenith, around, (w * math.pi / 4 * np.sin(z))[:, None] * (2 * math.pi / (4 * count))


def test_an_unknown_sky_is_refused():
    with pytest.raises(ValueError, match="sky"):
        relative_luminance(17, np.zeros(1), np.zeros(1), sun_zenith=0.5)


KERNELS = {
    "plane": [0.88622693, 1.02332671, 0.49541591, 0, -0.11077837, 0, 0.04992713, 0, -0.02854693],
    # Numbers of degree 6 and 8 as the polynomials' own integrals have them, see below.
    "cylindrical": [0.8862269255, 0, -0.2477079515, 0, -0.0415418871, 0, -0.0156022296, 0, -0.0078058016],
    "scalar": [0.88622693, 0, 0, 0, 0, 0, 0, 0, 0],
    "hemispherical": [0.88622693, 0.51166335, 0, 0, 0, 0, 0, 0, 0],
    "vector": [0, 2.04665342, 0, 0, 0, 0, 0, 0, 0],
}


@pytest.mark.parametrize("name", KERNELS)
def test_kernels_of_spherical_harmonics(name):
    np.testing.assert_allclose(zonal_kernel(name, 8), KERNELS[name], rtol=0, atol=5.1e-9)


def test_the_cylindrical_kernel_is_that_of_its_polynomials():
    # ∫ t^2k sqrt(1 - t²) dt = π/2 (2k)! / (4^k k! (k + 1)!), term by term of P_8.
    powers = np.polynomial.legendre.leg2poly([0] * 8 + [1])
    moments = [
        math.factorial(n) / (4 ** (n // 2) * math.factorial(n // 2) * math.factorial(n // 2 + 1))
        if n % 2 == 0
        else 0
        for n in range(9)
    ]
    expected = math.sqrt(17 / (4 * math.pi)) * 2 * float(powers @ np.array(moments)) * math.pi / 2
    assert zonal_kernel("cylindrical", 8)[8] == pytest.approx(expected, rel=EXACT)


def test_unknown_kernels_are_refused():
    with pytest.raises(ValueError, match="allowed are plane"):
        zonal_kernel("tube", 3)


def sphere(count=64):
    """Directions and solid angles that integrate the sphere; its halves and quarters have nodes of their own."""
    x, w = np.polynomial.legendre.leggauss(count)
    theta = np.concatenate([(x + 1) * math.pi / 4, (x + 3) * math.pi / 4])
    phi = (np.arange(8 * count) + 0.5) * 2 * math.pi / (8 * count)
    zenith, azimuth = (each.ravel() for each in np.meshgrid(theta, phi, indexing="ij"))
    solid = np.repeat(np.tile(w, 2) * math.pi / 4 * np.sin(theta), len(phi)) * 2 * math.pi / len(phi)
    sine = np.sin(zenith)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(zenith)], axis=1), solid


def test_a_uniform_field_gives_pi_everywhere():
    directions, solid = sphere()
    luminance = np.ones(len(solid))
    vector = light_vector(luminance, directions, solid)
    scalar, tube = scalar_illuminance(luminance, solid), cylindrical_illuminance(luminance, directions, solid)
    level = plane_illuminance(luminance, directions, solid, normal=np.array([0.0, 0.0, 1.0]))
    half = float(semicylindrical(np.array(tube), vector, np.array([1.0, 0, 0])))
    dome = float(hemispherical(np.array(scalar), vector))
    assert [level, scalar, tube, half, dome] == pytest.approx([math.pi] * 5, rel=1e-7)
    np.testing.assert_allclose(vector, 0.0, atol=1e-9)


def test_a_uniform_upper_hemisphere():
    directions, solid = sphere()
    luminance = (directions[:, 2] > 0).astype(float)
    vector = light_vector(luminance, directions, solid)
    scalar, tube = scalar_illuminance(luminance, solid), cylindrical_illuminance(luminance, directions, solid)
    normals = {"up": (0, 0, 1.0), "down": (0, 0, -1.0), "side": (1.0, 0, 0)}
    light = {
        name: plane_illuminance(luminance, directions, solid, normal=np.array(normal))
        for name, normal in normals.items()
    }
    assert light["up"] == pytest.approx(math.pi, rel=EXACT)
    assert light["down"] == 0.0
    # A plane's kink across the azimuth nodes costs a little.
    assert light["side"] == pytest.approx(math.pi / 2, rel=2e-5)
    assert [scalar, tube] == pytest.approx([math.pi / 2] * 2, rel=EXACT)
    assert float(hemispherical(np.array(scalar), vector)) == pytest.approx(3 * math.pi / 4, rel=EXACT)
    assert np.linalg.norm(vector) / scalar == pytest.approx(2.0, rel=EXACT)
    assert tube / light["up"] == pytest.approx(0.5, rel=EXACT)
    assert altitude(vector) == pytest.approx(90.0, abs=1e-6)


# Zenith angle: E_h, E_cyl, E_hemispherical, E_semicyl facing and at 90 degrees, for a beam of E_perp = 1.
BEAMS = {
    0: (1.0, 0.0, 0.5, 0.0, 0.0),
    30: (
        0.8660254037844387,
        0.15915494309189532,
        0.4665063509461097,
        0.31830988618379064,
        0.15915494309189532,
    ),
    45: (
        0.7071067811865476,
        0.22507907903927651,
        0.42677669529663687,
        0.45015815807855303,
        0.22507907903927651,
    ),
    60: (0.5, 0.27566444771089604, 0.375, 0.5513288954217921, 0.27566444771089604),
    75: (0.25881904510252074, 0.3074637398280573, 0.3147047612756302, 0.6149274796561146, 0.3074637398280573),
}


@pytest.mark.parametrize("zenith", BEAMS)
def test_a_beam(zenith):
    angle = math.radians(zenith)
    direction, one = np.array([[math.sin(angle), 0.0, math.cos(angle)]]), np.ones(1)
    vector = light_vector(one, direction, one)
    tube, scalar = cylindrical_illuminance(one, direction, one), scalar_illuminance(one, one)
    found = (
        plane_illuminance(one, direction, one, normal=np.array([0, 0, 1.0])),
        tube,
        float(hemispherical(np.array(scalar), vector)),
        float(semicylindrical(np.array(tube), vector, np.array([1.0, 0, 0]))),
        float(semicylindrical(np.array(tube), vector, np.array([0, 1.0, 0]))),
    )
    np.testing.assert_allclose(found, BEAMS[zenith], rtol=EXACT, atol=1e-15)
    assert scalar == 0.25
    assert np.linalg.norm(vector) / scalar == pytest.approx(4.0, rel=EXACT)
    assert float(symmetric_scalar(np.array(scalar), vector)) == pytest.approx(0.0, abs=1e-15)
    assert altitude(vector[0] * np.zeros(3) + vector) == pytest.approx(90.0 - zenith, abs=1e-9)


@given(st.integers(0, 2**32 - 1))
def test_opposite_faces_differ_by_the_vector(seed):
    # E(n) - E(-n) = n · E for any field: the light vector's defining property.
    generator = np.random.default_rng(seed)
    directions = generator.normal(size=(30, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    luminance, solid = generator.uniform(0, 100, size=(2, 30))
    normal = directions[0]
    there = plane_illuminance(luminance, directions, solid, normal=normal)
    back = plane_illuminance(luminance, directions, solid, normal=-normal)
    vector = light_vector(luminance, directions, solid)
    assert there - back == pytest.approx(float(vector @ normal), rel=1e-9, abs=1e-9)
