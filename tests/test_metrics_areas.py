"""Bands around a task area, walls and ceiling, grid rule, places beside grid points and eyes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rooms import grey, lit, panel
from shapes import box

from lelight.metrics.areas import required_illuminance, surrounding_areas
from lelight.metrics.en12464 import plane_figures
from lelight.metrics.grid import grid_rule
from lelight.metrics.surfaces import kinds_of, surface_figures
from lelight.places import TURNS, further_places, turned
from lelight.results import PlaneValues
from lelight.scene import MeasuringPlane, Observer
from lelight.tracing.world import build_world


def task(**more):
    return MeasuringPlane(
        "p", np.array([1.0, 1.0, 0.75]), np.array([2.0, 0, 0]), np.array([0, 1.0, 0]), **more
    )


@pytest.mark.parametrize(
    ("asked", "around"), [(1000, 500), (750, 500), (500, 300), (300, 200), (200, 150), (150, 150), (100, 100)]
)
def test_what_the_surrounding_needs(asked, around):
    assert required_illuminance(asked, "surrounding") == around
    assert required_illuminance(asked, "background") == pytest.approx(around / 3)


def test_bands_fill_their_frames_and_no_more():
    surrounding, background = surrounding_areas(task(surrounding=0.5, background=3.0))
    for area, inner, outer in ((surrounding, 0.0, 0.5), (background, 0.5, 3.5)):
        off = np.maximum(np.abs(area.points - [2.0, 1.5, 0.75]) - [1.0, 0.5, 0.0], 0.0)
        distance = off.max(axis=1)
        assert (distance > inner).all() and (distance < outer).all()
        # The nearest point of the task area is never farther than the band is wide, over its corner.
        assert (np.linalg.norm(area.points - area.anchors, axis=1) < outer * math.sqrt(2)).all()
    assert surrounding_areas(task()) == ()


def test_bands_end_at_walls():
    room = replace(
        lit(
            box((4.0, 3.0, 2.5)),
            panel((1, 1, 2.4), (0, 1, 0), (1, 0, 0)),
            materials=[grey("w", 0.5), grey("l", 0.5, luminance=100.0)],
        ),
        planes=(task(surrounding=0.5, background=3.0),),
        observers=(Observer("eye", np.array([2.0, 1.5, 1.2]), np.array([1.0, 0, 0])),),
    )
    world = build_world(room, 1)
    places = further_places(room, ((np.array([[2.0, 1.5, 0.75]]), (1, 1)),), world.caster)
    assert [each.kind for each in places] == ["turned", "vertical", "surrounding", "background"]
    assert len(places[0].points) == TURNS - 1
    assert len(places[1].points) == 4
    for band in places[2:]:
        assert len(band.points)
        assert ((band.points[:, :2] > 0) & (band.points[:, :2] < [4.0, 3.0])).all()


def test_an_eye_turns_to_the_left_in_steps_of_fifteen_degrees():
    directions = turned(np.array([0.6, 0.0, -0.8]))
    assert directions.shape == (24, 3)
    np.testing.assert_allclose(directions[0], [0.6, 0, -0.8])
    np.testing.assert_allclose(directions[6], [0, 0.6, -0.8], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)


def values(base, **more):
    base = np.asarray(base, float)
    replicates = np.array([0.99, 1.0, 1.01, 1.0])[:, None] * base
    where = task(target={"mean_illuminance": 500.0})
    return PlaneValues(
        where, (1, base.size), np.zeros((base.size, 3)), base, base * 0, base, replicates, replicates, **more
    )


def test_areas_are_judged_by_the_tasks_target():
    around = np.array([0.99, 1.0, 1.01, 1.0])[:, None] * np.array([330.0, 340.0, 350.0])
    figures = plane_figures(
        values([500, 520], area_replicates={"surrounding": around, "background": around[:, :0]})
    )
    assert figures["surrounding_mean_illuminance"].target == 300.0
    assert figures["surrounding_mean_illuminance"].verdict == "pass"
    assert figures["surrounding_uniformity"].verdict == "pass"
    assert figures["background_mean_illuminance"].value is None
    assert "seen from the task area" in figures["background_mean_illuminance"].note


def test_spatial_figures_of_a_plane_under_a_beam():
    # E_perp = 1 from 30 degrees off the zenith, in +x: as for a single beam.
    angle = math.radians(30)
    moments = [math.cos(angle), 0.25, math.sin(angle), 0.0, math.cos(angle), math.sin(angle) / math.pi]
    batches = np.tile(np.array(moments), (4, 2, 1))
    figures = plane_figures(values([1.0, 1.0], moment_replicates=batches))
    assert figures["mean_semicylindrical_x"].value == pytest.approx(0.31830988618379064, rel=1e-9)
    assert figures["mean_semicylindrical_y"].value == pytest.approx(0.15915494309189532, rel=1e-9)
    assert figures["mean_semicylindrical_minus_x"].value == pytest.approx(0.0, abs=1e-12)
    assert figures["mean_hemispherical_illuminance"].value == pytest.approx(0.4665063509461097, rel=1e-9)
    assert figures["vector_over_scalar"].value == pytest.approx(4.0, rel=1e-9)


def test_walls_ceiling_and_floor_are_told_from_furniture():
    # A room 3 m high: a wall of two nodes, a cupboard side of 1 m, floor, ceiling, a desk top, a lamp.
    positions = np.array(
        [[0, 0, 0.0], [0, 0, 3.0], [1, 0, 0.0], [1, 0, 1.0], [1, 1, 0], [1, 1, 3], [1, 1, 0.7], [2, 2, 2.9]]
    )
    normals = np.array(
        [[1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [0, 0, 1], [0, 0, -1], [0, 0, 1], [0, 0, -1.0]]
    )
    patches = np.array([0, 0, 1, 1, 2, 3, 4, 5])
    emits = np.arange(8) == 7
    kinds = kinds_of(positions, normals, patches, emits=emits)
    assert {name: found.tolist() for name, found in kinds.items()} == {
        "wall": [0, 1],
        "ceiling": [5],
        "floor": [4],
    }
    replicates = np.array([0.99, 1.0, 1.01, 1.0])[:, None] * np.array([50.0, 150, 1, 1, 80, 40, 1, 1])
    figures = surface_figures(
        kinds, np.array([1.0, 3, 1, 1, 1, 1, 1, 1]), replicates, targets={"wall_illuminance": 100.0}
    )
    assert figures["wall_illuminance"].value == pytest.approx((50 + 3 * 150) / 4)
    assert figures["wall_illuminance"].verdict == "pass"
    assert figures["wall_uniformity"].value == pytest.approx(0.5, rel=1e-9)
    assert figures["ceiling_illuminance"].verdict is None


def test_the_rule_of_the_grid_is_told_with_its_numbers():
    told = grid_rule(8.0, 4.0)
    assert "p = 0.2 · 5^(log10 d) = 0.5271 m for d = 4 m (shorter side: 2:1 or longer)" in told
    assert "16 x 8; cells 0.5 m x 0.5 m, aspect 1" in told
