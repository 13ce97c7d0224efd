"""The estimate of illuminance is unbiased: against closed form and against path tracing, by t-test.

The furnace is a closed box whose walls all emit M and reflect rho: radiance is M / (pi (1 - rho)) everywhere and
in every direction, E = M / (1 - rho) on every surface, up to the edges and into the corners. The room has a
lamp, glossy walls and no closed form; there the same estimator with the bound at zero, which is path tracing
from the receiver's side and uses neither chains nor base, says what is right.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from rooms import furnace, glossy_room, grey, lamp, lit, panel
from shapes import box, placed
from verdicts import agrees, same_mean

from lelight.channels import luminance_weighted
from lelight.estimate import batch, local
from lelight.estimate.angular import HarmonicDetail
from lelight.estimate.base import solve_base
from lelight.estimate.batch import estimate_batch
from lelight.estimate.blocks import Effort
from lelight.estimate.direct import direct_light, with_clear_share
from lelight.estimate.effort import LEAST, batches_for, bound_for, choose_effort
from lelight.estimate.replicates import LEAST_REPLICATES
from lelight.mesh.nodes import hide, node_mesh
from lelight.mesh.patches import patches
from lelight.mesh.remesh import remesh
from lelight.plan import make_plan
from lelight.receivers import (
    CYLINDRICAL,
    ILLUMINANCE,
    SCALAR,
    VECTOR,
    joined,
    node_receivers,
    space_receivers,
    surface_receivers,
    with_surface,
)
from lelight.scene import Scene
from lelight.settings import Settings
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import build_world

RHO = 0.6
EXACT = 1e-9
#: Independent batches of a trial.
BATCHES = 12
#: Chains by whose spacing the bound is taken, from emitters and on a base; more are walked from emitters, so
#: that ten times the bound is still quiet.
CHAINS_OF_BOUND, CHAINS_ON_BASE = 2**13, 2**11
#: Standard error at which a trial can tell a reflectance of 0.60 from 0.62, which is 5 % of E.
TELLING = 0.012
THREADS = ThreadPoolExecutor(2)

#: On the floor of a unit cube: in its middle, 1 cm from an edge, 1 cm and 1 mm from two.
CUBE_PLACES = [(0.5, 0.5, 0.0), (0.01, 0.5, 0.0), (0.01, 0.01, 0.0), (0.001, 0.001, 0.0)]
#: In the room: the floor's middle, 1 cm from a wall, in a corner, on a wall.
ROOM_PLACES = [(2.0, 1.5, 0.0), (0.01, 1.5, 0.0), (0.02, 0.02, 0.0), (2.0, 0.0, 1.2)]
UP = (0.0, 0.0, 1.0)


def on_surface(places, normals):
    return with_surface(space_receivers(np.array(places, dtype=float), np.array(normals, dtype=float)))


def cube_receivers():
    inside = space_receivers(np.array([[0.5, 0.3, 0.6]]), np.array([UP]))
    return joined([on_surface(CUBE_PLACES, [UP] * len(CUBE_PLACES)), inside])


def room_receivers():
    return on_surface(ROOM_PLACES, [UP, UP, UP, (0.0, 1.0, 0.0)])


@lru_cache
def furnace_world(reflectance=RHO):
    return build_world(furnace(reflectance), 1)


@lru_cache
def room_world(exponent):
    return build_world(glossy_room(0.4, 0.3, exponent), 1)


def base_of(scene: Scene, world, *, edge):
    """A base field on fronts only, which is all that these closed rooms need."""
    return base_on(fronts_of(scene, edge=edge), scene, world)


def fronts_of(scene: Scene, *, edge):
    labels = patches(scene)
    return node_mesh(remesh(scene, labels, edge=edge), fronts_only(labels))


def fronts_only(labels):
    return np.tile([True, False], (labels.max() + 1, 1))


def base_on(mesh, scene: Scene, world):
    labels = patches(scene)
    return solve_base(
        world,
        mesh,
        node_receivers(mesh),
        labels=labels,
        lit=fronts_only(labels),
        seed=1,
        executor=THREADS,
    )


@lru_cache
def furnace_base(reflectance=RHO):
    return base_of(furnace(reflectance), furnace_world(reflectance), edge=0.5)


@lru_cache
def room_base(exponent):
    return base_of(glossy_room(0.4, 0.3, exponent), room_world(exponent), edge=0.8)


def trial(world, receivers, *, effort, base=None, batches=BATCHES, seed=1):
    """Moments (batches, r, 6, C) of independent batches."""
    receivers = with_clear_share(world, receivers, seed=(seed, 3))
    found = [
        estimate_batch(
            world, receivers, effort=effort, seed=(seed, k), base=base, detail=None, executor=THREADS
        )
        for k in range(batches)
    ]
    return np.array([one.direct + one.indirect for one in found])


def bounded(world, factor, *, base=None, log2_chains=None, log2_near=10):
    """Effort with so many times the default bound; chains on a base are fewer, they carry less."""
    bound = factor * bound_for(world.area, CHAINS_OF_BOUND if base is None else CHAINS_ON_BASE)
    chains = log2_chains or (13 if base is None else 8)
    return Effort(log2_chains=chains, log2_direct=6, log2_near=log2_near, bound=bound)


#: With the bound at zero the chains give nothing, and paths from the receiver's side all.
PATHS = Effort(log2_chains=0, log2_direct=6, log2_near=11, bound=0.0)


def illuminance(moments):
    return moments[:, :, ILLUMINANCE, 0]


factors = pytest.mark.parametrize("factor", [0.1, 1.0, 10.0])


@factors
def test_furnace_by_chains_from_the_emitters(factor):
    world = furnace_world()
    light = illuminance(trial(world, cube_receivers(), effort=bounded(world, factor)))
    assert agrees(light, 1 / (1 - RHO), relative_error=0.03 if factor > 1 else TELLING)


@factors
def test_furnace_on_a_base_field(factor):
    world, base = furnace_world(), furnace_base()
    light = illuminance(trial(world, cube_receivers(), effort=bounded(world, factor, base=base), base=base))
    assert agrees(light, 1 / (1 - RHO), relative_error=TELLING)


def test_furnace_by_path_tracing_alone():
    light = illuminance(trial(furnace_world(), cube_receivers(), effort=PATHS))
    assert agrees(light, 1 / (1 - RHO), relative_error=0.006)


@pytest.mark.parametrize("on_base", [False, True])
def test_a_furnace_of_another_reflectance_is_rejected(on_base):
    """Walls of 0.62 give E = 1 / 0.38, 5 % more: the same trial must see it at every single receiver."""
    world = furnace_world(0.62)
    base = furnace_base(0.62) if on_base else None
    light = illuminance(trial(world, cube_receivers(), effort=bounded(world, 0.1, base=base), base=base))
    for receiver in range(light.shape[1]):
        assert not agrees(light[:, [receiver]], 1 / (1 - RHO), relative_error=TELLING)


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_any_base_gives_the_same_light(share):
    """The chains make up for a base that holds half of the light or none: only the noise grows."""
    world, base = furnace_world(), furnace_base()
    poor = replace(base, illuminance=share * base.illuminance)
    effort = bounded(world, 0.5, base=poor, log2_chains=9, log2_near=9)
    light = illuminance(trial(world, cube_receivers(), effort=effort, base=poor))
    assert agrees(light, 1 / (1 - RHO), relative_error=0.02)


@pytest.mark.parametrize("on_base", [False, True])
def test_moments_in_the_furnace(on_base):
    """Radiance L = E / pi from everywhere. In space: scalar 4 pi L / 4 = E, vector 0, cylindrical L pi = E.

    On the floor, where half the sphere counts: scalar E / 2, vector E along the normal, cylindrical E / 2.
    """
    world = furnace_world()
    base = furnace_base() if on_base else None
    moments = trial(world, cube_receivers(), effort=bounded(world, 0.1, base=base), base=base)
    light = 1 / (1 - RHO)
    middle, space = moments[:, 0, :, 0], moments[:, -1, :, 0]
    for row, expected in ((SCALAR, light / 2), (VECTOR + 2, light), (CYLINDRICAL, light / 2)):
        assert agrees(middle[:, [row]], expected, relative_error=0.02), row
    for row in (ILLUMINANCE, SCALAR, CYLINDRICAL):
        assert agrees(space[:, [row]], light, relative_error=0.02), row
    # Zero has no relative error: the vector is judged with the illuminance added to it.
    for vector in (space[:, VECTOR : VECTOR + 3], middle[:, VECTOR : VECTOR + 2]):
        assert agrees(vector + light, light, relative_error=0.02)


@pytest.mark.parametrize(
    ("scale", "shift"),
    [(2.0**-10, (0.0, 0.0, 0.0)), (2.0**13, (0.0, 0.0, 0.0)), (1.0, (2.0**19, 2.0**22, 64.0))],
)
def test_a_furnace_in_millimetres_in_kilometres_and_at_map_coordinates(scale, shift):
    """Powers of two scale without rounding: the same random numbers give the same light to the last digits."""
    plain, moved = furnace(RHO), furnace(RHO)
    moved = replace(moved, vertices=placed((moved.vertices, moved.triangles), scale=scale, shift=shift)[0])
    light = []
    for scene, unit, origin in ((plain, 1.0, np.zeros(3)), (moved, scale, np.array(shift))):
        world, receivers = build_world(scene, 1), cube_receivers()
        receivers = replace(receivers, points=receivers.points * unit + origin)
        effort = replace(bounded(world, 1.0, log2_chains=9, log2_near=6))
        light.append(illuminance(trial(world, receivers, effort=effort, batches=2)))
    # At map coordinates the last nine digits of positions are gone, and with them a few decisions of paths.
    np.testing.assert_allclose(light[1], light[0], rtol=EXACT if shift[0] == 0.0 else 0.02)


@lru_cache
def room_truth(exponent):
    return illuminance(trial(room_world(exponent), room_receivers(), effort=PATHS, seed=9))


glossy = pytest.mark.parametrize(
    ("exponent", "factor"), [(8.0, 1.0), (64.0, 0.1), (64.0, 10.0), (1000.0, 1.0)]
)


@glossy
def test_glossy_room_by_chains_from_the_emitters(exponent, factor):
    world = room_world(exponent)
    light = illuminance(trial(world, room_receivers(), effort=bounded(world, factor, log2_near=10)))
    assert same_mean(light, room_truth(exponent), relative_error=0.03)


@glossy
def test_glossy_room_on_a_base_field(exponent, factor):
    world, base = room_world(exponent), room_base(exponent)
    effort = bounded(world, factor, base=base, log2_chains=9, log2_near=10)
    light = illuminance(trial(world, room_receivers(), effort=effort, base=base))
    assert same_mean(light, room_truth(exponent), relative_error=0.03)


@pytest.mark.parametrize("on_base", [False, True])
def test_a_room_of_another_gloss_is_rejected(on_base):
    """ks = 0.35 instead of 0.3 is 10 % more light: told from the right room at once."""
    scene = glossy_room(0.4, 0.35, 64.0)
    world = build_world(scene, 1)
    base = base_of(scene, world, edge=0.8) if on_base else None
    effort = bounded(world, 0.1, base=base, log2_near=9)
    light = illuminance(trial(world, room_receivers(), effort=effort, base=base))
    assert not same_mean(light, room_truth(64.0), relative_error=0.03)


def test_colour_is_carried_channel_by_channel():
    """RGB walls: every channel of the furnace is a furnace of its own."""
    scene = furnace(RHO)
    rho = np.array([0.7, 0.4, 0.1])
    scene = replace(scene, materials=(replace(scene.materials[0], diffuse=rho),))
    world = build_world(scene, 3)
    # Receivers ask vertices by their luminance, so red alone is noisier than grey.
    moments = trial(
        world, cube_receivers()[np.array([0, 4])], effort=bounded(world, 1.0), batches=3 * BATCHES
    )
    light = moments[:, :, ILLUMINANCE].reshape(3 * BATCHES, -1)
    assert agrees(light, np.tile(1 / (1 - rho), 2), relative_error=TELLING)


def test_direct_light_in_the_open_is_its_closed_form():
    """Nothing in the way: the control variate leaves no noise, whatever the samples."""
    scene = lit(
        box((4.0, 3.0, 2.5)), materials=[grey("walls", 0.5)], luminaires=(lamp((2.0, 1.5, 2.0), 80.0),)
    )
    world = build_world(scene, 1)
    receivers = with_clear_share(world, room_receivers(), seed=(1, 3))
    assert np.all(receivers.clear_share == 1.0)
    moments, rays = direct_light(world, receivers, samples=Stretch.of(0), seed=(1,))
    ray = np.array([2.0, 1.5, 2.0]) - np.array(ROOM_PLACES)
    distance = np.linalg.norm(ray, axis=1)
    expected = 80.0 * np.einsum("kx,kx->k", ray, receivers.normals) / distance**3
    np.testing.assert_allclose(moments[:, ILLUMINANCE, 0], expected, rtol=EXACT)
    np.testing.assert_allclose(moments[:, SCALAR, 0], 20.0 / distance**2, rtol=EXACT)
    assert rays == 4


def test_direct_light_half_behind_a_screen_does_not_depend_on_the_share_taken_in_closed_form():
    """The control variate's expectation is zero: any share of it gives the same mean."""
    scene = furnace(0.0)
    screen = (
        np.array([[0.3, 0.2, 0.4], [0.9, 0.2, 0.4], [0.9, 0.8, 0.4], [0.3, 0.8, 0.4]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    world = build_world(
        lit((scene.vertices, scene.triangles), screen, materials=[scene.materials[0], grey("screen", 0.5)]), 1
    )
    receivers = on_surface(CUBE_PLACES[:2], [UP] * 2)
    light = []
    for share in (0.0, 0.7):
        shared = replace(receivers, clear_share=np.full(2, share))
        found = [
            direct_light(world, shared, samples=Stretch.of(8), seed=(int(10 * share), k))[0]
            for k in range(BATCHES)
        ]
        light.append(np.array(found)[:, :, ILLUMINANCE, 0])
    assert same_mean(light[0], light[1], relative_error=0.02)
    assert np.all(light[0].mean(axis=0) < 0.95)


def test_a_base_asks_nothing_of_hidden_nodes():
    """Its light at the others is the same to the last bit, wherever the hidden ones are."""
    scene = glossy_room(0.4, 0.3, 30.0)
    mesh = fronts_of(scene, edge=0.8)
    mesh = hide(mesh, np.arange(len(mesh)) % 5 == 0)
    moved = replace(mesh, positions=np.where(mesh.hidden[:, None], (1.7, 1.2, 2.39), mesh.positions))
    bases = [base_on(own, scene, room_world(30.0)) for own in (mesh, moved)]
    assert not bases[0].illuminance[mesh.hidden].any()
    assert bases[0].illuminance[~mesh.hidden].min() > 0.0
    assert np.array_equal(bases[0].illuminance, bases[1].illuminance)


def nodes_of_room(exponent=30.0):
    scene = glossy_room(0.4, 0.3, exponent)
    mesh = fronts_of(scene, edge=0.9)
    return build_world(scene, 1), surface_receivers(mesh, make_plan(scene).degrees[mesh.materials])


def one_batch(world, receivers, *, base, workers=2, seed=(3, 4)):
    degree = int(receivers.degrees.max())
    detail = HarmonicDetail(degree, 1, np.array([degree, degree]))
    # Receivers that differ in effort, as a run's do.
    doublings = np.arange(len(receivers)) % 3 - 1
    receivers = replace(receivers, direct_doublings=doublings, near_doublings=-doublings)
    effort = Effort(log2_chains=5, log2_direct=2, log2_near=3, bound=0.05)
    with ThreadPoolExecutor(workers) as executor:
        return estimate_batch(
            world, receivers, effort=effort, seed=seed, base=base, detail=detail, executor=executor
        )


def test_a_doubled_sequence_is_a_longer_one():
    """Samples from the receivers' side are the same points, one by one; chains differ in their later numbers."""
    world, receivers = nodes_of_room()
    short = Effort(log2_chains=4, log2_direct=3, log2_near=3, bound=0.0)
    longer = replace(short, log2_direct=4, log2_near=4)
    found = [
        estimate_batch(
            world,
            receivers,
            effort=effort,
            seed=(3, 4),
            doubling=doubling,
            base=None,
            detail=None,
            executor=THREADS,
        )
        for effort, doubling in ((short, 0), (short, 1), (longer, 0))
    ]
    mean = found[0].halfway_to(found[1])
    np.testing.assert_allclose(mean.direct, found[2].direct, rtol=EXACT, atol=1e-9)
    np.testing.assert_allclose(mean.indirect, found[2].indirect, rtol=EXACT, atol=1e-9)
    assert not np.allclose(found[0].indirect, found[1].indirect)


@pytest.mark.parametrize("on_base", [False, True])
@pytest.mark.parametrize(
    ("block", "chunk", "workers"), [(1024, 256, 1), (37, 256, 3), (1024, 7, 2), (1, 1000, 2)]
)
def test_blocks_chunks_and_threads_do_not_change_a_bit(monkeypatch, on_base, block, chunk, workers):
    world, receivers = nodes_of_room()
    base = room_base(8.0) if on_base else None
    usual = one_batch(world, receivers, base=base)
    monkeypatch.setattr(batch, "BLOCK", block)
    monkeypatch.setattr(local, "VERTEX_CHUNK", chunk)
    other = one_batch(world, receivers, base=base, workers=workers)
    for name in ("direct", "indirect", "angular"):
        assert np.array_equal(getattr(usual, name), getattr(other, name)), name
    assert (usual.vertices, usual.rays) == (other.vertices, other.rays)
    assert np.any(usual.angular != 0)


def test_nothing_is_estimated_at_hidden_receivers_and_the_same_at_the_others():
    world, receivers = nodes_of_room()
    hidden = np.arange(len(receivers)) % 3 == 0
    usual = one_batch(world, receivers, base=None)
    fewer = one_batch(world, replace(receivers, hidden=hidden), base=None)
    for name, left_out in (
        ("direct", hidden),
        ("indirect", hidden),
        ("angular", hidden[receivers.degrees > 0]),
    ):
        assert not np.any(getattr(fewer, name)[left_out]), name
        assert np.array_equal(getattr(fewer, name)[~left_out], getattr(usual, name)[~left_out]), name
    assert fewer.rays < usual.rays


def test_another_batch_is_another_estimate():
    world, receivers = nodes_of_room()
    one, other = (one_batch(world, receivers, base=None, seed=(3, k)) for k in (4, 5))
    assert not np.any(one.indirect[:, ILLUMINANCE] == other.indirect[:, ILLUMINANCE])


def test_default_bound_is_the_inverse_square_of_four_spacings():
    """600 chains on 6 m²: 0.1 m apart, b = 1 / 0.4²."""
    assert bound_for(6.0, 600.0) == pytest.approx(1 / 0.16, rel=EXACT)


def effort_for(target, *, most_rays=np.inf):
    return shared_out(target=target, most_rays=most_rays)[0]


def shared_out(*, areas=1.0, target=0.02, most_rays=np.inf, receivers=None):
    world, all_nodes = nodes_of_room()
    receivers = receivers or all_nodes
    return choose_effort(
        world,
        receivers,
        base=None,
        areas=np.broadcast_to(areas, len(receivers)),
        target=target,
        most_rays=most_rays,
        batches=12,
        seed=1,
        executor=THREADS,
    )


def test_receivers_that_stand_for_more_sample_more_often():
    """64 times the area, 64 to the power 1/6 = 2 times the samples."""
    count = len(nodes_of_room()[1])
    large = np.arange(count) % 2 == 0
    _, even = shared_out()
    _, uneven = shared_out(areas=np.where(large, 64.0, 1.0))
    more = uneven.near_doublings - even.near_doublings
    assert np.mean(more[large]) - np.mean(more[~large]) == pytest.approx(1.0, abs=0.15)


def every_third_in_two_places(**marked):
    """Efforts and receivers, a third of them without area and marked: where they are, and next to the lamp."""
    receivers = nodes_of_room()[1]
    third = np.arange(len(receivers)) % 3 == 0
    next_to_lamp = np.where(third[:, None], (1.7, 1.2, 2.39), receivers.points)
    marks = {name: mark(third) for name, mark in marked.items()}
    found = [
        shared_out(areas=np.where(third, 0.0, 1.0), receivers=replace(receivers, points=points, **marks))
        for points in (receivers.points, next_to_lamp)
    ]
    for name in ("direct_doublings", "near_doublings"):
        assert np.array_equal(*(getattr(shared, name)[~third] for _, shared in found)), name
    return [effort for effort, _ in found]


def test_hidden_receivers_have_no_say_in_the_effort():
    """Wherever they are, be it next to the lamp."""
    here, there = every_third_in_two_places(hidden=np.asarray)
    assert here == there
    for name in ("variance", "cost"):
        assert np.array_equal(getattr(here, name), getattr(there, name)), name


def test_points_in_space_have_no_say_in_how_nodes_sample():
    """Theirs is another error, and near a lamp a large one."""
    here, there = every_third_in_two_places(on_surface=np.logical_not)
    assert np.array_equal(here.variance, there.variance)


def test_effort_grows_as_the_inverse_square_of_the_target():
    """A quarter of the error takes sixteen times the samples, up to the rounding to powers of two."""
    coarse, fine = effort_for(0.02), effort_for(0.005)
    assert fine.log2_chains - coarse.log2_chains == pytest.approx(4, abs=1)
    assert fine.log2_near - coarse.log2_near == pytest.approx(4, abs=1)
    assert fine.bound == coarse.bound


def test_effort_keeps_to_the_rays_that_a_batch_may_take():
    free, short = effort_for(0.005), effort_for(0.005, most_rays=1e4)
    assert short.log2_chains < free.log2_chains
    assert short.log2_near < free.log2_near


def test_batches_are_larger_where_a_part_would_do_with_less_than_its_least():
    """Four direct samples a batch are far too many here; beside more of the others they weigh less."""
    variance, cost, target = np.array([0.15, 1e-5, 0.025]), np.array([0.8, 3.7, 10.7]), 0.02
    tried = Effort(*LEAST, bound=1.0, variance=variance, cost=cost)
    count, samples = batches_for(tried, target, batches=32.0)
    assert count >= LEAST_REPLICATES
    assert samples[1] == 2.0 ** LEAST[1]
    least = 2.0 ** np.array(LEAST)
    rays = np.sum(variance / least) / target**2 * (least @ cost)
    assert count * (samples @ cost) < 0.95 * rays
    # A part that needs no more than it gets is no reason.
    alike = replace(tried, variance=np.array([0.15, 0.01, 0.025]))
    assert np.array_equal(batches_for(alike, target, batches=32.0)[1], least)


#: What every wall of a closed room may be: black, mirrors only, nearly white, almost a mirror.
EXTREMES = {
    "black": grey("walls", 0.0),
    "no Lambertian lobe": grey("walls", 0.0, specular=0.6, exponent=20.0),
    "mirrors": grey("walls", 0.0, specular=0.6, exponent=1e4),
    "nearly white": grey("walls", 0.95),
    "nearly a mirror": grey("walls", 0.2, specular=0.7, exponent=1e4),
}


@pytest.mark.parametrize("walls", EXTREMES.values(), ids=EXTREMES)
def test_extreme_rooms_give_the_same_light_by_both_estimators(walls):
    """Under a tilted lamp that shines both ways, in whose plane rounding decides what stands above."""
    from lelight.calculation import calculate

    tilted = panel((1.2, 0.9, 1.6), (0.0, 0.8, 0.3), (1.1, 0.0, 0.2))
    glow = grey("lamp", 0.0, luminance=100.0, emission_sides="both")
    scene = lit(box((4.0, 3.0, 2.5)), tilted, materials=[walls, glow])
    means = []
    for estimator in ("base", "emitters"):
        run = calculate(scene, Settings(edge=2.0, batches=10, target=0.1, estimator=estimator))
        for name, column in vars(run.field.values).items():
            assert np.all(np.isfinite(column)), name
        assert not run.field.mesh.hidden.any()
        means.append(np.array(run.replicates.at_nodes) @ run.field.mesh.areas)
    if walls.diffuse.any() or walls.glossy:
        assert same_mean(means[0][:, None], means[1][:, None], relative_error=0.06)
    else:
        # Light comes straight from the lamp, and neither chains nor base have any part in it.
        np.testing.assert_allclose(means[0], means[1], rtol=EXACT)


@pytest.mark.parametrize("estimator", ["base", "emitters"])
def test_the_whole_run_gives_the_same_field_on_one_thread_and_on_three(estimator):
    from lelight.calculation import calculate

    fields = [
        calculate(
            glossy_room(0.4, 0.3, 30.0),
            Settings(edge=1.5, batches=2, target=0.1, threads=threads, estimator=estimator),
        ).field
        for threads in (1, 3)
    ]
    for name, column in vars(fields[0].values).items():
        assert np.array_equal(column, getattr(fields[1].values, name)), name
    assert luminance_weighted(fields[0].values.illuminance).min() > 0
