"""Glare from pictures: synthetic discs against closed forms and against figures of evalglare 3.06."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

from lelight.metrics.brightspots import label_spots
from lelight.metrics.glare import observer_figures
from lelight.metrics.picture import mean_luminance, picture_glare
from lelight.metrics.position import position_index
from lelight.results import ObserverValues
from lelight.scene import Observer

OBSERVER = Observer("eye", np.zeros(3), np.array([0.0, 1.0, 0.0]))
SIZE = 1000


@functools.cache
def fisheye(size=SIZE):
    """Exact solid angles and directions of an equi-angular hemisphere looking along +y."""
    steps = (2 * np.arange(size) + 1) / size - 1
    x, z = np.meshgrid(steps, -steps)
    radius = np.hypot(x, z)
    theta = radius * math.pi / 2
    solid_angles = (math.pi / 2) ** 2 * np.sinc(theta / math.pi) * (2 / size) ** 2 * (radius <= 1)
    scale = np.divide(np.sin(theta), radius, out=np.zeros_like(radius), where=radius > 0)
    return solid_angles, np.stack([x * scale, np.cos(theta), z * scale], axis=-1)


def towards(azimuth, elevation):
    az, el = np.radians([azimuth, elevation])
    return np.array([np.cos(el) * np.sin(az), np.cos(el) * np.cos(az), np.sin(el)])


def scene(discs, field):
    """Discs (azimuth, elevation, half angle in degrees, luminance) on a uniform field."""
    solid_angles, directions = fisheye()
    luminance = np.full(solid_angles.shape, float(field))
    for azimuth, elevation, half_angle, bright in discs:
        luminance[directions @ towards(azimuth, elevation) >= math.cos(math.radians(half_angle))] = bright
    return luminance


def rate(discs, field, **more):
    return picture_glare(scene(discs, field), *fisheye(), OBSERVER, **more)


def closed_form(discs, field):
    """UGR, DGP and Ev of discs that do not overlap, written down from the definitions."""
    total = illuminance = covered = 0.0
    for azimuth, elevation, half_angle, bright in discs:
        axis, half = towards(azimuth, elevation), math.radians(half_angle)
        disc = math.pi * math.sin(half) ** 2 * axis[1]  # integral of cos over a disc
        index = float(position_index(axis[[1, 0, 2]]))
        total += bright**2 * 2 * math.pi * (1 - math.cos(half)) / index**2
        illuminance += bright * disc
        covered += disc
    background = field * (math.pi - covered) / math.pi
    ev = illuminance + background * math.pi
    rating = 8 * math.log10(0.25 * total / background)
    return rating, 5.87e-5 * ev + 0.092 * math.log10(1 + total / ev**1.87) + 0.159, ev


ONE = [(0, 20, 5, 10001.6)]
AXIS = [(0, 0, 3, 10001.6)]
BELOW = [(0, -20, 5, 10001.6)]
THREE = [(-20, 25, 3, 7987.9), (0, 35, 3, 20003.2), (40, 15, 3, 3993.9)]
WEAK = [(0, 20, 3, 5000.8)]

# Discs, field, UGR of evalglare and in closed form, DGP likewise, Ev of evalglare and in closed form.
CASES = [
    (ONE, 100.338, 24.953, 24.920, 0.25573, 0.25543, 537.24, 537.25),
    (AXIS, 100.338, 26.654, 26.663, 0.28399, 0.28408, 400.36, 400.42),
    (BELOW, 100.338, 28.441, 28.449, 0.29055, 0.29064, 537.24, 537.25),
    (THREE, 59.958, 24.609, 24.566, 0.24465, 0.24427, 412.14, 412.09),
    (WEAK, 39.943, 19.778, 19.740, 0.22744, 0.22712, 165.66, 165.60),
]


@pytest.mark.parametrize(("discs", "field", "ugr_eg", "ugr", "dgp_eg", "dgp", "ev_eg", "ev"), CASES)
def test_discs(discs, field, ugr_eg, ugr, dgp_eg, dgp, ev_eg, ev):
    assert closed_form(discs, field) == (
        pytest.approx(ugr, abs=6e-4),
        pytest.approx(dgp, abs=6e-6),
        pytest.approx(ev, abs=6e-3),
    )
    glare = rate(discs, field)
    assert len(glare.sources) == len(discs)
    assert glare.ugr == pytest.approx(ugr, abs=0.005)
    assert glare.ugr == pytest.approx(ugr_eg, abs=0.06)
    assert glare.dgp == pytest.approx(dgp_eg, abs=7e-4)
    assert glare.vertical_illuminance == pytest.approx(ev_eg, rel=1e-3)
    assert glare.covered == pytest.approx(1.0, abs=1e-4)


def test_a_disc_has_its_luminance_place_and_size():
    (source,) = rate(ONE, 100.338).sources
    assert source.luminance == pytest.approx(10001.6, rel=1e-9)
    assert source.solid_angle == pytest.approx(2 * math.pi * (1 - math.cos(math.radians(5))), rel=2e-3)
    np.testing.assert_allclose(source.direction, towards(0, 20), atol=3e-4)
    # 1 % of the index against evalglare, which rounds the centroid down to a pixel.
    assert source.position_index == pytest.approx(2.1360, rel=0.01)


def test_what_looks_the_same_rates_the_same_in_every_direction():
    # Turn the eye and the picture's directions together, by 90 degrees about z: (x, y, z) -> (-y, x, z).
    solid_angles, directions = fisheye()
    turned = directions[..., [1, 0, 2]] * [-1, 1, 1]
    eye = Observer("eye", np.zeros(3), np.array([-1.0, 0.0, 0.0]))
    luminance = scene(THREE, 59.958)
    there = picture_glare(luminance, solid_angles, turned, eye)
    assert there.ugr == pytest.approx(rate(THREE, 59.958).ugr, rel=1e-12)


def test_peaks_are_sources_of_their_own():
    # Disc of 5 degrees with an inner disc of 1 degree: evalglare splits them, UGR 30.369, DGP 0.3064. One
    # source of their mean luminance would be 26.995.
    glare = rate([*ONE, (0, 20, 1, 99882)], 100.338)
    assert len(glare.sources) == 2
    assert glare.ugr == pytest.approx(30.369, abs=0.06)
    assert glare.dgp == pytest.approx(0.3064, abs=7e-4)


def test_the_threshold_decides_what_is_a_source():
    # 1500 cd/m² on 100: evalglare finds nothing above 2000 cd/m², and 11.791 above 500 cd/m².
    discs = [(0, 20, 5, 1500)]
    below = rate(discs, 100)
    assert (below.ugr, below.sources) == (None, ())
    assert below.dgp == pytest.approx(5.87e-5 * below.vertical_illuminance + 0.159, rel=1e-12)
    above = rate(discs, 100, threshold=500.0)
    assert above.ugr == pytest.approx(closed_form(discs, 100)[0], abs=0.005)
    assert above.ugr == pytest.approx(11.791, abs=0.06)


def test_a_threshold_can_follow_the_mean():
    solid_angles, _ = fisheye()
    luminance = scene([(0, 20, 5, 1500)], 100)
    # Mean over the hemisphere: 100 + 1400 (1 - cos 5 deg).
    mean = mean_luminance(luminance, solid_angles)
    assert mean == pytest.approx(100 + 1400 * (1 - math.cos(math.radians(5))), rel=1e-4)
    assert len(rate([(0, 20, 5, 1500)], 100, threshold=5 * mean).sources) == 1


@pytest.mark.parametrize(("gap", "spots"), [(5.5, 1), (5.7, 2)])
@pytest.mark.parametrize("upright", [False, True])
def test_a_gap_of_a_tenth_of_a_radian_parts_sources(gap, spots, upright):
    # evalglare merges discs 0.0960 rad (5.5 deg) apart and not those 0.0995 rad (5.7 deg) apart.
    away = 2 + gap / 2
    places = [(0, away), (0, -away)] if upright else [(away, 0), (-away, 0)]
    discs = [(azimuth, elevation, 2, 5000) for azimuth, elevation in places]
    assert len(rate(discs, 50).sources) == spots


def test_merging_goes_from_spot_to_spot():
    _, directions = fisheye()
    bright = np.zeros((SIZE, SIZE), dtype=bool)
    bright[500, [300, 325, 350, 450]] = True  # 25 pixels are 4.5 deg, 100 are 18 deg
    labels, count = label_spots(bright, directions, gap=0.1)
    assert count == 2
    assert labels[500, [300, 325, 350]].tolist() == [labels[500, 300]] * 3
    assert labels[500, 450] != labels[500, 300]
    assert np.flatnonzero(labels).size == 4


def test_black_surroundings_leave_ugr_undefined():
    glare = rate(ONE, 0.0)
    assert glare.background == 0.0
    assert glare.ugr is None
    assert 0 < glare.dgp <= 1
    night = rate([], 0.0)
    assert (night.ugr, night.dgp, night.vertical_illuminance) == (None, 0.159, 0.0)


def test_dgp_ends_at_one():
    assert rate([(0, 20, 10, 1e7)], 1e4).dgp == 1.0


def test_what_lies_outside_the_view_is_not_looked_at():
    solid_angles, directions = fisheye()
    luminance = np.where(solid_angles > 0, scene(ONE, 100.338), math.nan)
    glare = picture_glare(luminance, solid_angles, directions, OBSERVER)
    assert glare.ugr == rate(ONE, 100.338).ugr


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -1.0])
def test_impossible_luminance_is_refused(wrong):
    luminance = scene(ONE, 100.338)
    luminance[500, 500] = wrong
    with pytest.raises(ValueError, match="luminance must be finite"):
        picture_glare(luminance, *fisheye(), OBSERVER)


@pytest.mark.parametrize("wrong", [math.nan, 0.0, -5.0])
def test_impossible_threshold_is_refused(wrong):
    with pytest.raises(ValueError, match="threshold"):
        rate(ONE, 100.338, threshold=wrong)


AT_EYE = ObserverValues(OBSERVER, 224.0, 313.0, np.array([312.0, 314.0]))


def test_observer_figures_with_a_picture():
    figures = observer_figures(AT_EYE, [], picture=rate(ONE, 100.338))
    assert list(figures) == ["ugr", "background_luminance", "vertical_illuminance", "ugr_picture", "dgp"]
    assert figures["ugr_picture"].value == pytest.approx(24.920, abs=0.005)
    assert "1 source above 2000 cd/m²" in figures["ugr_picture"].method
    assert figures["dgp"].note == ""


def test_dgp_outside_its_range_says_so():
    assert "outside the range" in observer_figures(AT_EYE, [], picture=rate(WEAK, 39.943))["dgp"].note


def test_a_picture_without_sources_has_no_rating():
    figure = observer_figures(AT_EYE, [], picture=rate([], 100))["ugr_picture"]
    assert figure.value is None
    assert "no glare source" in figure.note


def test_half_a_picture_is_not_rated():
    solid_angles, directions = fisheye()
    half = slice(None, SIZE // 2)
    glare = picture_glare(scene(ONE, 100)[half], solid_angles[half], directions[half], OBSERVER)
    figures = observer_figures(AT_EYE, [], picture=glare)
    assert (figures["ugr_picture"].value, figures["dgp"].value) == (None, None)
    assert "50 % of the view hemisphere" in figures["dgp"].note
