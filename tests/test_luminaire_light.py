"""Light of photometric luminaires: CIE 171:2006 cases, formats against each other, sampling, housings, pictures."""

from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from photofiles import batwing, ies, lambertian, ldt, sideways, skew, spot, uplight, wallwasher
from photorooms import BLACK, ROOM_OBJ, direct, direct_in, luminaire, scene_of
from verdicts import agrees, follows

from lelight.calculation import calculate
from lelight.camera import Fisheye
from lelight.errors import InputError
from lelight.luminaires import PhotometricLuminaire, placed_axes
from lelight.metrics.luminaireglare import luminaire_source
from lelight.photometry.opening import Opening
from lelight.photometry.photometry import Photometry
from lelight.photometry.reading import read_photometry
from lelight.photometry.zones import luminous_flux
from lelight.scene import Observer
from lelight.settings import Settings
from lelight.tracing.chains import emission_chains, emit
from lelight.tracing.distributions import collect_distributions, table_direction
from lelight.tracing.lamps import has_closed_form
from lelight.tracing.openings import seen_openings
from lelight.tracing.sobol import Stretch, sobol
from lelight.tracing.world import build_world

UP = (0.0, 0.0, 1.0)
FINE = np.arange(0.0, 181.0, 1.0)
POINT = [0] * 9


def photometry_of(tmp_path, text, name="lamp.ldt") -> Photometry:
    (tmp_path / name).write_text(text)
    return read_photometry(tmp_path / name)


# CIE 171:2006, analytical cases; values recomputed by quadrature from the cases' geometry.
POINT_SOURCE = {
    (0, 0): 111.111, (0.5, 0): 105.186, (1, 0): 90.0, (1.5, 0): 71.111, (0.5, 0.5): 99.723,
    (1, 0.5): 85.663, (1.5, 0.5): 68.053, (1, 1): 74.380, (1.5, 1): 59.975, (1.5, 1.5): 49.383,
}  # fmt: skip
AREA_WALL = {2.75: 32.677, 2.25: 75.194, 1.75: 81.323, 1.25: 69.061, 0.75: 53.404, 0.25: 40.002}
AREA_FLOOR = {0.25: 61.424, 0.75: 79.255, 1.25: 95.667, 1.75: 105.778, 2.25: 105.778, 3.75: 61.424}


@pytest.mark.parametrize("ending", ["ldt", "ies"])
def test_cie_171_case_5_2_point_source(tmp_path, ending):
    """A point of 1000 cos(theta) cd, 3 m over the floor, to 0.1 %."""
    file = (
        ldt(lambertian, symmetry=1, gamma=FINE, sizes=POINT, per_klm=1000 / 3)
        if ending == "ldt"
        else ies(lambertian, gamma=FINE, sizes=(0, 0, 0), scale=1000.0)
    )
    toml = BLACK + luminaire(f"lamp.{ending}", (2, 2, 3))
    scene = scene_of(tmp_path, toml, **{f"lamp_{ending}": file})
    points = [(2 + x, 2 + y, 0) for x, y in POINT_SOURCE]
    assert direct(scene, points, UP) == pytest.approx(list(POINT_SOURCE.values()), rel=1e-3)


@pytest.mark.parametrize("kind", ["area", "table"])
def test_cie_171_case_5_3_area_source(tmp_path, kind):
    """1 x 1 m of 1000 cd/m² in the middle of the ceiling, to 0.5 %, as emitting faces and as a luminaire."""
    panel = "v 1.5 1.5 2.999\nv 2.5 1.5 2.999\nv 2.5 2.5 2.999\nv 1.5 2.5 2.999\nusemtl panel\nf 12 11 10 9\n"
    if kind == "area":
        toml = BLACK + '"panel" = { reflectance = 0, luminance = 1000 }\n'
        scene = scene_of(tmp_path, toml, obj=ROOM_OBJ + panel)
    else:
        file = ldt(
            lambertian,
            symmetry=1,
            gamma=FINE,
            sizes=(1000, 1000, 0, 1000, 1000, 0, 0, 0, 0),
            per_klm=1000 / 3,
        )
        scene = scene_of(tmp_path, BLACK + luminaire("lamp.ldt", (2, 2, 3)), lamp_ldt=file)
    world = build_world(scene, 1)
    wall = direct_in(world, [(2, 0, z) for z in AREA_WALL], (0, 1, 0), log2_samples=12)
    floor = direct_in(world, [(2, y, 0) for y in AREA_FLOOR], UP, log2_samples=12)
    assert wall == pytest.approx(list(AREA_WALL.values()), rel=5e-3)
    assert floor == pytest.approx(list(AREA_FLOOR.values()), rel=5e-3)


@pytest.mark.parametrize("file", ["isotropic", "batwing", "uplight"])
def test_cie_171_case_5_4_flux_is_conserved(tmp_path, file):
    """What arrives on all surfaces of a closed black room is what the luminaire sends, to 0.2 %."""
    intensity = {"isotropic": lambda c, g: 1.0, "batwing": batwing, "uplight": uplight}[file]
    text = ldt(intensity, symmetry=4 if file == "batwing" else 1, sizes=POINT, gamma=np.arange(0, 181, 2.5))
    scene = scene_of(tmp_path, BLACK + luminaire("lamp.ldt", (1.7, 2.2, 1.4)), lamp_ldt=text)
    expected = luminous_flux(scene.luminaires[0].photometry)
    assert sum(_arriving(scene)) == pytest.approx(expected, rel=2e-3)


def _arriving(scene):
    """Flux in lm on each of the six faces, by Gauss's rule with 40 x 40 points."""
    node, weight = np.polynomial.legendre.leggauss(40)
    node, weight = 0.5 * (node + 1.0), 0.5 * weight
    size = np.array([4.0, 4.0, 3.0])
    world = build_world(scene, 1)
    for axis in range(3):
        u, v = (a for a in range(3) if a != axis)
        for side in (0, 1):
            points = np.zeros((1600, 3))
            points[:, u], points[:, v] = (
                grid.ravel() * size[a] for grid, a in zip(np.meshgrid(node, node), (u, v), strict=True)
            )
            points[:, axis] = side * size[axis]
            normal = np.zeros(3)
            normal[axis] = 1.0 - 2.0 * side
            found = direct_in(world, points, normal, log2_samples=0)
            yield float((found * np.outer(weight, weight).ravel()).sum() * size[u] * size[v])


def test_flux_is_conserved_on_the_node_mesh_and_reported(tmp_path):
    """The same by a whole calculation; a near opening is spread and loses nothing."""
    text = ldt(batwing, symmetry=4, gamma=np.arange(0, 181, 2.5))
    scene = scene_of(tmp_path, BLACK + luminaire("lamp.ldt", (2, 2, 2.5)), lamp_ldt=text)
    run = calculate(scene, Settings(edge=0.15, batches=4, target=0.05, seed=3))
    mesh = run.field.mesh
    arriving = float((run.field.illuminance * mesh.areas)[~mesh.hidden].sum())
    assert arriving == pytest.approx(luminous_flux(scene.luminaires[0].photometry), rel=2e-3)


def test_ies_and_ldt_of_one_luminaire_light_alike(tmp_path):
    """Same planes, same opening: the same nodes get the same light."""
    found = []
    for ending, file in (
        ("ldt", ldt(wallwasher, symmetry=2)),
        ("ies", ies(wallwasher, horizontal=range(0, 181, 15), sizes=(0.6, 0.3, 0))),
    ):
        toml = '[materials]\n"*" = { reflectance = 0.5 }\n' + luminaire(f"lamp.{ending}", (2, 2, 2.5))
        scene = scene_of(tmp_path / ending, toml, **{f"lamp_{ending}": file})
        assert scene.luminaires[0].photometry.opening == Opening("rectangle", 0.3, 0.6)
        found.append(calculate(scene, Settings(edge=0.5, batches=3, target=0.1, seed=5)).field.illuminance)
    assert found[0] == pytest.approx(found[1], rel=1e-4)


def test_turning_c0_turns_the_light(tmp_path):
    """E at a place with C0 along x is E at the place turned by 90 degrees with C0 along y; exactly so."""
    scenes = [
        scene_of(
            tmp_path / str(k),
            BLACK + luminaire("lamp.ldt", (2, 2, 2.8), c0=c0),
            lamp_ldt=ldt(skew, symmetry=0),
        )
        for k, c0 in enumerate(([1, 0, 0], [0, 1, 0]))
    ]
    offsets = np.random.default_rng(2).uniform(-1.9, 1.9, (50, 2))
    turned = np.column_stack([-offsets[:, 1], offsets[:, 0]])
    places, others = (np.column_stack([2 + xy, np.zeros(50)]) for xy in (offsets, turned))
    here = direct(scenes[0], places, UP, log2_samples=10)
    there = direct(scenes[1], others, UP, log2_samples=10)
    assert there == pytest.approx(here, rel=2e-3)
    assert direct(scenes[1], places, UP) != pytest.approx(here, rel=0.05)


def test_c_runs_anticlockwise_seen_from_above(tmp_path):
    axes = placed_axes(np.array([0, 0, -1.0]), np.array([2.0, 0, 0.5]))
    assert axes == pytest.approx(np.eye(3))
    lamp = PhotometricLuminaire("L", np.zeros(3), axes, photometry_of(tmp_path, ldt(skew, symmetry=0)))
    c, gamma = lamp.direction_angles(np.array([[0.0, 1.0, -1.0], [-1.0, 0.0, 0.0]]) / [[math.sqrt(2)], [1]])
    assert c == pytest.approx([90.0, 180.0])
    assert gamma == pytest.approx([45.0, 90.0])


def test_a_lambertian_table_is_an_area_emitter_beyond_five_sizes(tmp_path):
    """0.4 x 0.4 m at 2.05 m and more: within 1 %; nearer it is spread, and then agrees too."""
    panel = "v 1.8 1.8 2.5\nv 2.2 1.8 2.5\nv 2.2 2.2 2.5\nv 1.8 2.2 2.5\nusemtl panel\nf 12 11 10 9\n"
    area = scene_of(
        tmp_path / "area", BLACK + '"panel" = { reflectance = 0, luminance = 1000 }\n', obj=ROOM_OBJ + panel
    )
    file = ldt(lambertian, symmetry=1, gamma=FINE, sizes=(400, 400, 0, 400, 400, 0, 0, 0, 0), per_klm=160 / 3)
    table = scene_of(tmp_path / "table", BLACK + luminaire("lamp.ldt", (2, 2, 2.5)), lamp_ldt=file)
    rng = np.random.default_rng(4)
    far = np.column_stack([rng.uniform(0.1, 3.9, (40, 2)), np.zeros(40)])
    assert direct(table, far, UP) == pytest.approx(direct(area, far, UP, log2_samples=10), rel=1e-2)
    near = np.column_stack([rng.uniform(1.5, 2.5, (40, 2)), rng.uniform(1.0, 1.8, 40)])
    assert direct(table, near, UP, log2_samples=10) == pytest.approx(
        direct(area, near, UP, log2_samples=10), rel=5e-3
    )


#: A rectangular opening, and a round one of 0.6 m that a table of 30° steps describes.
OPENINGS = {
    "rectangle": ldt(batwing),
    "circle": ldt(
        lambertian, symmetry=1, gamma=np.arange(0.0, 181.0, 30.0), sizes=(620, 0, 80, 600, 0, 0, 0, 0, 0)
    ),
}


@pytest.mark.parametrize("opening", OPENINGS)
def test_near_luminaires_closed_form_is_what_drawing_gives(tmp_path, opening):
    """Quadrature over the opening against the mean of many draws without control variate."""
    scene = scene_of(tmp_path, BLACK + luminaire("lamp.ldt", (2, 2, 2.5)), lamp_ldt=OPENINGS[opening])
    world = build_world(scene, 1)
    points = np.array([[2.3, 2.1, 0.9], [1.2, 2.9, 1.3], [2.0, 2.0, 1.8], [2.6, 2.6, 1.9]])
    assert all(has_closed_form(world.emitters, *point, 0.0, 0.0, 1.0) for point in points)
    closed = direct_in(world, points, UP, log2_samples=0)
    from lelight.estimate.direct import direct_light
    from lelight.receivers import ILLUMINANCE, space_receivers, with_surface

    receivers = with_surface(space_receivers(points, np.tile(UP, (4, 1))))
    drawn = [
        direct_light(world, receivers, samples=Stretch.of(8), seed=(k, 9))[0][:, ILLUMINANCE, 0]
        for k in range(24)
    ]
    assert agrees(np.array(drawn), closed, relative_error=2e-3)
    assert not agrees(np.array(drawn), 1.02 * closed, relative_error=2e-3)


SAMPLED = {
    "rotational": (lambertian, 1),
    "c0-c180": (wallwasher, 2),
    "c90-c270": (sideways, 3),
    "both": (batwing, 4),
    "none": (skew, 0),
    "uplight": (uplight, 1),
}


@pytest.mark.parametrize("name", [*SAMPLED, "spot"])
def test_directions_are_drawn_as_the_table_says(tmp_path, name):
    """Chi-square of directions against intensity x solid angle, for all symmetries, an uplight and a 2° beam."""
    if name == "spot":
        text = ies(spot, gamma=[*np.arange(0, 5, 0.25), 5, 10, 90], scale=1e4)
        photometry = photometry_of(tmp_path, text, "spot.ies")
        borders = np.concatenate([np.linspace(0, 3, 13), [4, 5, 180]])
    else:
        intensity, symmetry = SAMPLED[name]
        photometry = photometry_of(tmp_path, ldt(intensity, symmetry=symmetry))
        borders = np.linspace(0, 180, 19)
    tables = collect_distributions([photometry])
    numbers = np.random.default_rng(11).random((60_000, 2))
    drawn = np.array([table_direction(tables, 0, u, v) for u, v in numbers])
    gamma = np.degrees(np.arctan2(np.hypot(drawn[:, 0], drawn[:, 1]), -drawn[:, 2]))
    c = np.degrees(np.arctan2(drawn[:, 1], drawn[:, 0])) % 360.0
    planes = np.linspace(0, 360, 13)
    counts, _, _ = np.histogram2d(c, gamma, [planes, borders])
    shares = _cell_shares(photometry, planes, borders)
    assert follows(counts, shares)
    wrong = np.roll(shares, 1, axis=1)
    assert not follows(counts, wrong)


def _cell_shares(photometry, planes, borders):
    """Share of the flux (12, n) in cells of C and γ, by the midpoint rule on 30 x 60 points a cell."""
    shares = np.zeros((len(planes) - 1, len(borders) - 1))
    for i, j in np.ndindex(shares.shape):
        c = planes[i] + (np.arange(30) + 0.5) / 30 * (planes[i + 1] - planes[i])
        low, high = borders[j], min(borders[j + 1], max(borders[j] + 1e-9, float(photometry.gamma[-1])))
        steps = 2000 if high - low > 20 else 60
        gamma = low + (np.arange(steps) + 0.5) / steps * (high - low)
        light = photometry.intensity(c[:, None], gamma) * np.sin(np.radians(gamma))
        shares[i, j] = light.mean() * np.radians(high - low) * np.radians(planes[i + 1] - planes[i])
    return shares / luminous_flux(photometry)


def test_every_chain_carries_the_same_flux_and_even_numbers_stay_even(tmp_path):
    scene = scene_of(
        tmp_path,
        BLACK + luminaire("lamp.ldt", (1, 1, 2.5)) + luminaire("spot.ies", (3, 3, 2.5), dimming=0.5),
        lamp_ldt=ldt(skew, symmetry=0),
        spot_ies=ies(spot, gamma=[*np.arange(0, 5, 0.25), 5, 10, 90], scale=1e4),
    )
    world = build_world(scene, 1)
    flux = sum(lamp.factor * luminous_flux(lamp.photometry) for lamp in scene.luminaires)
    _, directions, carried = emit(world.emitters, sobol(5, Stretch.of(12), seed=(1,)), world.caster.offset)
    assert carried == pytest.approx(flux, rel=1e-9)
    # Even points: the mean direction comes out far better than by independent draws (about 1/64 of 1).
    again = emit(world.emitters, sobol(5, Stretch.of(12), seed=(2,)), world.caster.offset)[1]
    assert np.abs(directions.mean(axis=0) - again.mean(axis=0)).max() < 2e-3


def test_emitted_flux_all_arrives(tmp_path):
    scene = scene_of(tmp_path, BLACK + luminaire("lamp.ldt", (2, 2, 3)), lamp_ldt=ldt(batwing))
    vertices = emission_chains(build_world(scene, 1), Stretch.of(10), seed=(3,))
    assert vertices.flux.sum() == pytest.approx(luminous_flux(scene.luminaires[0].photometry), rel=1e-9)


HOUSING = (
    "".join(
        f"v {x} {y} {z}\n" for z in (2.4, 2.6) for x, y in ((1.8, 1.8), (2.2, 1.8), (2.2, 2.2), (1.8, 2.2))
    )
    + "usemtl can\nf 9 10 11 12\nf 13 14 15 16\nf 9 10 14 13\nf 10 11 15 14\nf 11 12 16 15\nf 12 9 13 16\n"
)


@pytest.mark.parametrize("housing", ["can", "c*", None])
def test_housing_lets_its_own_light_pass(tmp_path, housing):
    """A closed box round a lamp: dark outside, unless its material is the lamp's housing."""
    keys = {} if housing is None else {"housing": housing}
    scene = scene_of(
        tmp_path,
        BLACK + luminaire("lamp.ldt", (2, 2, 2.5), **keys),
        obj=ROOM_OBJ + HOUSING,
        lamp_ldt=ldt(batwing, sizes=POINT),
    )
    world = build_world(scene, 1)
    lit = direct_in(world, [(2.5, 2.5, 0)], UP)[0]
    outside = emission_chains(world, Stretch.of(8), seed=(1,))
    reached = {scene.materials[m].name for m in outside.materials}
    seen = seen_openings(world, scene, np.array([[2.0, 2.0, 1.0]]), np.array([[0.0, 0.0, 1.0]]))[0]
    assert (lit > 0) == (housing is not None)
    assert reached == ({"can"} if housing is None else {"floor", "wall"})
    assert len(seen) == 0


def test_housing_of_one_lamp_blocks_the_others(tmp_path):
    toml = (
        BLACK
        + luminaire("lamp.ldt", (2, 2, 2.9), housing="other")
        + luminaire("lamp.ldt", (2, 2, 2.5), housing="can")
    )
    scene = scene_of(tmp_path, toml, obj=ROOM_OBJ + HOUSING, lamp_ldt=ldt(lambertian, sizes=POINT))
    assert any("other" in warning for warning in scene.warnings)
    below = [(2.0, 2.0, 0.0)]
    one = replace(scene, luminaires=scene.luminaires[1:])
    # The dark lamp takes draws: even ones, so that its share is right to one in their number.
    assert direct(scene, below, UP, log2_samples=13) == pytest.approx(direct(one, below, UP), rel=1e-3)


SHAPES = {
    "rectangle": Opening("rectangle", 0.3, 0.6),
    "box": Opening("rectangle", 0.3, 0.6, (0.2,) * 4),
    "circle": Opening("ellipse", 0.4, 0.4),
    "cylinder": Opening("ellipse", 0.3, 0.5, (0.4,) * 4),
    "sphere": Opening("ellipsoid", 0.4, 0.4, (0.4,) * 4),
    "tube": Opening("tube_c0", 0.8, 0.1, (0.1,) * 4),
    "tube across": Opening("tube_c90", 0.1, 0.8, (0.1,) * 4),
}


@pytest.mark.parametrize("name", SHAPES)
def test_pictures_show_intensity_over_projected_area(tmp_path, name):
    """Luminance times solid angle of all pixels is I / r², as far as a distance of 8 sizes is far."""
    scene = scene_of(
        tmp_path, BLACK + luminaire("lamp.ldt", (2, 2, 2.0)), lamp_ldt=ldt(lambda c, g: 1.0, symmetry=1)
    )
    lamp = replace(
        scene.luminaires[0], photometry=replace(scene.luminaires[0].photometry, opening=SHAPES[name])
    )
    lamp = replace(lamp, axes=placed_axes(np.array([0.3, -0.2, -1.0]), np.array([1.0, 0.4, 0.0])))
    scene = replace(scene, luminaires=(lamp,))
    world = build_world(scene, 1)
    eye = np.array([0.3, 0.2, 0.9])
    toward = lamp.position - eye
    direction = toward / np.linalg.norm(toward)
    # Rays over a small square on the sphere around the luminaire's middle.
    first = np.cross(direction, [0.0, 0.0, 1.0])
    first /= np.linalg.norm(first)
    second = np.cross(first, direction)
    half, count = 0.35, 400
    steps = (np.arange(count) + 0.5) / count * 2 * half - half
    a, b = (grid.ravel() for grid in np.meshgrid(steps, steps))
    rays = direction + a[:, None] * first + b[:, None] * second
    length = np.linalg.norm(rays, axis=1)
    solid_angles = (2 * half / count) ** 2 / length**3
    met, luminance = seen_openings(world, scene, np.tile(eye, (len(rays), 1)), rays / length[:, None])
    found = float((luminance[:, 0] * solid_angles[met]).sum())
    expected = float(lamp.intensity_toward(-direction[None])[0]) / float(toward @ toward)
    assert found == pytest.approx(expected, rel=3e-2)


def test_rated_luminance_is_intensity_over_projected_area(tmp_path):
    lamp = PhotometricLuminaire(
        "L",
        np.array([3.0, 0.0, 2.8]),
        np.eye(3),
        photometry_of(tmp_path, ldt(lambertian, symmetry=1)),
        factor=0.8,
    )
    eye = Observer("eye", np.array([0.0, 0.0, 1.2]), np.array([1.0, 0.0, 0.0]))
    source = luminaire_source(lamp, eye, lambda origins, targets: np.ones(len(targets), dtype=bool))
    square = 9.0 + 1.6**2
    cosine = 1.6 / math.sqrt(square)
    # 3000 lm Lambertian over 0.18 m²: L = 3000 / (π 0.18) in every direction.
    assert source.luminance == pytest.approx(0.8 * 3000 / math.pi / 0.18, rel=2e-3)
    assert source.solid_angle == pytest.approx(0.18 * cosine / square, rel=1e-9)
    assert source.position_index is not None
    half = luminaire_source(lamp, eye, lambda origins, targets: targets[:, 1] > 0)
    assert half.visible_fraction == 0.5
    bare = replace(lamp, photometry=replace(lamp.photometry, opening=Opening()))
    assert (
        "no luminous opening"
        in luminaire_source(bare, eye, lambda o, t: np.ones(len(t), dtype=bool)).excluded
    )


def test_arrays_dimming_and_maintenance(tmp_path):
    toml = luminaire(
        "lamp.ldt", (0.5, 1, 2.5), rows=2, columns=3, spacing=[1.0, 1.5], dimming=0.5, maintenance=0.8
    )
    scene = scene_of(tmp_path, toml, lamp_ldt=ldt())
    places = [lamp.position.tolist() for lamp in scene.luminaires]
    assert places == [[x, y, 2.5] for y in (1, 2.5) for x in (0.5, 1.5, 2.5)]
    assert {lamp.factor for lamp in scene.luminaires} == {0.4}
    assert scene.luminaires[4].name == "L 2.2"
    assert scene.files["lamp.ldt"] == scene.luminaires[0].photometry.sha256


def test_lamps_that_depend_on_tilt_are_dimmed_by_it(tmp_path):
    tilt = "TILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.6"
    for aim, factor in (([0, 0, -1], 1.0), ([1, 0, -1], 0.9), ([1, 0, 0], 0.6)):
        toml = luminaire("lamp.ies", (1, 1, 2.5), aim=aim)
        assert scene_of(tmp_path, toml, lamp_ies=ies(tilt=tilt)).luminaires[0].factor == pytest.approx(factor)


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        (
            luminaire("absent.ldt", (1, 1, 2)),
            'luminaires[0].photometry: found "absent.ldt", which is not there; searched',
        ),
        (luminaire("room.obj", (1, 1, 2)), "luminaires[0].photometry: "),
        (luminaire("lamp.ldt", (1, 1, 2), aim=[1, 0, 0], c0=[2, 0, 0]), "luminaires[0].c0: "),
        (luminaire("lamp.ldt", (1, 1, 2), rows=2), "spacing"),
        (luminaire("lamp.ldt", (1, 1, 2), spacing=[1, 2, 3]), "one or two numbers"),
        (luminaire("lamp.ldt", (1, 1, 2), rows=0), "rows"),
        (luminaire("lamp.ldt", (1, 1, 2), housing=""), "housing"),
    ],
)
def test_slips_in_luminaire_tables_name_the_key(tmp_path, toml, words):
    with pytest.raises(InputError) as failure:
        scene_of(tmp_path, toml, lamp_ldt=ldt())
    assert words in str(failure.value)
    assert "\n" not in str(failure.value)


def test_check_draws_where_luminaires_point(tmp_path):
    from commandline import lelight

    scene_of(tmp_path, luminaire("lamp.ldt", (1, 1, 2.5), c0=[0, 1, 0]), lamp_ldt=ldt(batwing))
    told = lelight("check", str(tmp_path / "room.toml"))
    assert told.status == 0
    assert "C0 (0, 1, 0)" in told.stdout
    assert "lamp.ldt: EULUMDAT, opening 0.3 m along C0, 0.6 m along C90" in told.stdout
    drawing = (tmp_path / "room.lelight" / "layout.svg").read_text()
    assert drawing.count('class="c0"') == 2
    assert (tmp_path / "room.lelight" / "luminaires.vtp").stat().st_size > 0


def test_photometry_commands(tmp_path):
    from commandline import lelight

    (tmp_path / "good.ldt").write_text(ldt(symmetry=1))
    (tmp_path / "bad.ldt").write_text(ldt(per_klm=100.0))
    info = json.loads(
        lelight(
            "photometry", "info", str(tmp_path / "good.ldt"), "--json", "--polar", str(tmp_path / "p.png")
        ).stdout
    )
    assert info["flux"] == pytest.approx(3000, rel=2e-3)
    assert info["flux_code"] == [44, 75, 94, 100, 100]
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    assert lelight("photometry", "check", str(tmp_path / "good.ldt")).status == 0
    checked = lelight(
        "photometry", "check", "--json", *(str(tmp_path / n) for n in ("good.ldt", "bad.ldt", "none.ies"))
    )
    assert checked.status == 1
    assert [one["ok"] for one in json.loads(checked.stdout)] == [True, False, False]
    table = json.loads(
        lelight("photometry", "ugr", str(tmp_path / "good.ldt"), "--json", "--spacing", "1.0").stdout
    )
    assert set(table) == {"rooms", "reflectances", "crosswise", "endwise", "spacing", "flux"}
    assert np.shape(table["crosswise"]) == np.shape(table["endwise"]) == (19, 5)
    assert lelight("photometry", "convert", str(tmp_path / "good.ldt"), str(tmp_path / "out.ies")).status == 0
    assert "P-600" in (tmp_path / "out.ies").read_text()


def test_a_picture_through_the_field_shows_the_opening(tmp_path):
    """The pixel that looks at the luminaire has its luminance."""
    toml = '[materials]\n"*" = { reflectance = 0.5 }\n' + luminaire("lamp.ldt", (2, 2, 3))
    scene = scene_of(tmp_path, toml, lamp_ldt=ldt(lambertian, symmetry=1))
    run = calculate(scene, Settings(edge=1.0, batches=2, target=0.3, seed=1))
    camera = Fisheye(np.array([2.0, 2.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    with ThreadPoolExecutor(1) as executor:
        picture = run.field.picture(camera, 9, 9, samples=1, executor=executor)
    assert picture[4, 4] == pytest.approx(3000 / math.pi / 0.18, rel=1e-3)
