"""Rays against made-up rooms whose answers are known, from a millimetre to ten kilometres and far from zero."""

from __future__ import annotations

import numpy as np
import pytest
from rooms import normalised
from shapes import box, placed, scene_of

from lelight.tracing.rays import RayCaster
from lelight.tracing.sampling import cosine_directions

SIZE = np.array([4.0, 3.0, 2.5])
#: Length of one unit, and where the origin lies: a model in millimetres, a room, a landscape, map coordinates.
PLACES = {
    "millimetre": (1e-3, (0.0, 0.0, 0.0)),
    "metre": (1.0, (0.0, 0.0, 0.0)),
    "ten kilometres": (1e4, (0.0, 0.0, 0.0)),
    "map": (1.0, (5e5, 5e6, 120.0)),
}
#: What single precision leaves of a length: 2^-24 of the half extent, after a handful of roundings.
PRECISION = 1e-6

everywhere = pytest.mark.parametrize(("scale", "shift"), PLACES.values(), ids=PLACES)


def directions_of(rng, count):
    return normalised(rng.normal(size=(count, 3)))


def room(scale, shift):
    return RayCaster.of(scene_of(placed(box(tuple(SIZE)), scale=scale, shift=shift)))


def exits(origins, directions):
    """Where rays leave the box [0, SIZE], by slabs: distance, and the wall as (axis, low or high)."""
    with np.errstate(divide="ignore"):
        distances = np.where(directions > 0, SIZE - origins, -origins) / directions
    axis = np.argmin(distances, axis=1)
    return distances.min(axis=1), axis, np.take_along_axis(directions > 0, axis[:, None], 1)[:, 0]


@everywhere
def test_closest_meets_the_wall_that_the_slabs_say(scale, shift):
    rng = np.random.default_rng(1)
    origins = rng.uniform(0.01, 0.99, (4000, 3)) * SIZE
    directions = directions_of(rng, 4000)
    distance, axis, high = exits(origins, directions)
    hits = room(scale, shift).closest(origins * scale + shift, directions)
    expected = origins + distance[:, None] * directions
    assert np.abs((hits.points - shift) / scale - expected).max() < 20 * PRECISION
    normals = room(scale, shift).normals[hits.triangle]
    clear = np.sort(np.minimum(expected, SIZE - expected), axis=1)[:, 1] > 20 * PRECISION
    assert np.array_equal(np.abs(normals[clear]).argmax(axis=1), axis[clear])
    assert np.array_equal(normals[clear, axis[clear]] < 0, high[clear])


@everywhere
def test_hit_points_lie_on_their_triangle_in_double_precision(scale, shift):
    rng = np.random.default_rng(2)
    caster = room(scale, shift)
    origins = rng.uniform(0.01, 0.99, (500, 3)) * SIZE * scale + shift
    hits = caster.closest(origins, directions_of(rng, 500))
    height = np.einsum(
        "kx,kx->k", hits.points - caster.corners[hits.triangle, 0], caster.normals[hits.triangle]
    )
    # Rounding of the coordinates themselves is all that is left.
    assert np.abs(height).max() <= 8 * np.finfo(float).eps * (np.abs(shift).max() + 4 * scale)


def test_a_ray_that_leaves_the_scene_hits_nothing_and_stays_where_it_was():
    caster = room(1.0, (0.0, 0.0, 0.0))
    origins = np.array([[10.0, 1.0, 1.0], [1.0, 1.0, 1.0]])
    hits = caster.closest(origins, np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    assert hits.triangle[0] == -1
    assert hits.triangle[1] >= 0
    assert np.array_equal(hits.points[0], origins[0])
    assert not hits.normals[0].any()
    # The ray from inside meets the wall x = 4, whose front looks back along it.
    assert np.array_equal(hits.normals[1], [-1.0, 0.0, 0.0])
    assert hits.front[1]


def test_normals_are_those_of_the_side_that_was_hit():
    """From outside the box its walls are met on their backs."""
    hits = room(1.0, (0.0, 0.0, 0.0)).closest(np.array([[10.0, 1.0, 1.0]]), np.array([[-1.0, 0.0, 0.0]]))
    assert np.array_equal(hits.normals, [[1.0, 0.0, 0.0]])
    assert not hits.front[0]


@everywhere
def test_visible_agrees_with_the_geometry_of_a_screen(scale, shift):
    """A screen x = 2, 1 < y < 2, 0.5 < z < 1.5 in the room: a segment is cut where it crosses the rectangle."""
    screen = (
        np.array([[2, 1, 0.5], [2, 2, 0.5], [2, 2, 1.5], [2, 1, 1.5]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    shapes = [placed(shape, scale=scale, shift=shift) for shape in (box(tuple(SIZE)), screen)]
    caster = RayCaster.of(scene_of(*shapes))
    rng = np.random.default_rng(3)
    starts, ends = (rng.uniform(0.01, 0.99, (2, 4000, 3)) * SIZE).copy()
    share = (2.0 - starts[:, 0]) / (ends[:, 0] - starts[:, 0])
    crossing = starts + share[:, None] * (ends - starts)
    inside = np.minimum(crossing[:, 1:] - [1.0, 0.5], [2.0, 1.5] - crossing[:, 1:]).min(axis=1)
    blocked = (share > 0) & (share < 1) & (inside > 0)
    # Within single precision of the screen's border or plane either answer is right.
    told = (np.abs(inside) > 1e-5) & (np.abs(starts[:, 0] - 2) > 1e-4) & (np.abs(ends[:, 0] - 2) > 1e-4)
    seen = caster.visible(starts * scale + shift, ends * scale + shift)
    assert 200 < blocked[told].sum() < told.sum() - 200
    assert np.array_equal(seen[told], ~blocked[told])
    back = caster.visible(ends * scale + shift, starts * scale + shift)
    assert np.array_equal(back[told], seen[told])


@everywhere
def test_unblocked_is_visible_in_embrees_own_coordinates(scale, shift):
    rng = np.random.default_rng(4)
    caster = room(scale, shift)
    starts, ends = rng.uniform(-0.2, 1.2, (2, 1000, 3)) * SIZE * scale + shift
    own = ((starts - caster.centre) * caster.scale).astype(np.float32)
    segments = ((ends - caster.centre) * caster.scale).astype(np.float32) - own
    assert np.array_equal(caster.unblocked(own, segments), caster.visible(starts, ends))


@everywhere
@pytest.mark.parametrize("distance", [0.0, 1e-6, 1e-3, 1.0])
def test_rays_from_corners_neither_meet_their_own_surface_nor_leave_the_room(scale, shift, distance):
    """Points on the floor at a distance from both walls of a corner; the room is closed, so all rays end in it."""
    rng = np.random.default_rng(5)
    count = 4000
    points = np.tile([distance, distance, 0.0], (count, 1)) * scale + shift
    normals = np.tile([0.0, 0.0, 1.0], (count, 1))
    directions = cosine_directions(rng.random((count, 2)), normals)
    caster = room(scale, shift)
    # At the corner itself the origin stands on the walls' planes, where only rays into the room tell anything.
    into_room = (directions[:, :2] > 0).all(axis=1) | (distance > 0)
    hits = caster.closest(caster.leave(points, normals)[into_room], directions[into_room])
    assert np.all(hits.triangle >= 0)
    assert np.all(caster.normals[hits.triangle, 2] < 0.5)


@everywhere
def test_hits_at_the_very_edges_keep_off_them_and_walk_on_inside_the_room(scale, shift):
    """Rays aimed at edges and corners: single precision puts a part of the hits beyond the edge of their wall.

    They are drawn back by the offset, so a walk goes on inside the closed room and never meets its outside.
    """
    rng = np.random.default_rng(8)
    count = 20_000
    caster = room(scale, shift)
    on_edges = rng.random((count, 3))
    ends = rng.integers(0, 2, (count, 3))
    fixed = rng.permuted(np.tile([True, True, False], (count, 1)), axis=1)
    targets = np.where(fixed, ends, on_edges) * SIZE
    origins = rng.uniform(0.1, 0.9, (count, 3)) * SIZE
    directions = normalised(targets - origins)
    hits = caster.closest(origins * scale + shift, directions)
    assert np.all(hits.triangle >= 0)
    heights = np.sort(np.minimum(hits.points - shift, SIZE * scale - (hits.points - shift)), axis=1)
    # Nearest is the wall itself; the walls next to it stand off by the offset, as far as coordinates tell.
    rounding = 8 * np.finfo(float).eps * np.abs(shift).max()
    assert heights[:, 1].min() > 0.5 * caster.offset - rounding
    onward = cosine_directions(rng.random((count, 2)), hits.normals)
    after = caster.closest(caster.leave(hits.points, hits.normals), onward)
    assert np.all(after.triangle >= 0)
    assert np.all(after.front)


@everywhere
def test_lifted_ends_on_two_walls_of_an_edge_see_each_other(scale, shift):
    """Floor and wall x = 0 near their common edge: nothing stands between them, however near they are."""
    rng = np.random.default_rng(6)
    near = 10.0 ** rng.uniform(-4, 0, (2, 2000))
    y = rng.uniform(0.1, 2.9, (2, 2000))
    floor = np.stack([near[0], y[0], np.zeros(2000)], axis=1) * scale + shift
    wall = np.stack([np.zeros(2000), y[1], near[1]], axis=1) * scale + shift
    caster = room(scale, shift)
    starts = caster.leave(floor, np.tile([0.0, 0.0, 1.0], (2000, 1)))
    ends = caster.leave(wall, np.tile([1.0, 0.0, 0.0], (2000, 1)))
    assert caster.visible(starts, ends).all()


def test_a_thin_sheet_separates_its_two_sides():
    """Points lifted to the two sides of one rectangle do not see each other: the offset does not leak."""
    sheet = (
        np.array([[0, 0, 1], [4, 0, 1], [4, 3, 1], [0, 3, 1]], dtype=float),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    caster = RayCaster.of(scene_of(box(tuple(SIZE)), sheet))
    rng = np.random.default_rng(7)
    above, below = (np.append(rng.uniform(0.1, 2.9, (2000, 2)), np.ones((2000, 1)), axis=1) for _ in range(2))
    up = np.tile([0.0, 0.0, 1.0], (2000, 1))
    assert not caster.visible(caster.leave(above, up), caster.leave(below, -up)).any()
