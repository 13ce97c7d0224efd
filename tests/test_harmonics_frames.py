from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lelight.harmonics.frames import mirrored, to_local, to_scene
from lelight.harmonics.moments import plane, vector
from lelight.harmonics.projection import project
from lelight.harmonics.spectrum import energy_by_degree

seeds = st.integers(0, 2**32 - 1)


def random_frames(seed, count):
    matrices = Rotation.random(count, rng=np.random.default_rng(seed)).as_matrix()
    return matrices[..., 2], matrices[..., 0]


@given(seeds)
@settings(deadline=None, max_examples=40)
def test_scene_undoes_local_and_lengths_stay(seed):
    normals, frames_x = random_frames(seed, 5)
    vectors = np.random.default_rng(seed).normal(size=(5, 3))
    local = to_local(vectors, normals, frames_x)
    np.testing.assert_allclose(to_scene(local, normals, frames_x), vectors, rtol=0, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(local, axis=1), np.linalg.norm(vectors, axis=1), rtol=1e-14)


def test_axes_are_x_y_z_and_right_handed():
    normal, frame_x = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    scene_axes = np.array([frame_x, [0, 0, 1.0], normal])
    np.testing.assert_array_equal(to_local(scene_axes, normal, frame_x), np.eye(3))


def test_leading_shapes_broadcast():
    normals, frames_x = random_frames(1, 4)
    vectors = np.random.default_rng(1).normal(size=(7, 1, 3))
    local = to_local(vectors, normals, frames_x)
    assert local.shape == (7, 4, 3)
    np.testing.assert_allclose(local[6, 2], to_local(vectors[6, 0], normals[2], frames_x[2]), rtol=1e-14)


@given(seeds)
@settings(deadline=None, max_examples=20)
def test_mirror_image_obeys_the_law_of_reflection(seed):
    arriving = np.random.default_rng(seed).normal(size=3)
    normal = np.array([0, 0, 1.0])
    expected = 2 * (arriving @ normal) * normal - arriving
    np.testing.assert_allclose(mirrored(arriving), expected, rtol=0, atol=1e-15)


@given(seeds)
@settings(deadline=None, max_examples=30)
def test_rotated_light_keeps_its_energy_in_each_degree(seed):
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(12, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    weights = rng.uniform(size=(12, 2))
    turn = Rotation.random(rng=rng)
    before, after = project(9, directions, weights), project(9, turn.apply(directions), weights)
    np.testing.assert_allclose(energy_by_degree(after), energy_by_degree(before), rtol=0, atol=1e-11)
    axis = directions[0]
    np.testing.assert_allclose(plane(after, turn.apply(axis)), plane(before, axis), rtol=0, atol=1e-11)
    np.testing.assert_allclose(vector(after), turn.as_matrix() @ vector(before), rtol=0, atol=1e-12)


def test_energy_of_one_beam_is_the_addition_theorem():
    # sum_m Y_lm(d)² = (2l + 1) / (4 pi), for a beam of weight 3 nine times as much.
    energy = energy_by_degree(project(6, np.array([[0.6, 0.0, 0.8]]), np.array([[3.0]])))
    assert energy[:, 0] == pytest.approx(9 * (2 * np.arange(7) + 1) / (4 * np.pi), rel=1e-13)
