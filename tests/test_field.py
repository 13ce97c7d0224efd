"""The radiance field: Lambert's law to the horizon, emission, mirrors, free space, files."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from shapes import Shape, box, scene_of
from threeglosses import drawn_directions, three_glosses

from lelight.calculation import calculate
from lelight.estimate.pathstate import chosen_paths, meet
from lelight.field import RadianceField
from lelight.highlights import highlights, only_specular, sees_images
from lelight.scene import EmissionSides, FloatArray, Material, PointLuminaire, Scene
from lelight.settings import Settings
from lelight.tracing.world import build_world

ROOM = (4.0, 3.0, 2.5)


def material(
    name: str, reflectance: float, *, luminance: float = 0.0, sides: EmissionSides = "front"
) -> Material:
    return Material(name, np.full(3, reflectance), luminance=np.full(3, luminance), emission_sides=sides)


def panel(height: float, size: float) -> Shape:
    """A square over the middle of the room, its front downwards."""
    x, y, h = ROOM[0] / 2, ROOM[1] / 2, size / 2
    corners = np.array([[x - h, y - h], [x - h, y + h], [x + h, y + h], [x + h, y - h]])
    return np.column_stack([corners, np.full(4, height)]), np.array([(0, 1, 2), (0, 2, 3)])


def turned(scene: Scene) -> Scene:
    """The scene turned so that no face lies along an axis, and moved."""
    axes, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    axes *= np.sign(np.linalg.det(axes))
    lamps = tuple(replace(lamp, position=lamp.position @ axes.T + 1.0) for lamp in scene.luminaires)
    return replace(scene, vertices=scene.vertices @ axes.T + 1.0, luminaires=lamps)


def solved(scene: Scene, *, edge: float = 1.0) -> RadianceField:
    return calculate(scene, Settings(edge=edge, batches=2)).field


@cache
def point_lit_room(*, along_axes: bool) -> RadianceField:
    lamp = PointLuminaire("lamp", np.array([2.0, 1.5, 1.9]), np.full(3, 100.0))
    scene = replace(scene_of(box(ROOM)), luminaires=(lamp,))
    return solved(scene if along_axes else turned(scene))


@cache
def panel_lit_room() -> RadianceField:
    scene = scene_of(box(ROOM), panel(2.0, 0.6), materials=[0, 1])
    return solved(replace(scene, materials=(material("wall", 0.5), material("panel", 0.0, luminance=1000.0))))


@cache
def mirror_room() -> RadianceField:
    """A black room, a panel that hangs in it, and a floor that is nearly a mirror."""
    shell = box(ROOM)
    floor = np.all(shell[0][shell[1]][:, :, 2] == 0.0, axis=1)
    shapes = (shell[0], shell[1][~floor]), (shell[0], shell[1][floor]), panel(2.0, 0.6)
    mirror = Material("mirror", np.zeros(3), specular=np.full(3, 0.8), exponent=1000.0)
    palette = (material("wall", 0.1), mirror, material("panel", 0.0, luminance=1000.0))
    return solved(replace(scene_of(*shapes, materials=[0, 1, 2]), materials=palette))


def middles(field: RadianceField) -> FloatArray:
    """(m, 3) m: middles of the node mesh's triangles, where weights are a third each but for rounding."""
    return np.asarray(field.mesh.vertices[field.mesh.triangles].mean(axis=1))


def leaning(field: RadianceField, degrees: float) -> FloatArray:
    """Unit directions (m, 3), one a triangle, so far off its normal."""
    first = field.mesh.triangles[:, 0]
    angle = math.radians(degrees)
    return math.cos(angle) * field.mesh.normals[first] + math.sin(angle) * field.mesh.frames_x[first]


@pytest.mark.parametrize("along_axes", [True, False])
@pytest.mark.parametrize("degrees", [30.0, 60.0, 85.0, 89.0, 89.9])
def test_a_lambertian_surface_looks_the_same_from_everywhere(degrees: float, along_axes: bool) -> None:
    field = point_lit_room(along_axes=along_axes)
    places = middles(field)
    upright = field.radiance(places, leaning(field, 0.0))
    assert np.min(upright) > 0
    np.testing.assert_allclose(field.radiance(places, leaning(field, degrees)), upright, rtol=1e-6)


def test_radiance_is_interpolated_exitance_over_pi() -> None:
    field = point_lit_room(along_axes=True)
    expected = 0.5 / math.pi * field.values.illuminance[field.mesh.triangles].mean(axis=1)
    np.testing.assert_allclose(field.radiance(middles(field), leaning(field, 40.0)), expected, rtol=1e-6)


def test_emission_leaves_the_front_only() -> None:
    field = panel_lit_room()
    places = np.array([[2.0 + x, 1.5 + y, 2.0] for x in (-0.2, 0.1) for y in (-0.1, 0.2)])
    down = np.tile([0.1, 0.2, -1.0], (4, 1))
    # The panel reflects nothing, so what it shows is all emission.
    np.testing.assert_array_equal(field.radiance(places, down), np.full((4, 1), 1000.0))
    np.testing.assert_array_equal(field.radiance(places, -down), np.zeros((4, 1)))


def test_both_sides_emit_where_the_scene_says_so() -> None:
    field = panel_lit_room()
    panel_of = np.array([m.name == "panel" for m in field.scene.materials])
    materials = tuple(
        replace(m, emission_sides="both") if own else m
        for m, own in zip(field.scene.materials, panel_of, strict=True)
    )
    both = solved(replace(field.scene, materials=materials))
    above = np.array([[2.1, 1.6, 2.0]])
    np.testing.assert_array_equal(both.radiance(above, np.array([[0.0, 0.0, 1.0]])), [[1000.0]])


def test_a_point_in_space_shows_the_surface_behind_it() -> None:
    field = point_lit_room(along_axes=True)
    places, way = middles(field), leaning(field, 35.0)
    np.testing.assert_allclose(
        field.radiance(places + 0.05 * way, way), field.radiance(places, way), rtol=1e-6
    )


def test_a_mirror_shows_the_lamp_where_the_law_of_reflection_puts_it() -> None:
    # The eye at height h over a mirror at z = 0 sees the panel at height H around (2, 1.5) in its image at
    # -H. Rays to the image's middle meet the lamp; the lobe (half width 2 degrees at n = 1000) is far
    # smaller than the image's 17 degrees, so it shows ks (n + 2) / (n + 1) 1000 cos(theta) = 801 cos(theta)
    # cd/m², and nothing of the lamp where the image is 20 degrees away.
    field = mirror_room()
    eye, image = np.array([1.0, 1.5, 1.0]), np.array([2.0, 1.5, -2.0])
    way = (image - eye) / np.linalg.norm(image - eye)
    aside = np.array([-way[0], way[1], way[2]])
    seen = field.seen(np.tile(eye, (64, 1)), np.tile(way, (64, 1)))[:, 0]
    expected = 0.8 * 1002.0 / 1001.0 * 1000.0 * -way[2]
    std_error = seen.std(ddof=1) / 8.0
    assert std_error < 0.02 * expected
    assert abs(seen.mean() - expected) < 4.0 * std_error + 0.01 * expected
    assert np.max(field.seen(np.tile(eye, (64, 1)), np.tile(aside, (64, 1)))) < 0.05 * expected


@pytest.mark.parametrize("room", [panel_lit_room, mirror_room])
def test_a_saved_field_is_the_same_field(room: object, tmp_path: Path) -> None:
    assert callable(room)
    field = room()
    path = tmp_path / "Büro 1" / "field.vtp"
    path.parent.mkdir()
    field.save(path)
    again = RadianceField.load(path, field.scene)
    places, way = middles(field), leaning(field, 50.0)
    np.testing.assert_allclose(again.radiance(places, way), field.radiance(places, way), rtol=1e-6)


@pytest.mark.parametrize("room", [panel_lit_room, mirror_room])
def test_nothing_is_nan_from_any_direction(room: object) -> None:
    assert callable(room)
    field = room()
    rng = np.random.default_rng(3)
    inside = rng.random((2000, 3)) * np.array(ROOM)
    way = rng.normal(size=(2000, 3))
    nodes = rng.integers(len(field.mesh), size=2000)
    for places in (inside, field.mesh.positions[nodes], field.mesh.vertices[nodes]):
        radiance = field.radiance(places, way)
        assert np.all(np.isfinite(radiance))
        assert np.all(radiance >= 0.0)
    assert np.all(np.isfinite(field.values.scalar_illuminance))
    assert np.all(np.isfinite(field.values.light_vector))


def test_no_image_of_a_lamp_is_left_out() -> None:
    # Where `sees_images` says there is none, drawing for it finds next to nothing; and it says so in most places.
    scene = three_glosses()
    world = build_world(scene, 1)
    paths, _ = meet(world, np.arange(4000), *drawn_directions(4000), np.ones((4000, 1)))
    paths = chosen_paths(paths, np.flatnonzero(world.reflectances.specular_share[paths.materials] > 0))
    places = {name: getattr(paths, name) for name in ("points", "normals", "outgoing", "materials")}
    seen = sees_images(world, **places)
    images, _ = highlights(only_specular(world), **places, identity=np.arange(len(seen)), log2_samples=6)
    assert np.max(images[~seen]) < 1e-4 * np.max(images)
    assert 0.2 < np.mean(seen) < 0.6
