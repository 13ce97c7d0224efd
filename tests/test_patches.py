"""Patches: what joins and what does not, whatever the model's scale, place and sharing of vertices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import box, circle, fan, icosphere, l_prism, placed, scene_of, soup, strip

from lelight.mesh.patches import patches, weld

QUAD = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])


def count(*shapes, **options):
    return int(patches(scene_of(*shapes), **options).max()) + 1


def hinge(degrees):
    """Two triangles along the x axis whose normals differ by the angle."""
    angle = np.radians(degrees)
    flap = [0.5, np.cos(angle), np.sin(angle)]
    return np.array([[0, 0, 0], [1, 0, 0], [0.5, -1, 0], flap]), np.array([[1, 0, 2], [0, 1, 3]])


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (4.5e5, 5.2e6, 120.0)])
def test_a_box_has_six_patches_of_two_triangles_at_any_scale_and_place(scale, shift):
    room = placed(soup(box()), scale=max(scale, 1e-2) if any(shift) else scale, shift=shift)
    assert patches(scene_of(room)).tolist() == np.repeat(np.arange(6), 2).tolist()


@pytest.mark.parametrize(("degrees", "expected"), [(0, 1), (19.99, 1), (20.01, 2), (90, 2), (180, 2)])
def test_the_crease_angle_decides(degrees, expected):
    assert count(hinge(degrees)) == expected


def test_the_crease_angle_can_be_chosen():
    assert count(hinge(45), crease=np.radians(46)) == 1
    assert count(hinge(45), crease=np.radians(44)) == 2


def test_a_smooth_tube_is_one_patch_and_its_lids_are_two():
    tube = strip(circle(24), circle(24, height=2.0))
    lids = fan(circle(24)[::-1]), fan(circle(24, height=2.0))
    assert count(tube, *lids) == 3
    assert count(strip(circle(12), circle(12, height=2.0))) == 12


def test_a_sphere_is_one_patch_an_l_prism_eight():
    assert count(soup(icosphere(2))) == 1
    assert count(l_prism()) == 8


def test_a_neighbour_wound_the_other_way_is_another_patch():
    assert count((QUAD, FACES)) == 1
    assert count((QUAD, np.array([[0, 1, 2], [0, 3, 2]]))) == 2


def test_another_material_is_another_patch():
    halves = [(QUAD, FACES[:1]), (QUAD, FACES[1:])]
    assert patches(scene_of(*halves, materials=[0, 1])).tolist() == [0, 1]
    assert patches(scene_of(*halves, materials=[1, 1])).tolist() == [0, 0]


def test_three_triangles_on_an_edge_do_not_join():
    fin = np.array([[0, 0, 0], [1, 1, 0], [0.5, 0.5, 1]]), np.array([[0, 1, 2]])
    assert count((QUAD, FACES), fin) == 3


def test_duplicates_stay_apart():
    assert count((QUAD, FACES[:1]), (QUAD, FACES[:1])) == 2


def test_triangles_without_area_stand_alone_and_open_no_way():
    line = np.array([[0, 1, 1], [0, 1, 1], [0, 1, 2], [2, 3, 0]])
    labels = patches(scene_of((QUAD, line)))
    assert labels.tolist() == [0, 1, 2, 2]


def test_needles_join_their_neighbours():
    sliver = np.array([[0, 0, 0], [1, 0, 0], [1, 1e-6, 0], [0, 1, 0]])
    assert count((sliver, FACES)) == 1


def test_patches_are_numbered_by_their_first_triangle():
    labels = patches(scene_of(l_prism(), box(), icosphere(1)))
    firsts = np.unique(labels, return_index=True)[1]
    assert (np.diff(firsts) > 0).all()


def test_no_triangles_no_patches():
    assert patches(scene_of((QUAD, FACES[:0]))).shape == (0,)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1e6))
def test_welding_undoes_a_jitter_below_the_tolerance_and_nothing_else(seed, shift):
    random = np.random.default_rng(seed)
    lattice = np.stack(np.meshgrid(*[np.arange(4.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + shift
    copies = np.concatenate([lattice, lattice + random.uniform(-2e-9, 2e-9, lattice.shape)])
    numbers = weld(copies)
    assert np.array_equal(numbers[:64], numbers[64:])
    assert len(np.unique(numbers)) == 64


def test_welding_keeps_points_apart_that_are_ten_tolerances_apart():
    points = np.array([[0, 0, 0], [1, 0, 0], [1e-8, 0, 0]])
    assert len(np.unique(weld(points))) == 3
