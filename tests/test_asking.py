"""Receivers that ask some of the vertices, by thinning or by a light tree, get what all of them give."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from rooms import glossy_room, grey, lit, panel
from shapes import box, placed
from verdicts import agrees

from lelight.channels import luminance_weighted
from lelight.estimate.effort import bound_for
from lelight.estimate.lighttree import LightTree
from lelight.estimate.local import local_estimate
from lelight.estimate.pairs import drawn_pairs
from lelight.estimate.thinning import Thinning, lobe_strengths
from lelight.receivers import ILLUMINANCE, SCALAR, Receivers, joined, space_receivers, with_surface
from lelight.tracing.chains import ChainVertices, emission_chains, hash_of
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World, build_world

KEYS = 400
ASKED = 40.0
#: On the floor of the lit room, beside the wall that parts it from the dark one, and in the dark room.
PLACES = [(1.0, 1.5, 0.0), (1.9, 0.3, 0.0), (2.15, 0.3, 0.0), (3.5, 2.5, 0.0)]


def two_rooms():
    """A lit room and one lit through a door."""
    return lit(
        box((4.0, 3.0, 2.5)),
        placed(box((0.1, 1.4, 2.5)), shift=(2.0, 0.0, 0.0)),
        panel((0.5, 1.0, 2.45), (0.0, 0.8, 0.0), (0.8, 0.0, 0.0)),
        materials=[grey("walls", 0.6), grey("parting", 0.6), grey("lamp", 0.5, luminance=1000.0)],
    )


@lru_cache
def lit_by_chains(glossy: bool) -> tuple[World, ChainVertices, Receivers, float]:
    """World, vertices of both signs, receivers on surfaces and in space, and bound."""
    world = build_world(glossy_room(0.5, 0.3, 200.0) if glossy else two_rooms(), 1)
    vertices = emission_chains(world, Stretch.of(9), seed=(1,))
    signs = np.where(np.arange(len(vertices)) % 3 == 0, -0.2, 1.0)
    vertices = vertices.with_flux(vertices.flux * signs[:, None])
    places = np.array(PLACES)
    floor = with_surface(space_receivers(places, np.tile([0.0, 0.0, 1.0], (len(places), 1))))
    space = space_receivers(places + np.array([0.0, 0.0, 1.0]), np.tile([1.0, 0.0, 0.0], (len(places), 1)))
    return world, vertices, joined([floor, space]), bound_for(world.area, 1024.0)


def of_all(glossy: bool) -> np.ndarray:
    """Illuminance and scalar illuminance (2 r,) by all vertices."""
    world, vertices, receivers, bound = lit_by_chains(glossy)
    return light_of(local_estimate(world, receivers, vertices=vertices, bound=bound).moments)


def light_of(moments: np.ndarray) -> np.ndarray:
    return luminance_weighted(moments[:, [ILLUMINANCE, SCALAR]]).ravel()


def asked_light(glossy: bool, *, by_tree: bool, asked: float = ASKED) -> tuple[np.ndarray, float]:
    """Light (KEYS, 2 r) by vertices that are drawn anew each time, and shadow rays a receiver."""
    world, vertices, receivers, bound = lit_by_chains(glossy)
    tree = LightTree.of(world, vertices) if by_tree else None
    found = [
        local_estimate(
            world, receivers, vertices=vertices, bound=bound, asked=asked, key=hash_of((7, k)), tree=tree
        )
        for k in range(KEYS)
    ]
    rays = np.mean([each.rays for each in found]) / len(receivers)
    return np.array([light_of(each.moments) for each in found]), float(rays)


@pytest.mark.parametrize(("glossy", "by_tree"), [(False, False), (False, True), (True, False)])
def test_some_vertices_give_what_all_give(glossy: bool, by_tree: bool):
    assert agrees(asked_light(glossy, by_tree=by_tree)[0], of_all(glossy), relative_error=0.06)


@pytest.mark.parametrize("by_tree", [False, True])
def test_a_receiver_asks_about_as_many_as_it_is_told_to(by_tree: bool):
    """Not more than three times as many, and far less than half of all, which face it."""
    _, rays = asked_light(False, by_tree=by_tree)
    _, vertices, _, _ = lit_by_chains(False)
    assert ASKED / 4.0 < rays < 3.0 * ASKED < len(vertices) / 8.0


@pytest.mark.parametrize("by_tree", [False, True])
def test_more_asked_scatter_less(by_tree: bool):
    few, many = (asked_light(False, by_tree=by_tree, asked=asked)[0] for asked in (16.0, 256.0))
    assert np.all(many.var(axis=0) < few.var(axis=0))


def test_without_the_chances_the_answer_is_wrong():
    """The draw is far from even: who forgets what it was drawn by is found out."""
    world, vertices, receivers, bound = lit_by_chains(False)
    tree = LightTree.of(world, vertices)
    assert tree is not None
    found = []
    for k in range(KEYS):
        thinning = Thinning.of(world, receivers, vertices, bound=bound, asked=ASKED, key=hash_of((7, k)))
        vertex, receiver, chances = tree.draw(receivers, bound=bound, thinning=thinning)
        even = np.full(len(chances), len(chances) / (len(vertices) * len(receivers)))
        pairs = drawn_pairs(world, receivers, vertices, drawn=(vertex, receiver, even), bound=bound)
        clear = world.caster.unblocked(pairs.origins, pairs.segments)
        flux = luminance_weighted(vertices.flux)[pairs.vertex] * world.reflectances.diffuse[0, 0]
        light = np.bincount(pairs.receiver, clear * pairs.diffuse * flux, minlength=len(receivers))
        found.append(light[: len(PLACES)])
    assert not agrees(np.array(found), of_all(False)[: 2 * len(PLACES) : 2], relative_error=0.5)


def test_vertices_are_drawn_as_often_as_the_tree_says():
    """Frequencies of all vertices at one receiver against their chances: z by the binomial variance."""
    world, vertices, receivers, bound = lit_by_chains(False)
    tree, one, draws = LightTree.of(world, vertices), receivers[np.array([1])], 3000
    assert tree is not None
    counts, chance = np.zeros(len(vertices)), np.zeros(len(vertices))
    for k in range(draws):
        thinning = Thinning.of(world, one, vertices, bound=bound, asked=ASKED, key=hash_of((9, k)))
        vertex, _, chances = tree.draw(one, bound=bound, thinning=thinning)
        counts[vertex] += 1.0
        chance[vertex] = chances
    drawn = chance > 0.0
    spread = np.sqrt(draws * chance * (1.0 - chance))[drawn]
    always = spread == 0.0
    assert np.all(counts[drawn][always] == draws)
    z = (counts - draws * chance)[drawn][~always] / spread[~always]
    assert len(z) > 300 and np.abs(z).max() < 5.0 and np.abs(z).mean() < 1.0


def test_a_channel_that_is_hardly_luminous_is_asked_in_its_own_right():
    """A vertex of blue alone, a fourteenth as luminous as white, has at least the sixth that is its share of colour."""
    scene = lit(box(), materials=[grey("walls", 0.5, luminance=1.0)])
    world = build_world(scene, 3)
    vertices = emission_chains(world, Stretch.of(4), seed=(1,))
    colours = np.array([[1.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    two = vertices[np.arange(2)].with_flux(colours)
    strengths = lobe_strengths(world, two)[0]
    assert strengths.sum() == pytest.approx(0.5 * luminance_weighted(colours).sum(), rel=1e-12)
    blue = strengths[1] / strengths.sum()
    assert blue == pytest.approx(0.5 * 0.0722 / 1.0722 + 0.5 * (0.5 / 3.0), rel=1e-3)


def test_the_tree_holds_every_vertex_once():
    world, vertices, _, _ = lit_by_chains(False)
    tree = LightTree.of(world, vertices)
    assert tree is not None
    leaves, flux = np.flatnonzero(tree.left < 0), lobe_strengths(world, vertices)[0]
    assert np.array_equal(np.sort(-1 - tree.left[leaves]), np.flatnonzero(flux > 0))
    assert tree.nodes[0, 0] == pytest.approx(flux.sum())
    below = vertices.points[-1 - tree.left[leaves]]
    reach = np.linalg.norm(below - tree.nodes[0, 1:4], axis=1)
    assert reach.max() <= tree.nodes[0, 4] * (1.0 + 1e-12)


def test_a_receiver_that_few_vertices_face_asks_them_all_the_same():
    """One centimetre under the ceiling and facing it: what is sketched gives it next to nothing."""
    world, vertices, _, bound = lit_by_chains(False)
    up = with_surface(space_receivers(np.array([[1.0, 1.5, 2.49]]), np.array([[0.0, 0.0, 1.0]])))
    tree = LightTree.of(world, vertices)
    assert tree is not None
    for key in range(20):
        thinning = Thinning.of(world, up, vertices, bound=bound, asked=ASKED, key=hash_of((key,)))
        assert thinning.threshold[0] > 0.0
        _, _, chances = tree.draw(up, bound=bound, thinning=thinning)
        assert np.all((chances > 0.0) & (chances <= 1.0))
        of_tree, of_scan = (
            local_estimate(
                world, up, vertices=vertices, bound=bound, asked=ASKED, key=hash_of((key,)), tree=by
            )
            for by in (tree, None)
        )
        assert np.isfinite(of_tree.moments).all() and np.isfinite(of_scan.moments).all()


def test_no_tree_with_phong_lobes_or_without_lambertian_ones():
    world, vertices, _, _ = lit_by_chains(True)
    assert LightTree.of(world, vertices) is None
    world, vertices, _, _ = lit_by_chains(False)
    dark = replace(world, reflectances=world.reflectances._replace(diffuse=np.zeros((3, 1))))
    assert LightTree.of(dark, vertices) is None
