"""Rays that are led to where light comes from bring the same light, and scatter less where it comes through a door."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from test_pathends import PLACES, REPLICATES, two_rooms
from verdicts import same_mean

from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.estimate import nearfield
from lelight.estimate.chainwalk import chain_vertices
from lelight.estimate.effort import bound_for
from lelight.estimate.guide import EVENLY, cells_of, densities, guided, sides_for, tables
from lelight.estimate.nearfield import near_field
from lelight.estimate.pathends import PathEnds
from lelight.estimate.paths import reflected_radiance
from lelight.estimate.turns import Turn
from lelight.estimate.variants import VARIANTS
from lelight.preparation import prepare
from lelight.reading.loading import load
from lelight.receivers import ILLUMINANCE, space_receivers, with_surface
from lelight.settings import Settings
from lelight.tracing.sampling import to_axis
from lelight.tracing.sobol import Stretch

#: Cells across each number, and all of them.
SIDES, CELLS = 8, 64


def some_densities(rng):
    """Densities of 30 places that few rays saw, each alone."""
    light = rng.gamma(0.2, size=(30, CELLS))
    return densities(light, np.ones((30, CELLS)), np.arange(30)[:, None])


def test_the_warp_fills_cells_by_their_density_and_weighs_that_out():
    density = some_densities(np.random.default_rng(1))
    steps = (np.arange(512) + 0.5) / 512
    even = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    for row in (0, 7):
        u, v, q = np.array([guided(density, density.sum(axis=2), row, *pair) for pair in even]).T
        assert u.min() >= 0.0 and u.max() < 1.0 and v.min() >= 0.0 and v.max() < 1.0
        cells = cells_of(np.stack([u, v], axis=1), SIDES)
        np.testing.assert_array_equal(q, density[row].ravel()[cells])
        shares = np.bincount(cells, minlength=CELLS) / len(q)
        # The border of two cells lies between two of the rows of points: off by a part of a row's share of a sector.
        np.testing.assert_allclose(shares, density[row].ravel() / CELLS, atol=4.0 / (512 * SIDES))
        # A smooth function's integral over the unit square, 0.5 + 1/pi.
        assert np.mean((u + np.sin(math.pi * v) / 2.0) / q) == pytest.approx(0.5 + 1.0 / math.pi, rel=2e-3)


def test_the_more_rays_a_place_sends_the_finer_are_its_cells():
    assert [sides_for(log2_rays) for log2_rays in (5, 6, 7, 8)] == [8, 16, 16, 24]


def test_no_row_changes_nothing():
    assert guided(*tables(None), -1, 0.3, 0.9) == (0.3, 0.9, 1.0)
    assert guided(*tables(None), 3, 0.3, 0.9) == (0.3, 0.9, 1.0)
    density = some_densities(np.random.default_rng(1))
    assert guided(density, density.sum(axis=2), -1, 0.3, 0.9) == (0.3, 0.9, 1.0)


def test_densities_are_shares_and_leave_no_direction_out():
    density = some_densities(np.random.default_rng(2))
    # They are stored in single precision.
    np.testing.assert_allclose(density.mean(axis=(1, 2)), 1.0, rtol=1e-6)
    assert density.min() >= EVENLY
    dark = densities(np.zeros((2, CELLS), dtype=np.float32), np.ones((2, CELLS)), np.array([[0], [1]]))
    np.testing.assert_array_equal(dark, 1.0)


def test_light_that_is_the_same_everywhere_leaves_directions_even():
    rays = np.random.default_rng(3).integers(0, 5, size=(8, CELLS)).astype(float)
    around = np.array([np.roll(np.arange(8), -k) for k in range(4)]).T
    np.testing.assert_allclose(densities(7.0 * rays, rays, around), 1.0, rtol=1e-12)


def test_cells_beside_each_other_and_places_around_share_what_they_saw():
    light = np.zeros((2, CELLS))
    light[0, 3 * SIDES] = 1.0
    rays = np.ones((2, CELLS))
    density = densities(light, rays, np.array([[0, 0], [0, 1]]))
    assert density[0, 3].argmax() == 0 and density[0, 3, 1] == density[0, 3, -1] > EVENLY
    assert density[0, 2, 0] == density[0, 4, 0] > EVENLY and density[0, 6, 4] == EVENLY
    # The second saw nothing itself: half even, half like the first.
    expected = (1.0 - EVENLY) * 0.5 + (EVENLY + density[0]) / 2.0
    np.testing.assert_allclose(density[1], expected, rtol=1e-12)


@pytest.mark.parametrize("axis", [(1.0, 0.0), (0.0, -1.0), (0.6, 0.8)])
def test_rounding_does_not_turn_the_frame_of_a_wall(axis):
    frames = [to_axis(0.3, 0.4, 0.5, *axis, tilt) for tilt in (-1e-9, -1e-17, 0.0, 1e-17)]
    np.testing.assert_allclose(frames, np.tile(frames[0], (4, 1)), atol=1e-8)


@lru_cache
def corridor():
    """The corridor of two legs, one of which has no lamp; of its nodes every twentieth."""
    scene = load(Path(__file__).parents[1] / "scenes" / "corridor.toml")
    with ThreadPoolExecutor(2) as executor:
        stage = prepare(scene, Settings(edge=0.5), executor, Keeper())
    return stage, stage.receivers[np.flatnonzero(~stage.mesh.hidden)[::20]]


def gathered(stage, receivers, guide, *, bound, log2_rays, ends_at=None):
    """Illuminance (REPLICATES, k) by the base below a bound and paths above it, which may end at another bound."""
    base, found, ends = replace(stage.base, guide=guide), [], None
    if ends_at is not None:
        vertices = chain_vertices(stage.world, base, Stretch.of(8), VARIANTS["base"], seed=(0, 99, 1))
        ends = PathEnds.of(stage.world, base, vertices, ends_at)
    for k in range(REPLICATES):
        moments, _, _ = near_field(
            stage.world,
            guide.leading(receivers) if guide else receivers,
            bound=bound,
            together=(Turn.of_all(Stretch.of(log2_rays), len(receivers)),),
            seed=(0, k if guide else REPLICATES + k, 3),
            base=base,
            ends=ends,
        )
        found.append(luminance_weighted(moments[:, ILLUMINANCE]))
    return np.array(found)


def test_led_rays_bring_the_same_light_even_where_they_are_misled():
    stage = two_rooms()
    receivers = with_surface(space_receivers(np.array(PLACES), np.tile([0.0, 0.0, 1.0], (len(PLACES), 1))))
    effort = {"bound": 0.4 * bound_for(stage.world.area, 1024.0), "log2_rays": 10}
    guide = stage.base.guide
    misled = replace(guide, density=guide.density[:, ::-1, ::-1].copy(), rings=guide.rings[:, ::-1].copy())
    unled = gathered(stage, receivers, None, **effort)
    assert same_mean(gathered(stage, receivers, guide, **effort), unled, relative_error=0.02)
    assert same_mean(gathered(stage, receivers, misled, **effort), unled, relative_error=0.02)


def test_led_rays_scatter_half_as_much_in_a_corridor():
    stage, receivers = corridor()
    led, unled = (
        gathered(stage, receivers, guide, bound=math.inf, log2_rays=4) for guide in (stage.base.guide, None)
    )
    relative = led.var(axis=0) / unled.mean(axis=0) ** 2
    assert np.mean(relative) < 0.5 * np.mean(unled.var(axis=0) / unled.mean(axis=0) ** 2)


def test_paths_are_led_on_from_the_surfaces_that_they_meet(monkeypatch):
    """Where only the rays from the receivers are led, what paths bring scatters more."""
    stage, receivers = corridor()
    effort = {"bound": 0.0, "log2_rays": 4, "ends_at": 0.2}
    led = gathered(stage, receivers, stage.base.guide, **effort)

    def not_led_on(*given, guide, **options):
        return reflected_radiance(*given, guide=None, **options)

    monkeypatch.setattr(nearfield, "reflected_radiance", not_led_on)
    first_only = gathered(stage, receivers, stage.base.guide, **effort)
    mean = 0.5 * (led.mean(axis=0) + first_only.mean(axis=0))
    # The median: two nodes beside boxes get less than 0.1 lx, by rare paths.
    assert np.median(led.var(axis=0) / mean**2) < 0.6 * np.median(first_only.var(axis=0) / mean**2)


def test_a_place_without_any_node_around_is_not_led():
    guide = two_rooms().base.guide
    none = replace(guide, rows=guide.rows[:0])
    np.testing.assert_array_equal(none.at(np.zeros((2, 3)), np.ones((2, 3))), -1)
