"""Leaving out is harmless: what the plan spares changes no result beyond its error, whatever is forced on."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from commandline import QUICK as QUICK_OPTIONS
from commandline import ROOM_TOML, lelight, write_room
from rooms import grey, lamp, lit, panel
from shapes import box
from verdicts import agrees, same_mean

from lelight.calculation import calculate
from lelight.scene import Material, Observer, Scene
from lelight.settings import Settings
from lelight.storeddegree import lobe_degree

QUICK = Settings(edge=0.8, target=0.1, batches=8, threads=2)
#: Bits that sums of three channels lose against one.
ROUNDING = 1e-9
#: Standard errors of nodes above which a verdict would have no power.
TELLING = 0.5


def office(diffuse: float = 0.6, **others) -> Scene:
    """A grey room with a table, under a panel."""
    shapes = (
        box((4.0, 3.0, 2.5)),
        panel((1.0, 1.0, 0.7), (1.5, 0.0, 0.0), (0.0, 1.0, 0.0)),
        panel((1.2, 0.9, 2.4), (0.0, 0.8, 0.0), (1.1, 0.0, 0.0)),
    )
    table = grey("table", diffuse, **others)
    return lit(*shapes, materials=[grey("walls", diffuse), table, grey("lamp", diffuse, luminance=100.0)])


def closed_box(name: str, inside: Material) -> Scene:
    """A room with a closed box in it whose inside is of a material that light does not reach."""
    corners, faces = box((0.8, 0.8, 0.8))
    outer = corners + 0.5, faces[:, ::-1]
    inner = 0.9 * corners + 0.54, faces
    materials = [grey("walls", 0.6), grey("outside", 0.5), replace(inside, name=name)]
    shapes = box((4.0, 3.0, 2.5)), outer, inner
    return lit(*shapes, materials=materials, luminaires=(lamp((2.5, 1.5, 2.0)),))


def found(scene: Scene, **asked):
    return calculate(scene, replace(QUICK, **asked))


def visible(run):
    return run.replicates.at_nodes[:, ~run.field.mesh.hidden]


def surface_means(run):
    """Mean illuminance (R, n_materials) over the surfaces of each material, by replicate."""
    mesh, light = run.field.mesh, run.replicates.at_nodes
    own = [(mesh.materials == m) & ~mesh.hidden for m in range(len(run.scene.materials))]
    return np.stack([np.average(light[:, each], axis=1, weights=mesh.areas[each]) for each in own], axis=1)


@pytest.fixture(scope="module")
def spared():
    return found(office())


@pytest.mark.parametrize("asked", [{"colour": "rgb"}, {"colour": "bands"}, {"degree": 11}])
def test_colour_and_harmonics_change_nothing_in_a_grey_diffuse_room(spared, asked):
    forced = found(office(), **asked)
    assert forced.plan.channels * (forced.plan.degree + 1) > 1
    assert np.allclose(forced.field.illuminance, spared.field.illuminance, rtol=ROUNDING, atol=0.0)
    assert forced.error.rms == pytest.approx(spared.error.rms, rel=ROUNDING)
    stored, number = forced.field.values.radiance_sh, spared.field.values.radiance_sh
    assert np.allclose(stored[:, 0], number[:, 0], rtol=1e-6)
    # Harmonics of a Lambertian node say no more than its one number.
    assert not stored[:, 1:].any()


def test_nodes_on_dark_sides_change_nothing_on_lit_ones(spared):
    forced = found(office(), sides="both", seed=1)
    both, one = forced.field.mesh, spared.field.mesh
    lit_sides = set(zip(one.patches.tolist(), one.sides.tolist(), strict=True))
    same = np.array(
        [pair in lit_sides for pair in zip(both.patches.tolist(), both.sides.tolist(), strict=True)]
    )
    assert len(both) > 1.5 * len(one)
    assert np.array_equal(both.vertices[same], one.vertices)
    assert both.hidden[~same].all()
    seen = ~one.hidden
    assert same_mean(forced.replicates.at_nodes[:, same][:, seen], visible(spared), relative_error=TELLING)
    assert same_mean(surface_means(forced), surface_means(spared), relative_error=0.1)


def test_the_same_comparison_tells_a_room_of_other_walls_apart(spared):
    other = found(office(0.7), seed=1)
    assert not same_mean(surface_means(other), surface_means(spared), relative_error=0.1)


def test_a_black_scene_follows_direct_light_only_and_loses_nothing():
    spared, forced = found(office(0.0)), found(office(0.0), indirect=True, seed=1)
    assert (spared.plan.indirect, forced.plan.indirect) == (False, True)
    # One ray a sample of the near field is what looking for reflected light costs.
    assert 0 < spared.replicates.rays < 0.9 * forced.replicates.rays
    assert not spared.replicates.indirect.any()
    assert not forced.replicates.indirect.any()
    # What the base saw of the lamp tells the one run where light comes straight, and not the other.
    noisy = np.maximum(*(run.replicates.std_error[: len(run.field.mesh)] for run in (spared, forced))) > 1e-9
    assert np.allclose(
        spared.field.illuminance[~noisy], forced.field.illuminance[~noisy], rtol=1e-6, atol=1e-6
    )
    one, other = (run.replicates.at_nodes[:, noisy] for run in (spared, forced))
    bright = one.mean(axis=0) > 1.0
    assert bright.sum() > 5 and (~noisy).sum() > 5
    assert same_mean(one[:, bright], other[:, bright], relative_error=TELLING)


@pytest.mark.parametrize(
    "inside",
    [Material("", np.array([0.7, 0.4, 0.2])), grey("", 0.3, specular=0.2, exponent=64.0)],
    ids=["coloured", "glossy"],
)
def test_what_light_does_not_reach_is_left_out_and_loses_nothing(inside):
    scene = closed_box("inside", inside)
    spared, forced = found(scene), found(scene, colour="rgb", degree=11)
    assert (spared.plan.channels, spared.plan.degree) == (1, 0)
    assert (forced.plan.channels, forced.plan.degree) == (3, 11)
    assert np.allclose(forced.field.illuminance, spared.field.illuminance, rtol=ROUNDING, atol=0.0)


def test_a_glossy_floor_under_a_carpet_keeps_no_harmonics():
    floor = grey("floor", 0.3, specular=0.2, exponent=64.0)
    low, high = box((4.0, 3.0, 2.5)), box((4.0, 3.0, 0.01))
    carpet = high[0], high[1][:, ::-1]
    # Its first rectangle is the floor.
    room = low[0], np.delete(low[1], [0, 1], axis=0)
    ground = low[0], low[1][[0, 1]]
    materials = [grey("walls", 0.6), floor, grey("carpet", 0.4)]
    scene = lit(room, ground, carpet, materials=materials, luminaires=(lamp((2.0, 1.5, 2.0)),))
    run = found(scene, batches=2)
    assert run.plan.degree == 0
    assert set(run.field.mesh.materials) == {0, 2}
    bare = lit(room, ground, materials=materials[:2], luminaires=scene.luminaires)
    assert found(bare, batches=2).plan.degree == lobe_degree(64.0)


def test_a_lamp_without_flux_is_left_out_and_loses_nothing():
    dark = lamp((0.7, 0.7, 1.5), intensity=0.0, name="off")
    scene = replace(office(), luminaires=(dark,))
    spared, forced = found(scene, seed=1), found(scene, emitters="all")
    assert (len(spared.scene.luminaires), len(forced.scene.luminaires)) == (0, 1)
    # It made a node mesh of its own, so only what both have can be compared.
    assert same_mean(surface_means(spared), surface_means(forced), relative_error=0.1)


def test_exponent_1_and_a_hair_more_give_the_same_light():
    runs = [found(office(0.3, specular=0.3, exponent=n)) for n in (1.0, 1.0001)]
    assert runs[0].plan.degree == runs[1].plan.degree == 15
    # By a hair a path may take another turn, so that single nodes differ by a little of their noise.
    off = np.abs(runs[0].field.illuminance - runs[1].field.illuminance)
    assert np.all(off <= 0.1 * runs[0].field.std_error)
    np.testing.assert_allclose(*(surface_means(run).mean(axis=0) for run in runs), rtol=1e-4)


def watched(position: tuple[float, float, float], exponent: float = 40.0) -> Scene:
    """A room with a glossy screen across it, an observer on one side."""
    shapes = (
        box((4.0, 3.0, 2.5)),
        panel((2.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 2.0)),
        panel((1.2, 0.9, 2.4), (0.0, 0.8, 0.0), (1.1, 0.0, 0.0)),
    )
    materials = [
        grey("walls", 0.6),
        grey("screen", 0.2, specular=0.4, exponent=exponent),
        grey("lamp", 0.5, luminance=100.0),
    ]
    eye = Observer("eye", np.array(position), np.array([-1.0, 0.0, 0.0]))
    return replace(lit(*shapes, materials=materials), observers=(eye,))


def test_sides_that_no_observer_sees_keep_no_angular_detail_and_still_look_right():
    scene = watched((3.5, 1.5, 1.2))
    points = np.stack(np.meshgrid([2.0], [0.7, 1.1, 1.5, 1.9, 2.3], [0.6, 1.0, 1.4]), axis=-1).reshape(-1, 3)
    toward = np.array([[-0.8, 0.5, 0.3], [-0.9, -0.4, 0.1]])
    ratios = []
    for seed in range(8):
        spared, forced = found(scene, seed=seed), found(scene, seed=seed, angular="all")
        assert np.array_equal(spared.field.illuminance, forced.field.illuminance)
        for d in toward:
            reflected, stored = (
                run.field.radiance(points, np.tile(d, (len(points), 1))).mean() for run in (spared, forced)
            )
            ratios.append([reflected / stored])
    screen = spared.field.mesh.materials == 1
    front = spared.field.mesh.sides[screen] > 0
    assert np.array_equal(spared.field.values.sh_degree[screen] > 0, front)
    assert (forced.field.values.sh_degree[screen] > 0).all()
    assert agrees(np.array(ratios), 1.0, relative_error=0.05)
    assert not agrees(np.array(ratios), 1.3, relative_error=0.05)


def test_lobes_too_sharp_for_the_nodes_look_the_same_where_they_are_stored():
    scene = watched((3.5, 1.5, 1.2), exponent=300.0)
    across = np.meshgrid([2.0], np.linspace(0.3, 2.7, 6), np.linspace(0.3, 1.7, 4))
    points = np.stack(across, axis=-1).reshape(-1, 3)
    toward = np.array([[-0.8, 0.5, 0.3], [-0.9, -0.4, 0.1], [-0.8, 0.2, -0.5], [-0.9, -0.3, -0.4]])
    places, directions = np.tile(points, (4, 1)), np.repeat(toward, len(points), axis=0)
    reflected, stored = [], []
    for seed in range(8):
        asked = {"edge": 0.5, "target": 0.03, "seed": seed}
        spared, forced = found(scene, **asked), found(scene, mirrors="stored", angular="all", **asked)
        assert (spared.plan.degree, forced.plan.degree) == (0, lobe_degree(300.0, sharp=True))
        assert np.array_equal(spared.field.illuminance, forced.field.illuminance)
        reflected.append([spared.field.radiance(places, directions).mean()])
        stored.append([forced.field.radiance(places, directions).mean()])
    one, other = np.array(reflected), np.array(stored)
    assert same_mean(one, other, relative_error=0.05)
    assert not same_mean(1.3 * one, other, relative_error=0.05)


def test_a_mirror_may_show_any_side():
    scene = watched((3.5, 1.5, 1.2))
    mirror = replace(scene.materials[0], specular=np.full(3, 0.3), exponent=1e4)
    run = found(replace(scene, materials=(mirror, *scene.materials[1:])), batches=2)
    assert (run.field.values.sh_degree[run.field.mesh.materials == 1] > 0).all()


def test_pictures_can_be_left_out_and_the_rest_stays_the_same(run, tmp_path):
    scene = write_room(tmp_path, toml=f"{ROOM_TOML}\n[calc]\npictures = false\n")
    outcome = lelight("calc", scene, *QUICK_OPTIONS, "--threads", "2")
    assert outcome.status == 0, outcome.stderr
    out = tmp_path / "room.lelight"
    assert list((out / "observers").iterdir()) == []
    with_pictures, without = (
        json.loads((folder / "metrics.json").read_text(encoding="utf-8")) for folder in (run.out, out)
    )
    assert with_pictures["observers"]
    assert not without["observers"]
    assert without["planes"] == with_pictures["planes"]
    assert (out / "field.vtp").stat().st_size > 0
