"""Scenes at the edge of what there is: a right answer, known from outside the program, or one clear line.

Right answers are closed forms (furnaces: E = M / (1 - rho) at every node of whatever shape), the ordinary case
scaled, the balance of energy in a closed room, and the path tracer of the tests. Single nodes are t-tests over
a run's own batches with Šidák's correction, as everywhere.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pathtracer import PathTracer
from rooms import UNIT_EXITANCE, furnace, glossy_room, grey, lamp, lit, panel
from shapes import box, placed, scene_of, soup
from verdicts import agrees, critical_t, same_mean

from lelight.calculation import Calculation, calculate
from lelight.errors import SceneError
from lelight.estimate import defect, effort
from lelight.estimate.angular import HarmonicDetail
from lelight.estimate.local import Arrivals
from lelight.harmonics.synthesis import synthesise_at
from lelight.harmonics.zonal import degree_for, reflected
from lelight.reading.loading import load
from lelight.receivers import space_receivers, with_surface
from lelight.scene import BoolArray, FloatArray, Material, PointLuminaire, Scene, triangle_areas
from lelight.settings import Settings
from lelight.tracing.chains import emission_chains
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import build_world

RHO = 0.6
#: Deterministic results agree to this share.
EXACT = 1e-9
#: Standard error of a single node, and of the mean over many, that a verdict may rest on.
OF_NODE, OF_MEAN = 0.25, 0.02
#: The bar on random scenes: how many of them; 10 000 were run once.
RANDOM_SCENES = int(os.environ.get("LELIGHT_RANDOM_SCENES", "200"))


def run(scene: Scene, *, edge: float | None = None, batches: int = 10, **others) -> Calculation:
    """A small calculation: some hundred nodes, batches of the least size unless a target is given."""
    chosen = {"edge": edge or scene.diagonal / 5, "batches": batches, "target": 0.3, "threads": 2} | others
    return calculate(scene, Settings(**chosen))


@contextmanager
def few_trials() -> Iterator[None]:
    """Let slow scenes try less beforehand: trials only choose the effort, here the least anyway."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(effort, "TRIALS", 2)
        patch.setattr(effort, "CHAIN_TRIALS", 4)
        patch.setattr(defect, "LOG2_DEFECT_RAYS", 3)
        yield


def at_nodes(made: Calculation, chosen: BoolArray | None = None) -> FloatArray:
    """Illuminance (batches, k) of the visible nodes, or of some of them."""
    visible = ~made.field.mesh.hidden
    return np.array(made.replicates.at_nodes)[:, visible if chosen is None else visible & chosen]


def mean(made: Calculation, chosen: BoolArray | None = None) -> FloatArray:
    """Area mean (batches, 1) over the visible nodes, or over some of them."""
    mesh = made.field.mesh
    own = ~mesh.hidden if chosen is None else ~mesh.hidden & chosen
    return np.average(np.array(made.replicates.at_nodes)[:, own], axis=1, weights=mesh.areas[own])[:, None]


def agrees_as_stated(made: Calculation, exact: float, chosen: BoolArray) -> bool:
    """Say whether some nodes have a closed form's value within the errors that the run states of them.

    What hardly any ray of a node has met, such as a source that the base found dark there, is not in the spread of its
    own replicates, but in that of its neighbours.
    """
    error = made.field.std_error[chosen]
    assert np.all(error < OF_NODE * exact)
    t = np.abs(made.replicates.mean[: len(chosen)][chosen] - exact) / error
    return bool(np.all(t <= critical_t(made.replicates.count - 1.0, len(t))))


def holds_everywhere(made: Calculation, exact: float) -> bool:
    """Say whether all nodes and their mean agree with a furnace's closed form."""
    return agrees(at_nodes(made), exact, relative_error=OF_NODE) and agrees(
        mean(made), exact, relative_error=OF_MEAN
    )


def moved(scene: Scene, *, scale: float = 1.0, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Scene:
    return replace(scene, vertices=placed((scene.vertices, scene.triangles), scale=scale, shift=shift)[0])


@cache
def ordinary() -> Calculation:
    return run(furnace(RHO))


@pytest.mark.parametrize("reflectance", [0.5, 0.9, 0.98])
def test_albedo(reflectance: float) -> None:
    """Closed form: the furnace."""
    with few_trials():
        made = run(furnace(reflectance))
    assert holds_everywhere(made, 1.0 / (1.0 - reflectance))
    assert not agrees(mean(made), 1.1 / (1.0 - reflectance), relative_error=OF_MEAN)


def test_albedo_0995() -> None:
    """Closed form; four fifths of the light have been reflected more than forty times."""
    with few_trials():
        made = run(furnace(0.995), edge=1.0, batches=6)
    assert agrees(mean(made), 200.0, relative_error=0.05)
    assert made.error.rms < 0.3


def test_albedo_0_leaves_direct_light_without_noise() -> None:
    made = run(furnace(0.0))
    np.testing.assert_allclose(made.field.illuminance, 1.0, rtol=EXACT)
    assert made.error.rms < EXACT


@pytest.mark.parametrize("reflectance", [1.0, 0.9995])
def test_a_closed_room_that_absorbs_nothing_is_refused(reflectance: float) -> None:
    with pytest.raises(SceneError, match="lower the reflectances"):
        run(furnace(reflectance))


@pytest.mark.parametrize("scale", [2.0**-10, 2.0**13], ids=["room of 1 mm", "room of 8 km"])
def test_scale_does_not_matter(scale: float) -> None:
    """Scale invariance: powers of two do not round, so the same random numbers give the same light."""
    np.testing.assert_allclose(
        run(moved(furnace(RHO), scale=scale)).field.illuminance, ordinary().field.illuminance, rtol=EXACT
    )


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e4])
def test_map_coordinates(scale: float) -> None:
    """Closed form; a room of a millimetre out there has lost all but six digits."""
    assert holds_everywhere(run(moved(furnace(RHO), scale=scale, shift=(5e5, 5e6, 120.0))), 1 / (1 - RHO))


def test_a_millimetre_room_read_from_a_file(tmp_path: Path) -> None:
    """Unit declared or not, the light is the same; the closed form and the ordinary case both say so."""
    vertices, triangles = box((1.0, 1.0, 1.0))
    lines = ["usemtl walls", *("v " + " ".join(map(str, v)) for v in vertices)]
    lines += ["f " + " ".join(map(str, t + 1)) for t in triangles]
    found = []
    for name, unit in (("a", "m"), ("b", "mm")):
        (tmp_path / f"{name}.obj").write_text("\n".join(lines))
        toml = (
            f'unit = "{unit}"\n[materials]\nwalls = {{ reflectance = 0.6, luminance = {UNIT_EXITANCE!r} }}\n'
        )
        (tmp_path / f"{name}.toml").write_text(toml)
        found.append(run(load(tmp_path / f"{name}.toml")).field.illuminance)
    np.testing.assert_allclose(found[1], found[0], rtol=0.2)
    assert abs(found[1].mean() / found[0].mean() - 1.0) < 1e-3


@pytest.mark.parametrize("luminance", [1e-6, 1e9])
def test_luminance(luminance: float) -> None:
    """Scale invariance in light."""
    scene = furnace(RHO)
    bright = replace(scene, materials=(replace(scene.materials[0], luminance=np.full(3, luminance)),))
    expected = ordinary().field.illuminance * (luminance / UNIT_EXITANCE)
    np.testing.assert_allclose(run(bright).field.illuminance, expected, rtol=EXACT)


def test_a_gap_of_1_mm() -> None:
    """Closed form."""
    assert holds_everywhere(run(furnace(RHO, (4.0, 3.0, 1e-3)), edge=1.0, target=0.05), 1 / (1 - RHO))


def test_a_shaft_of_1_mm() -> None:
    """Closed form, for the mean: light that comes a long way along the shaft is rare at single nodes."""
    made = run(furnace(RHO, (1e-3, 1e-3, 4.0)), edge=1.0, target=0.05)
    assert agrees(mean(made), 1 / (1 - RHO), relative_error=OF_MEAN)
    np.testing.assert_array_less(np.abs(at_nodes(made).mean(axis=0) * (1 - RHO) - 1.0), OF_NODE)


def test_a_gap_that_rays_jump_over_is_refused() -> None:
    with pytest.raises(SceneError, match="rays cannot tell apart"):
        run(furnace(RHO, (4.0, 3.0, 1e-6)))


def needles(aspect: float) -> Scene:
    """The furnace with every triangle parted in one of nearly all of it and a needle."""
    scene = furnace(RHO)
    vertices, triangles = list(scene.vertices), []
    for a, b, c in scene.triangles:
        vertices.append(scene.vertices[a] + (scene.vertices[c] - scene.vertices[a]) / aspect)
        triangles += [(a, b, len(vertices) - 1), (len(vertices) - 1, b, c)]
    made = scene_of((np.array(vertices), np.array(triangles)))
    return replace(made, materials=scene.materials)


@pytest.mark.parametrize("aspect", [1e3, 1e6])
def test_needle_triangles(aspect: float) -> None:
    """Closed form."""
    assert holds_everywhere(run(needles(aspect)), 1 / (1 - RHO))


def test_triangles_of_sizes_a_million_to_one() -> None:
    """Closed form: furnaces inside a furnace, 10 m to 10 µm."""
    shapes, walls = [box((10.0, 10.0, 3.0))], [grey("walls", 0.5, luminance=UNIT_EXITANCE)]
    for k, size in enumerate((1e-1, 1e-3, 1e-5)):
        shapes.append(placed(box((1.0, 1.0, 1.0)), scale=size, shift=(2.0 + k, 5.0, 1.0)))
        walls.append(grey(f"box {k}", 0.5, luminance=UNIT_EXITANCE, emission_sides="both"))
    assert holds_everywhere(run(lit(*shapes, materials=walls), edge=4.0), 2.0)


def doubled(scene: Scene, *, flipped: bool = False) -> Scene:
    again = scene.triangles[:, ::-1] if flipped else scene.triangles
    return replace(
        scene,
        triangles=np.concatenate([scene.triangles, again]),
        triangle_materials=np.tile(scene.triangle_materials, 2),
    )


def test_faces_written_twice_are_one() -> None:
    np.testing.assert_array_equal(run(doubled(furnace(RHO))).field.illuminance, ordinary().field.illuminance)
    thrice = lit(*[soup(box((1.0, 1.0, 1.0)))] * 3, materials=[furnace(RHO).materials[0]] * 3)
    assert holds_everywhere(run(thrice), 1 / (1 - RHO))


def test_faces_back_to_back_are_the_two_sides_of_a_sheet() -> None:
    """Closed form: two furnaces of other walls, divided by nothing but their coincident faces."""
    rooms = [box((1.0, 1.0, 1.0)), placed(box((1.0, 1.0, 1.0)), shift=(1.0, 0.0, 0.0))]
    walls = [grey("light", 0.8, luminance=UNIT_EXITANCE), grey("dark", 0.2, luminance=UNIT_EXITANCE)]
    made = run(lit(*rooms, materials=walls), target=0.02, batches=16)
    for number, exact in ((0, 5.0), (1, 1.25)):
        own = (made.field.mesh.materials == number) & (made.field.mesh.sides > 0)
        assert agrees_as_stated(made, exact, own & ~made.field.mesh.hidden)
        assert agrees(mean(made, own), exact, relative_error=OF_MEAN)
    assert holds_everywhere(run(doubled(furnace(RHO), flipped=True)), 1 / (1 - RHO))


def test_coplanar_emitters_that_overlap_are_refused() -> None:
    corners = furnace(RHO)
    quads = corners.triangles.reshape(-1, 2, 3)
    a, b, c, d = quads[:, 0, 0], quads[:, 0, 1], quads[:, 0, 2], quads[:, 1, 2]
    other = np.concatenate([np.stack([b, c, d], axis=1), np.stack([b, d, a], axis=1)])
    twice = replace(
        corners,
        triangles=np.concatenate([corners.triangles, other]),
        triangle_materials=np.zeros(4 * len(quads), dtype=np.int64),
    )
    with pytest.raises(SceneError, match="leave one of them out"):
        run(twice)


def test_a_two_sided_wall_without_thickness() -> None:
    """Closed form: a furnace divided by one sheet that emits both ways."""
    sheet = grey("sheet", RHO, luminance=UNIT_EXITANCE, emission_sides="both")
    walls = grey("walls", RHO, luminance=UNIT_EXITANCE)
    divided = lit(box((2.0, 1.0, 1.0)), panel((1, 0, 0), (0, 1, 0), (0, 0, 1)), materials=[walls, sheet])
    assert holds_everywhere(run(divided), 1 / (1 - RHO))


def test_no_light_leaks_through_a_wall_without_thickness() -> None:
    dark = lit(
        box((2.0, 1.0, 1.0)),
        panel((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        materials=[grey("walls", RHO), grey("sheet", RHO)],
        luminaires=(lamp((0.5, 0.5, 0.5)),),
    )
    field = run(dark).field
    behind = (field.mesh.positions[:, 0] > 1.0 + EXACT) | (
        (field.mesh.positions[:, 0] > 1.0 - EXACT) & (field.mesh.normals[:, 0] > 0.5)
    )
    assert behind.any()
    assert not field.illuminance[behind].any()
    assert (field.illuminance[~behind] > 0.0).mean() > 0.9


def test_a_single_triangle() -> None:
    """Closed form: I cos / r³ at every node, without noise."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    alone = lit(
        (corners, np.array([[0, 1, 2]])), materials=[grey("t", 0.5)], luminaires=(lamp((0.3, 0.3, 1.0)),)
    )
    field = run(alone).field
    ray = np.array([0.3, 0.3, 1.0]) - field.mesh.positions
    np.testing.assert_allclose(field.illuminance, 100.0 / np.linalg.norm(ray, axis=1) ** 3, rtol=EXACT)
    shining = replace(alone, materials=(grey("t", 0.5, luminance=1.0),), luminaires=())
    for asked in ({}, {"sides": "both"}, {"sides": "both", "adaptive": True}):
        with pytest.raises(SceneError, match="no surface receives light"):
            run(shining, **asked)


@pytest.mark.parametrize("width", [4e-3, 1e-3])
def test_a_node_that_sees_light_through_a_slit(width: float) -> None:
    """Closed form: light of 1 cd/m² through a slit as wide as a pixel, on a black wall 1 m behind."""
    rest = 0.5 - width / 2
    screens = panel((1, 0, 0), (0, 1, 0), (0, 0, rest)), panel((1, 0, 1 - rest), (0, 1, 0), (0, 0, rest))
    shapes = (box((2.0, 1.0, 1.0)), *screens, panel((1e-3, 0, 0), (0, 1, 0), (0, 0, 1)))
    black = [grey(f"black {k}", 0.0) for k in range(3)]
    made = run(
        lit(*shapes, materials=[*black, grey("lamp", 0.0, luminance=1.0)]), edge=0.25, batches=40, target=0.05
    )
    mesh = made.field.mesh
    far = (mesh.positions[:, 0] > 2.0 - EXACT) & (np.abs(mesh.positions[:, 2] - 0.5) < EXACT) & ~mesh.hidden
    assert far.sum() >= 4
    across = (np.arange(2000) + 0.5) / 2000
    exact = []
    for y in mesh.positions[far, 1]:
        lamp_y = y + (across - y) * 1.999
        seen = (lamp_y > 0.0) & (lamp_y < 1.0)
        exact.append(width * np.mean(seen / (1.0 + (across - y) ** 2) ** 2))
    found = at_nodes(made, far)
    assert agrees(found.mean(axis=1)[:, None], np.mean(exact), relative_error=0.25)


def near_the_ceiling(height: float) -> Scene:
    under = (2.03, 1.47, 2.5 - height)
    return lit(box((4.0, 3.0, 2.5)), materials=[grey("walls", 0.5)], luminaires=(lamp(under),))


@pytest.mark.parametrize("height", [1e-2, 1e-4])
def test_a_point_lamp_close_to_a_wall(height: float) -> None:
    """Energy: all surfaces together receive flux / (1 - rho), here by quadrature over the nodes, good to 5 %."""
    made = run(near_the_ceiling(height), edge=0.7)
    mesh = made.field.mesh
    received = np.array(made.replicates.at_nodes) @ mesh.areas * 0.5 / (400.0 * math.pi)
    assert abs(received.mean() - 1.0) < 0.05
    # The spot sends half of what it gets down again: chains from the lamp, counted where they meet the floor, say so.
    fine = run(near_the_ceiling(height), edge=0.2, batches=16)
    floor = fine.field.mesh.positions[:, 2] < EXACT
    counted = met_on_floor(near_the_ceiling(height)) / 12.0
    assert same_mean(mean(fine, floor), counted, relative_error=0.01)
    assert not same_mean(mean(fine, floor), 1.04 * counted, relative_error=0.01)


def met_on_floor(scene: Scene) -> FloatArray:
    """Flux (batches, 1) in lm that chains from the emitters bring to z = 0."""
    world = build_world(scene, 1)
    batches = [emission_chains(world, Stretch.of(12), seed=(k,)) for k in range(24)]
    return np.array([[each.flux[each.points[:, 2] < 1e-4].sum()] for each in batches])


def test_a_luminous_face_01_mm_from_a_wall() -> None:
    """The path tracer of the tests, at the nodes of floor and walls."""
    shapes = box((4.0, 3.0, 2.5)), panel((1.7, 1.2, 2.4999), (0.0, 0.6, 0.0), (0.6, 0.0, 0.0))
    scene = lit(*shapes, materials=[grey("walls", 0.5), grey("lamp", 0.5, luminance=100.0)])
    made = run(scene, edge=1.0, batches=48, target=0.05)
    below = made.field.mesh.positions[:, 2] < 2.4
    assert agrees_with_tracer(scene, made, below, nodes=40, paths=4096)


def agrees_with_tracer(
    scene: Scene, made: Calculation, asked: BoolArray | bool = True, *, nodes: int, paths: int
) -> bool:
    """Welch's t-test at every chosen node, Šidák over them, the tracer's paths averaged in 32 groups."""
    mesh = made.field.mesh
    open_to_light = np.flatnonzero(~mesh.hidden & asked)
    chosen = np.random.default_rng(5).choice(open_to_light, min(nodes, len(open_to_light)), replace=False)
    traced = PathTracer(scene, seed=6).illuminance(mesh.positions[chosen], mesh.normals[chosen], paths=paths)
    groups = traced[..., 0].reshape(len(chosen), 32, -1).mean(axis=2).T
    found = np.array(made.replicates.at_nodes)[:, chosen]
    each = same_mean(found, groups, relative_error=OF_NODE)
    together = same_mean(found.mean(axis=1)[:, None], groups.mean(axis=1)[:, None], relative_error=OF_MEAN)
    return each and together


@cache
def room_of_gloss(exponent: float, estimator: str = "base") -> Calculation:
    return run(glossy_room(0.4, 0.3, exponent), edge=1.2, batches=16, target=0.06, estimator=estimator)


def test_walls_of_exponent_500_against_the_path_tracer() -> None:
    """Chain vertices with a Phong lobe of this sharpness are spikes; bounded, they neither bias nor scatter."""
    scene = glossy_room(0.4, 0.3, 500.0)
    made = run(scene, edge=1.2, batches=32, target=0.03)
    assert agrees_with_tracer(scene, made, nodes=60, paths=8192)
    assert not agrees_with_tracer(glossy_room(0.4, 0.36, 500.0), made, nodes=60, paths=8192)


def test_spikes_of_exponent_500_are_bounded() -> None:
    """Finite variance: the spread does not grow as batches are added, nor does one batch make it all."""
    room = run(glossy_room(0.4, 0.3, 500.0), edge=2.5, batches=64)
    light = at_nodes(room)
    deviation = (light - light.mean(axis=0)) ** 2
    few, many = deviation[:24].mean(), deviation[24:].mean()
    assert 0.4 < few / many < 2.5
    assert deviation.mean(axis=1).max() < 0.25 * deviation.mean(axis=1).sum()


@pytest.mark.parametrize("exponent", [0.0, 1.0, 500.0, 1e5])
def test_exponents(exponent: float) -> None:
    """Two estimators that share neither chains nor near field."""
    one, other = room_of_gloss(exponent), room_of_gloss(exponent, "emitters")
    for column in vars(one.field.values).values():
        assert np.all(np.isfinite(column))
    assert same_mean(mean(one), mean(other), relative_error=OF_MEAN)


@pytest.mark.parametrize(("kd", "ks", "exponent"), [(1.0, 0.0, 1.0), (0.3, 0.7, 10.0), (0.0, 1.0, 1e5)])
def test_kd_and_ks_of_exactly_1(kd: float, ks: float, exponent: float) -> None:
    """Two estimators; energy: the walls absorb all that they emit, less what a lobe loses below its horizon."""
    vertices, triangles = box((1.0, 1.0, 1.0))
    walls = np.array([t for t in triangles if vertices[t][:, 2].any()])
    scene = lit(
        (vertices, walls),
        panel((0, 0, 0), (1, 0, 0), (0, 1, 0)),
        materials=[
            grey("walls", 0.5, luminance=UNIT_EXITANCE),
            grey("floor", kd, specular=ks, exponent=exponent),
        ],
    )
    one, other = (run(scene, target=0.1, estimator=name, batches=16) for name in ("base", "emitters"))
    assert same_mean(mean(one), mean(other), relative_error=OF_MEAN)
    on_walls = mean(one, one.field.mesh.materials == 0)
    if ks == 0.0:
        # 5 m² of walls emit 1 lm/m² and absorb half of what they receive.
        assert agrees(on_walls, 2.0, relative_error=OF_MEAN)
    else:
        assert on_walls.mean() < 2.0


@pytest.mark.parametrize("exponent", [1.0, 16.0, 256.0, 1778.0])
@pytest.mark.parametrize("degree", [0, 1, 2, 48, 128])
def test_harmonics_of_any_degree(degree: int, exponent: float) -> None:
    """Closed form: one beam reflected by a Phong lobe, (n + 2) / (2 pi) cos^n; nothing but truncation is lost."""
    receivers = with_surface(space_receivers(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])))
    receivers = replace(receivers, frames_x=np.array([[1.0, 0.0, 0.0]]), degrees=np.array([degree]))
    toward = np.array([[0.6, 0.0, 0.8]])
    beam = Arrivals(np.array([0]), toward, np.array([[1.25]]))  # 1 lx
    kept = HarmonicDetail(degree, 1, np.array([degree])).collect(receivers, (beam,))
    lobes = reflected(kept, np.array([[1.0]]), diffuse=np.zeros(1), specular=np.ones(1), exponent=exponent)
    assert lobes[0, 0, 0] == pytest.approx((exponent + 2) / (exponent + 1) / math.sqrt(4 * math.pi), rel=1e-6)
    angle = np.linspace(-0.5, 1.4, 60)
    eyes = np.stack([-np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    count = len(eyes)
    seen = synthesise_at(
        np.repeat(lobes, count, axis=0).astype(np.float32),
        degree,
        np.arange(count)[:, None],
        np.ones((count, 1)),
        np.ascontiguousarray(eyes[:, None]),
    )[:, 0]
    peak = (exponent + 2) / (2 * math.pi)
    exact = peak * np.maximum(eyes @ [-0.6, 0.0, 0.8], 0.0) ** exponent
    assert np.all(np.isfinite(seen))
    assert np.max(np.abs(seen - exact)) <= 1.2 * peak
    if exponent >= 2 and degree >= degree_for(exponent):
        assert np.max(np.abs(seen - exact)) < 0.011 * peak


colours = st.sampled_from([0.0, 0.3, 0.9, 1.0])


@st.composite
def random_scenes(draw: st.DrawFn) -> Scene:
    """1 to 30 random triangles of random materials: open or closed, crossing, tiny, coplanar, repeated."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(1, 30))
    corners = rng.uniform(-1.0, 1.0, (count, 3, 3))
    if draw(st.booleans()):
        corners[:, 1:] = corners[:, :1] + (corners[:, 1:] - corners[:, :1]) * 10.0 ** rng.uniform(
            -3, 0, (count, 1, 1)
        )
    if draw(st.integers(0, 3)) == 0:
        corners = np.round(corners)
    solid = 2 * triangle_areas(corners) > 1e-9
    corners = corners[solid] if solid.any() else np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    materials = []
    for number in range(draw(st.integers(1, 3))):
        kd = draw(colours) * rng.random()
        ks = (1.0 - kd) * draw(colours) * rng.random()
        luminance = draw(st.sampled_from([0.0, 1e-6, 1.0, 1e9]))
        tint = rng.random(3) if draw(st.booleans()) else np.ones(3)
        sides = draw(st.sampled_from(["front", "both"]))
        exponent = 10.0 ** rng.uniform(-1, 5)
        materials.append(Material(f"m{number}", kd * tint, ks * tint, exponent, np.full(3, luminance), sides))
    lamps = tuple(
        PointLuminaire(f"lamp {k}", rng.uniform(-1.0, 1.0, 3), np.full(3, 10.0))
        for k in range(draw(st.integers(0, 2)))
    )
    own = rng.integers(0, len(materials), len(corners))
    used, own = np.unique(own, return_inverse=True)
    return Scene(
        "random",
        corners.reshape(-1, 3),
        np.arange(3 * len(corners)).reshape(-1, 3),
        own.astype(np.int64),
        tuple(materials[k] for k in used),
        lamps,
    )


@settings(
    max_examples=RANDOM_SCENES,
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
)
@given(random_scenes())
def test_random_scenes_give_finite_light_and_no_more_than_there_is(scene: Scene) -> None:
    try:
        with few_trials():
            made = run(scene, edge=0.25 * scene.diagonal, batches=2, target=0.99, threads=1)
    except SceneError as refusal:
        assert "\n" not in str(refusal)
        return
    field, mesh = made.field, made.field.mesh
    for column in vars(field.values).values():
        assert np.all(np.isfinite(column))
    assert np.all(field.values.illuminance >= 0.0)
    received = np.array(made.replicates.at_nodes) @ mesh.visible_areas
    albedo = max(float(np.max(m.diffuse + m.specular)) for m in scene.materials)
    emitted = float(field.world.emitters.power.sum())
    noise = float(critical_t(1.0, RANDOM_SCENES)) * received.std(ddof=1) / math.sqrt(2)
    assert received.mean() * (1.0 - albedo) <= emitted + noise * (1.0 - albedo)
