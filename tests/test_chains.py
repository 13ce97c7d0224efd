"""Chains of light: their flux adds up, their directions follow the lobes, their numbers repeat."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rooms import furnace, glossy_room, grey, lit
from shapes import box
from verdicts import agrees, follows

from lelight.tracing.chains import (
    BOTH_LOBES,
    DIFFUSE_LOBE,
    SPECULAR_LOBE,
    ChainVertices,
    emission_chains,
    hash_of,
    joined,
    walk_on,
)
from lelight.tracing.sampling import mirrored
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import build_world

EXACT = 1e-9
REPLICATES = 24
CHAINS = 20_000


def test_flux_of_the_first_bounces_is_what_the_walls_leave_of_it():
    """In a closed grey box of 6 m² and 1 lm/m² the k-th bounce brings 6 rho^k lm; no roulette in the first two."""
    vertices = emission_chains(build_world(furnace(0.6), 1), Stretch.of(8), seed=(1,))
    for bounce in range(3):
        flux = vertices.flux[bounce * 256 : (bounce + 1) * 256]
        np.testing.assert_allclose(flux, 6 * 0.6**bounce / 256, rtol=EXACT)


@pytest.mark.parametrize("nodes", [1, 2, 3])
def test_chains_that_are_cut_off_are_the_beginning_of_whole_ones(nodes):
    world = build_world(furnace(0.6), 1)
    whole = emission_chains(world, Stretch.of(6), seed=(1,))
    cut = emission_chains(world, Stretch.of(6), seed=(1,), nodes=nodes)
    assert len(cut) == 64 * nodes < len(whole)
    np.testing.assert_array_equal(cut.points, whole.points[: len(cut)])


@pytest.mark.parametrize("reflectance", [0.6, 0.95])
def test_flux_of_all_bounces_is_the_geometric_series(reflectance):
    """Sum over bounces of 6 rho^k = 6 / (1 - rho) lm arrive: the roulette takes nothing away on average."""
    world = build_world(furnace(reflectance), 1)
    arriving = np.array(
        [emission_chains(world, Stretch.of(9), seed=(k,)).flux.sum(axis=0) for k in range(REPLICATES)]
    )
    assert agrees(arriving, 6 / (1 - reflectance), relative_error=0.01)
    assert not agrees(arriving, 6 / (1 - reflectance - 0.02), relative_error=0.01)


def test_each_channel_keeps_its_own_reflectance():
    """RGB walls of 0.6, 0.3, 0.05 lit white: every channel is its own geometric series."""
    scene = furnace(0.6)
    colours = np.array([0.6, 0.3, 0.05])
    world = build_world(replace(scene, materials=(replace(scene.materials[0], diffuse=colours),)), 3)
    arriving = np.array(
        [emission_chains(world, Stretch.of(9), seed=(k,)).flux.sum(axis=0) for k in range(REPLICATES)]
    )
    assert agrees(arriving, 6 / (1 - colours), relative_error=0.01)


def test_vertices_lie_on_walls_and_face_the_light():
    vertices = emission_chains(build_world(glossy_room(0.5, 0.2, 30.0), 1), Stretch.of(8), seed=(3,))
    assert np.all(np.einsum("kx,kx->k", vertices.normals, vertices.incoming) > 0)
    np.testing.assert_allclose(np.linalg.norm(vertices.incoming, axis=1), 1.0, rtol=1e-6)
    in_room = np.minimum(vertices.points, np.array([4.0, 3.0, 2.5]) - vertices.points).min(axis=1)
    assert in_room.min() > -1e-9
    assert np.all(vertices.lobes == BOTH_LOBES)


def starts(world, *, lobes, incoming, count=CHAINS):
    """Vertices in the middle of the floor of a room 4 x 3 x 2.5 m, of 1 lm each."""
    same = np.ones(count, dtype=int)
    return ChainVertices(
        points=np.tile([2.0, 1.5, 0.0], (count, 1)),
        normals=np.tile([0.0, 0.0, 1.0], (count, 1)),
        incoming=np.tile(incoming, (count, 1)),
        flux=np.ones((count, world.channels)),
        materials=0 * same,
        triangles=0 * same,
        front=same > 0,
        lobes=lobes * same,
    )


def reflected_once(world, *, lobes, incoming):
    """Directions (k, 3) into which the starts reflect, and the flux (k,) that leaves that way."""
    first = starts(world, lobes=lobes, incoming=incoming)
    numbers = np.random.default_rng(4).random((CHAINS, 29))
    walked = walk_on(world, first, chain=np.arange(CHAINS), points=numbers, seed=(5,))
    return -walked.incoming[CHAINS:], walked.flux[CHAINS:, 0]


def floor_room(diffuse, specular, exponent):
    """A floor that reflects in a black room, so that every chain ends at its second vertex."""
    vertices, triangles = box((4.0, 3.0, 2.5))
    floor = np.all(vertices[triangles][:, :, 2] == 0, axis=1)
    materials = [
        grey("floor", diffuse, specular=specular, exponent=exponent),
        grey("walls", 0.0, luminance=1.0),
    ]
    return build_world(
        lit((vertices, triangles[floor]), (vertices, triangles[~floor]), materials=materials), 1
    )


INCOMING = np.array([0.6, 0.0, 0.8])


def test_the_lambertian_lobe_reflects_by_the_cosine_whatever_comes_in():
    world = floor_room(0.5, 0.0, 1.0)
    directions, flux = reflected_once(world, lobes=BOTH_LOBES, incoming=INCOMING)
    assert len(directions) == CHAINS
    np.testing.assert_allclose(flux, 0.5, rtol=EXACT)
    # Density cosine / pi: 1 - cos² and the azimuth are even.
    azimuth = np.arctan2(directions[:, 1], directions[:, 0])
    cells = np.histogram2d(1 - directions[:, 2] ** 2, azimuth, bins=8, range=((0, 1), (-np.pi, np.pi)))[0]
    assert follows(cells, np.full((8, 8), 1 / 64))


@pytest.mark.parametrize("exponent", [8.0, 200.0])
def test_the_phong_lobe_reflects_about_the_mirror_direction_and_loses_what_goes_below(exponent):
    world = floor_room(0.0, 0.4, exponent)
    directions, flux = reflected_once(world, lobes=BOTH_LOBES, incoming=INCOMING)
    mirror = np.array(mirrored(*INCOMING, 0.0, 0.0, 1.0))
    np.testing.assert_allclose(mirror, [-0.6, 0.0, 0.8], atol=EXACT)
    cos_alpha = directions @ mirror
    # Lobe x cosine over density, the lobe having (n + 2) where its density has (n + 1).
    np.testing.assert_allclose(flux, 0.4 * (exponent + 2) / (exponent + 1) * directions[:, 2], rtol=1e-6)
    # Within arcsin 0.8 of the mirror direction nothing is lost; there cos^(n + 1) is even above 0.6^(n + 1).
    near = cos_alpha > 0.6 + 1e-9
    floor = 0.6 ** (exponent + 1)
    cells = np.histogram(cos_alpha[near] ** (exponent + 1), bins=np.linspace(floor, 1, 13))[0]
    assert follows(cells, np.full(12, 1 / 12))
    assert abs(near.sum() - CHAINS * (1 - floor)) < 5 * np.sqrt(CHAINS * floor) + 1


def test_a_vertex_reflects_only_with_the_lobes_that_it_is_given():
    world = floor_room(0.3, 0.3, 50.0)
    diffuse, diffuse_flux = reflected_once(world, lobes=DIFFUSE_LOBE, incoming=INCOMING)
    specular, _ = reflected_once(world, lobes=SPECULAR_LOBE, incoming=INCOMING)
    _, both_flux = reflected_once(world, lobes=BOTH_LOBES, incoming=INCOMING)
    np.testing.assert_allclose(diffuse_flux, 0.3, rtol=EXACT)
    assert np.mean(specular @ [-0.6, 0.0, 0.8] > 0.8) > 0.999
    assert np.mean(diffuse @ [-0.6, 0.0, 0.8] > 0.8) < 0.3
    # Half the draws each, at twice the weight.
    assert np.mean(np.isclose(both_flux, 0.6, rtol=EXACT)) == pytest.approx(
        0.5, abs=5 * 0.5 / np.sqrt(CHAINS)
    )


def test_black_walls_end_every_chain_at_its_first_vertex():
    scene = lit(box(), materials=[grey("walls", 0.0, luminance=1.0)])
    assert len(emission_chains(build_world(scene, 1), Stretch.of(6), seed=(1,))) == 64


def test_negative_flux_stays_negative():
    world = floor_room(0.5, 0.0, 1.0)
    first = starts(world, lobes=BOTH_LOBES, incoming=INCOMING, count=64)
    walked = walk_on(
        world, first.with_flux(-first.flux), chain=np.arange(64), points=np.full((64, 29), 0.3), seed=(1,)
    )
    assert len(walked) == 128
    np.testing.assert_allclose(walked.flux[64:], -0.5, rtol=EXACT)


def test_chains_depend_on_their_seed_and_on_nothing_else():
    world = build_world(furnace(0.6), 1)
    one, again, other = (
        emission_chains(world, Stretch.of(6), seed=seed) for seed in ((1, 2), (1, 2), (1, 3))
    )
    for name, column in vars(one).items():
        assert np.array_equal(column, getattr(again, name)), name
    assert not np.array_equal(one.points[:64], other.points[:64])


def test_vertices_can_be_selected_copied_and_joined():
    vertices = emission_chains(build_world(furnace(0.6), 1), Stretch.of(4), seed=(1,))
    halves = joined([vertices[np.arange(8)], vertices[np.arange(8, len(vertices))]])
    for name, column in vars(vertices).items():
        assert np.array_equal(column, getattr(halves, name)), name
    assert np.all(vertices.with_lobes(SPECULAR_LOBE).lobes == SPECULAR_LOBE)


def test_keys_differ_by_every_integer_and_by_their_order():
    keys = {int(hash_of(seed)) for seed in [(), (0,), (1,), (0, 0), (0, 1), (1, 0), (2, 1), (1, 2)]}
    assert len(keys) == 8
