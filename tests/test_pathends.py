"""Paths that end on a base and one chain vertex bring what paths bring that go on until they are absorbed."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from rooms import glossy_room, grey, lit, panel
from shapes import box, placed
from verdicts import same_mean

from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.estimate.chainwalk import chain_vertices
from lelight.estimate.effort import bound_for
from lelight.estimate.nearfield import near_field
from lelight.estimate.pathends import PathEnds, path_bound
from lelight.estimate.turns import Turn
from lelight.estimate.variants import VARIANTS
from lelight.preparation import prepare
from lelight.receivers import ILLUMINANCE, space_receivers, with_surface
from lelight.settings import Settings
from lelight.tracing.sobol import Stretch

REPLICATES = 64
#: Bound at the surfaces of paths, 1/m².
BOUND = 0.1
#: On the floor beside the wall that parts two rooms, on either side, in the dark room, and under its shelf.
PLACES = [(1.9, 0.3, 0.0), (2.15, 0.3, 0.0), (3.5, 1.5, 0.0), (3.9, 0.1, 0.0)]


@lru_cache
def two_rooms():
    """A lit room and one lit through a door, with a shelf that reflects sharply; walls hardly glossy."""
    scene = lit(
        box((4.0, 3.0, 2.5)),
        placed(box((0.1, 1.4, 2.5)), shift=(2.0, 0.0, 0.0)),
        placed(box((0.6, 0.6, 0.05)), shift=(3.4, 0.0, 0.3)),
        panel((0.5, 1.0, 2.45), (0.0, 0.8, 0.0), (0.8, 0.0, 0.0)),
        materials=[
            grey("walls", 0.6, specular=0.02, exponent=20.0),
            grey("parting", 0.6),
            grey("shelf", 0.3, specular=0.3, exponent=300.0),
            grey("lamp", 0.5, luminance=1000.0),
        ],
    )
    with ThreadPoolExecutor(2) as executor:
        return prepare(scene, Settings(edge=0.3), executor, Keeper())


def near_light(factor: float, *, ends: bool, of_base: float = 1.0, chains: bool = True):
    """Illuminance (REPLICATES, k) beyond a bound and of the base below it, and rays, with the base times a factor."""
    stage = two_rooms()
    assert stage.base is not None
    base = replace(stage.base, illuminance=of_base * stage.base.illuminance)
    receivers = with_surface(space_receivers(np.array(PLACES), np.tile([0.0, 0.0, 1.0], (len(PLACES), 1))))
    found, rays = [], 0
    for k in range(REPLICATES):
        ending = None
        if ends:
            vertices = chain_vertices(
                stage.world, base, Stretch.of(7), VARIANTS["base"], seed=(0, 100 + k, 1)
            )
            ending = PathEnds.of(stage.world, base, vertices, BOUND)
            ending = ending if chains else replace(ending, chances=np.zeros(0))
        moments, _, traced = near_field(
            stage.world,
            receivers,
            bound=factor * bound_for(stage.world.area, 1024.0),
            together=(Turn.of_all(Stretch.of(10), len(receivers)),),
            seed=(0, k if ends else REPLICATES + k, 3),
            base=base,
            ends=ending,
        )
        found.append(luminance_weighted(moments[:, ILLUMINANCE]))
        rays += traced
    return np.array(found), rays


@pytest.mark.parametrize("factor", [0.0, 0.1, 1.6])
def test_paths_bring_the_same_light_with_ends_and_without(factor):
    assert same_mean(near_light(factor, ends=True)[0], near_light(factor, ends=False)[0], relative_error=0.02)


def test_what_a_wrong_base_lacks_comes_from_the_chains():
    wrong = {"factor": 0.1, "of_base": 0.6}
    right, _ = near_light(**wrong, ends=False)
    assert same_mean(near_light(**wrong, ends=True)[0], right, relative_error=0.03)
    assert not same_mean(near_light(**wrong, ends=True, chains=False)[0], right, relative_error=0.03)


def test_ended_paths_take_fewer_rays_and_scatter_no_more():
    ended, rays = near_light(0.1, ends=True)
    absorbed, more_rays = near_light(0.1, ends=False)
    assert rays < more_rays
    assert np.mean(ended.var(axis=0)) < np.mean(absorbed.var(axis=0))


def test_ends_pay_where_the_base_lacks_little():
    """Not in a room all of gloss, most of whose light the chains carry."""
    with ThreadPoolExecutor(2) as executor:
        glossy = prepare(glossy_room(0.2, 0.6, 30.0), Settings(edge=0.5), executor, Keeper())
    for stage, pays in ((two_rooms(), True), (glossy, False)):
        vertices = chain_vertices(stage.world, stage.base, Stretch.of(10), VARIANTS["base"], seed=(0, 0, 1))
        assert (path_bound(stage.world, vertices) > 0.0) is pays
