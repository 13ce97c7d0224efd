"""Cameras: handedness, solid angles, Radiance's view options."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from radianceprograms import program

from lelight.camera import Fisheye, Perspective, as_picture, stratified_offsets, view_axes
from lelight.panorama import Cylindrical

EYE = np.array([1.0, 2, 1.2])
EAST = np.array([1.0, 0, 0])
UP = np.array([0.0, 0, 1])

unit_number = st.floats(-1, 1).filter(lambda number: abs(number) > 1e-3)
vectors = st.tuples(unit_number, unit_number, unit_number).map(np.array)


@pytest.mark.parametrize(
    "camera",
    [
        Fisheye(EYE, EAST),
        Fisheye(EYE, EAST, mapping="equi-solid-angle"),
        Perspective(EYE, EAST, horizontal_angle=1.0),
        Cylindrical(EYE, EAST, horizontal_angle=1.0),
    ],
)
def test_rows_run_down_and_columns_to_the_right(camera):
    """Looking east (+x) with z up, south (-y) is on the right."""
    mask = camera.mask(9, 7)
    origins, directions = camera.rays(9, 7)
    south, upward = as_picture(-directions[:, 1], mask), as_picture(directions[:, 2], mask)
    assert np.all(np.diff(south[3]) > 0) and np.all(np.diff(upward[:, 4]) < 0)
    np.testing.assert_allclose(directions[mask[mask].size // 2], EAST, atol=1e-15)
    np.testing.assert_array_equal(origins, np.tile(EYE, (mask.sum(), 1)))
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, atol=1e-15)


def test_the_fisheye_angle_grows_with_the_radius():
    # Left borders of 10 columns lie at -1, -0.8 ... 0.8 of the radius, that is at -90°, -72° ... 72°.
    _, directions = Fisheye(EYE, EAST).rays(10, 11, offset=(0.0, 0.5))
    on_axis_row = directions[np.abs(directions[:, 2]) < 1e-12]
    angles = np.degrees(np.arctan2(-on_axis_row[:, 1], on_axis_row[:, 0]))
    np.testing.assert_allclose(angles, 90 * (np.arange(10) / 5 - 1), atol=1e-12)


@pytest.mark.parametrize("mapping", ["equi-angular", "equi-solid-angle"])
def test_no_fisheye_sample_looks_behind(mapping):
    camera = Fisheye(EYE, EAST, mapping=mapping)
    for offset in stratified_offsets(16):
        _, directions = camera.rays(20, 20, offset=tuple(offset))
        assert len(directions) == camera.mask(20, 20).sum()
        assert directions[:, 0].min() > -1e-12


def test_fisheye_solid_angles_fill_the_hemisphere_and_weigh_its_cosine():
    camera = Fisheye(EYE, EAST)
    omega = camera.solid_angles(1000, 1000)
    _, directions = camera.rays(1000, 1000)
    # The integral of 1 is 2 pi and of cos(theta) pi; pixels cut by the rim are whole or not at all.
    assert omega.sum() == pytest.approx(2 * np.pi, rel=1e-4)
    assert omega[camera.mask(1000, 1000)] @ directions[:, 0] == pytest.approx(np.pi, rel=1e-6)
    assert omega[0, 0] == 0


def test_the_fisheye_of_equal_solid_angles_has_just_these():
    camera = Fisheye(EYE, EAST, mapping="equi-solid-angle")
    omega = camera.solid_angles(1000, 1000)
    inside = camera.mask(1000, 1000)
    np.testing.assert_array_equal(omega[inside], omega[500, 500])
    assert omega.sum() == pytest.approx(2 * np.pi, rel=1e-4)
    _, directions = camera.rays(1000, 1000)
    assert omega[inside] @ directions[:, 0] == pytest.approx(np.pi, rel=1e-4)
    # At the rim of the axis' row 1 - cos(angle) = r²: half the radius is 41.41°.
    _, row = camera.rays(4, 1, offset=(0.0, 0.5))
    assert np.degrees(np.arccos(row[:, 0])) == pytest.approx([90, 41.4096, 0, 41.4096], abs=1e-4)


def test_a_panorama_runs_evenly_around_and_fills_its_zone():
    camera = Cylindrical(EYE, EAST)
    _, directions = camera.rays(8, 3)
    azimuths = np.degrees(np.arctan2(-directions[8:16, 1], directions[8:16, 0]))
    np.testing.assert_allclose(azimuths, -180 + 45 * (np.arange(8) + 0.5), atol=1e-12)
    # A zone of the sphere between elevations ±e fills 4 pi sin(e); here tan(e) = pi 3 / 8.
    tangent = np.pi * 3 / 8
    assert camera.solid_angles(8, 3).sum() == pytest.approx(4 * np.pi * tangent / np.hypot(1, tangent))
    _, fine = camera.rays(800, 300)
    small = (2 * np.pi / 800) ** 2 * (1 - fine[:, 2] ** 2) ** 1.5
    np.testing.assert_allclose(camera.solid_angles(800, 300).ravel(), small, rtol=3e-5)


def test_perspective_solid_angles_are_exact():
    # A square of 90° x 90° is one face of a cube: a sixth of the sphere.
    camera = Perspective(EYE, EAST, horizontal_angle=np.pi / 2)
    assert camera.solid_angles(7, 7).sum() == pytest.approx(4 * np.pi / 6, rel=1e-14)
    # Far from the rim a pixel's solid angle is its area times cos³.
    _, directions = camera.rays(1000, 500)
    small = (2 / 1000) ** 2 * directions[:, 0].reshape(500, 1000) ** 3
    np.testing.assert_allclose(camera.solid_angles(1000, 500), small, rtol=1e-5)


@given(vectors, vectors)
def test_axes_are_a_right_handed_rotation(direction, up):
    axes = view_axes(direction, up)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    right, upward, forward = axes
    np.testing.assert_allclose(np.cross(right, upward), -forward, atol=1e-9)
    np.testing.assert_allclose(forward, direction / np.linalg.norm(direction), atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_vertical_line_of_sight_has_north_up(sign):
    right, upward, forward = view_axes(sign * UP, UP)
    np.testing.assert_array_equal(forward, sign * UP)
    np.testing.assert_array_equal(upward, [0, 1, 0])
    np.testing.assert_array_equal(right, [-sign, 0, 0])


def test_a_direction_without_length_is_refused():
    with pytest.raises(ValueError, match="direction"):
        Fisheye(EYE, np.zeros(3)).rays(4, 4)
    with pytest.raises(ValueError, match="horizontal_angle"):
        Perspective(EYE, EAST, horizontal_angle=np.pi)
    with pytest.raises(ValueError, match="horizontal_angle"):
        Cylindrical(EYE, EAST, horizontal_angle=7.0)


def test_views_are_told_as_radiance_options():
    assert Fisheye(EYE, 2 * EAST).view(8, 8) == "-vta -vp 1 2 1.2 -vd 1 0 0 -vu 0 0 1 -vh 180 -vv 180"
    # 90° across; the half height is a half: 2 atan(0.5) = 53.130102°.
    view = Perspective(EYE, EAST, horizontal_angle=np.pi / 2).view(200, 100)
    assert view == "-vtv -vp 1 2 1.2 -vd 1 0 0 -vu 0 0 1 -vh 90 -vv 53.1301024"
    # Radiance's cylinder: azimuth by angle, height by tangent. 90° on 100 by 50: 2 atan(pi / 8) = 42.879781°.
    panorama = Cylindrical(EYE, EAST, horizontal_angle=np.pi / 2).view(100, 50)
    assert panorama == "-vtc -vp 1 2 1.2 -vd 1 0 0 -vu 0 0 1 -vh 90 -vv 42.879781"
    assert Fisheye(EYE, EAST, mapping="equi-solid-angle").view(8, 8) == ""


def test_one_offset_is_the_centre_and_four_fill_the_quarters():
    np.testing.assert_array_equal(stratified_offsets(1), [[0.5, 0.5]])
    quarters = {tuple(corner) for corner in (stratified_offsets(4) * 2).astype(int)}
    assert quarters == {(0, 0), (0, 1), (1, 0), (1, 1)}


@pytest.mark.parametrize("count", [2, 3, 7, 16, 33])
def test_offsets_are_stratified_in_both_coordinates(count):
    offsets = stratified_offsets(count)
    assert offsets.min() > 0 and offsets.max() < 1
    assert sorted((offsets[:, 0] * count).astype(int)) == list(range(count))
    assert len(np.unique(offsets[:, 1])) == count
    # Hammersley's set: for powers of two the other coordinate has one point in each stratum, too.
    if count & (count - 1) == 0:
        assert sorted((offsets[:, 1] * count).astype(int)) == list(range(count))


@pytest.mark.parametrize(
    "camera", [Fisheye(EYE, EAST), Perspective(EYE, EAST), Cylindrical(EYE, EAST, horizontal_angle=5.0)]
)
def test_radiance_sends_the_same_rays(camera):
    asked = [program("vwrays"), *camera.view(12, 8).split(), "-x", "12", "-y", "8", "-pa", "0"]
    told = subprocess.run(asked, capture_output=True, text=True, check=True).stdout
    rays = np.array([[float(number) for number in line.split()] for line in told.splitlines()])
    # vwrays lists all pixels of a fisheye, those beyond 90° too.
    rays = rays.reshape(8, 12, 6)[camera.mask(12, 8)]
    origins, directions = camera.rays(12, 8)
    np.testing.assert_allclose(rays[:, :3], origins, atol=1e-5)
    np.testing.assert_allclose(rays[:, 3:], directions, atol=1e-5)
