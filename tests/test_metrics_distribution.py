"""The distribution of luminance over a view, and measures of contrast; figures at an eye from its moments."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_metrics_picture import OBSERVER, fisheye, scene, towards

from lelight.metrics.distribution import LABEL, log_gradient, luminance_distribution, rms_contrast
from lelight.metrics.eye import eye_figures
from lelight.results import ObserverValues


def test_the_distribution_adds_up_to_the_view():
    solid_angles, _ = fisheye()
    found = luminance_distribution(scene([(0, 20, 5, 10_000)], 100), solid_angles)
    assert found["label"] == LABEL
    assert sum(found["solid_angle"]) == pytest.approx(2 * math.pi, rel=1e-3)
    assert found["solid_angle_above"][0] == pytest.approx(sum(found["solid_angle"]))
    disc = 2 * math.pi * (1 - math.cos(math.radians(5)))
    above = dict(zip(np.round(np.log10(found["luminance"]), 1), found["solid_angle_above"], strict=True))
    assert above[3.0] == pytest.approx(disc, rel=3e-3)


def test_contrast_of_two_halves():
    # Half at 50, half at 150 cd/m²: standard deviation 50 over a mean of 100.
    assert rms_contrast(np.array([50.0, 150.0]), np.ones(2)) == pytest.approx(0.5)
    assert rms_contrast(np.zeros(3), np.ones(3)) == 0.0


@pytest.mark.parametrize("axis", [(0, 0), (40, 0), (30, 50)])
def test_the_gradient_of_an_exponential_is_its_exponent_wherever_it_points(axis):
    # ln L = 2 θ' about any axis has |grad ln L| = 2 everywhere, but for the axis itself.
    solid_angles, directions = fisheye()
    angle = np.arccos(np.clip(directions @ towards(*axis), -1, 1))
    gradient, weights = log_gradient(np.exp(2 * angle), solid_angles)
    assert np.average(gradient, weights=weights) == pytest.approx(2.0, rel=5e-3)
    assert np.percentile(gradient, 90) == pytest.approx(2.0, rel=0.01)


def test_a_uniform_view_has_no_gradient():
    solid_angles, _ = fisheye()
    found = luminance_distribution(scene([], 100), solid_angles)
    assert (found["log_gradient_mean"], found["rms_contrast"]) == (0.0, pytest.approx(0.0, abs=1e-12))


def test_figures_at_an_eye_in_a_beam():
    # E_perp = 1 from 30 degrees off the zenith, from ahead (+y).
    angle = math.radians(30)
    moments = np.array(
        [math.sin(angle), 0.25, 0.0, math.sin(angle), math.cos(angle), math.sin(angle) / math.pi]
    )
    turned = np.tile(np.arange(24.0), (4, 1))
    at_eye = ObserverValues(OBSERVER, 0.5, 1.0, np.ones(4), np.tile(moments, (4, 1)), turned, turned)
    figures = eye_figures(at_eye)
    expected = {
        "scalar_illuminance": 0.25,
        "cylindrical_illuminance": 0.15915494309189532,
        "hemispherical_illuminance": 0.4665063509461097,
        "semicylindrical_illuminance": 0.31830988618379064,
        "light_vector": 1.0,
        "vector_over_scalar": 4.0,
        "vector_altitude": 60.0,
        "vertical_illuminance_left": 6.0,
        "vertical_illuminance_back": 12.0,
        "vertical_illuminance_right": 18.0,
    }
    assert {name: figures[name].value for name in expected} == pytest.approx(expected, rel=1e-9)
    assert figures["symmetric_scalar_illuminance"].value == pytest.approx(0.0, abs=1e-12)


def test_an_eye_without_moments_has_no_spatial_figures():
    assert eye_figures(ObserverValues(OBSERVER, 0.5, 1.0, np.ones(4))) == {}
