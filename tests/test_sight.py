"""What receivers know of which sources are in sight changes how much direct light scatters, and nothing else."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from rooms import grey, lamp, lit, panel
from shapes import box, placed
from verdicts import same_mean

from lelight.checkpoint.keeper import Keeper
from lelight.estimate.direct import direct_light, direct_light_and_sight
from lelight.estimate.knowndirect import with_known_direct
from lelight.preparation import prepare
from lelight.receivers import ILLUMINANCE, VECTOR
from lelight.settings import Settings
from lelight.tracing.sight import LEAST, WHOLE, importance_in_sight, shares, unseen
from lelight.tracing.sobol import Stretch

REPLICATES = 64
ALONE = np.arange(2)[:, None]


def counts(*rows):
    return np.array(rows, dtype=np.uint8)


def test_a_share_is_whole_where_every_ray_came_through_and_nothing_where_none_did():
    asked = counts([5, 0, 9], [7, 3, 0])
    np.testing.assert_array_equal(shares(asked, asked, ALONE), WHOLE)
    np.testing.assert_array_equal(shares(asked, np.zeros_like(asked), ALONE), 0)


def test_a_share_follows_the_own_rays_then_those_around_then_all_sources():
    asked, clear = counts([60, 0, 0], [0, 40, 0]), counts([30, 0, 0], [0, 40, 0])
    share = shares(asked, clear, np.array([[0, 1], [1, 0]])) / WHOLE
    of_all = 70 / 100
    assert abs(share[0, 0] - (30 + 2 * (30 + of_all) / 61) / 62) < 1 / WHOLE
    assert abs(share[0, 1] - (40 + of_all) / 41) < 1 / WHOLE
    assert abs(share[0, 2] - of_all) < 1 / WHOLE


def test_no_source_is_left_out_and_no_row_changes_nothing():
    sight = counts([0, WHOLE, WHOLE // 20])
    assert importance_in_sight(sight, 0, 0) == LEAST
    # A twentieth may come through: that deviates by a fifth of the source's light, of which half is the most.
    assert importance_in_sight(sight, 0, 2) == pytest.approx(LEAST + (1.0 - LEAST) * 0.426, abs=0.01)
    assert importance_in_sight(sight, 0, 1) == 1.0
    assert importance_in_sight(unseen(), -1, 7) == 1.0


@lru_cache
def screened():
    """A room under four panels and a lamp, with screens that hide two panels or the lamp from most places."""
    panels = [panel((x, y, 2.45), (0.0, 0.4, 0.0), (0.6, 0.0, 0.0)) for x in (0.5, 2.9) for y in (0.6, 2.0)]
    scene = lit(
        box((4.0, 3.0, 2.5)),
        placed(box((0.05, 2.0, 2.2)), shift=(2.0, 0.5, 0.3)),
        placed(box((0.8, 0.8, 0.05)), shift=(0.4, 1.1, 1.2)),
        *panels,
        materials=[grey("walls", 0.6), *[grey(f"screen {k}", 0.4) for k in range(2)]]
        + [grey(f"lamp {k}", 0.5, luminance=500.0 + 500.0 * k) for k in range(4)],
        luminaires=(lamp((3.0, 1.0, 2.0), 60.0),),
    )
    with ThreadPoolExecutor(2) as executor:
        stage = prepare(scene, Settings(edge=0.3), executor, Keeper())
    return stage, stage.receivers[np.flatnonzero(~stage.mesh.hidden)[::10]]


def drawn(guide, *, seed):
    """Moments (REPLICATES, r, 6, 1) of direct light at some nodes."""
    stage, receivers = screened()
    receivers = with_known_direct(stage.world, receivers, guide.sight if guide is not None else unseen())
    return np.array(
        [
            direct_light(stage.world, receivers, samples=Stretch.of(3), seed=(seed, k), guide=guide)[0]
            for k in range(REPLICATES)
        ]
    )


def test_direct_light_is_the_same_whatever_is_believed_to_be_in_sight():
    guide = screened()[0].base.guide
    misled = replace(guide, sight=WHOLE - guide.sight)
    unaware, aware, wrong = (drawn(each, seed=k) for k, each in enumerate((None, guide, misled)))
    for part in (ILLUMINANCE, VECTOR + 2):
        # Places that get next to nothing have no error to judge by.
        lit_ones = np.abs(unaware[:, :, part, 0].mean(axis=0)) > 20.0
        assert lit_ones.sum() > 50
        means = [each[:, lit_ones, part, 0].mean(axis=1, keepdims=True) for each in (unaware, aware, wrong)]
        assert same_mean(means[0], means[1], relative_error=0.005)
        assert same_mean(means[0], means[2], relative_error=0.01)


def test_what_is_known_once_is_what_is_found_anew():
    stage, receivers = screened()
    assert np.isfinite(receivers.known_direct).all() and receivers.known_direct.any()
    anew = replace(receivers, known_direct=np.full((len(receivers), 1), np.nan))
    once, again = (
        direct_light(stage.world, each, samples=Stretch.of(3), seed=(9,), guide=stage.base.guide)[0]
        for each in (receivers, anew)
    )
    np.testing.assert_array_equal(once, again)


def test_what_is_known_by_the_guide_is_left_without_it():
    stage, receivers = screened()
    anew = replace(receivers, known_direct=np.full((len(receivers), 1), np.nan))
    without = [
        direct_light(stage.world, each, samples=Stretch.of(3), seed=(9,))[0] for each in (receivers, anew)
    ]
    np.testing.assert_array_equal(*without)
    misled = with_known_direct(stage.world, receivers, WHOLE - stage.base.guide.sight)
    samples = {"samples": Stretch.of(3), "seed": (9,), "guide": stage.base.guide}
    right, wrong = (direct_light(stage.world, each, **samples)[0] for each in (receivers, misled))
    assert not np.isclose(right[:, ILLUMINANCE].mean(), wrong[:, ILLUMINANCE].mean(), rtol=0.1)


def test_who_knows_what_is_in_sight_scatters_half_as_much():
    unaware, aware = drawn(None, seed=0), drawn(screened()[0].base.guide, seed=0)
    variance = [each.var(axis=0).sum(axis=0) for each in (unaware, aware)]
    assert variance[1][ILLUMINANCE] < 0.5 * variance[0][ILLUMINANCE]
    along = [each[VECTOR : VECTOR + 3].sum() for each in variance]
    assert along[1] < 0.8 * along[0]


def test_rays_are_counted_by_source():
    stage, receivers = screened()
    samples = Stretch.of(6)
    moments, asked, clear = direct_light_and_sight(stage.world, receivers, samples=samples, seed=(3,))
    plain, rays = direct_light(stage.world, receivers, samples=samples, seed=(3,))
    np.testing.assert_array_equal(moments, plain)
    assert asked.shape == (len(receivers), len(stage.world.emitters.power)) and asked.sum() == rays
    assert np.all(clear <= asked) and 0 < clear.sum() < asked.sum()
