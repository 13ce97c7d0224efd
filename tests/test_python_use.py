"""lelight as a library, as the README shows it."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
from commandline import ROOM_MTL, write_room

import lelight


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return lelight.load(write_room(tmp_path_factory.mktemp("library") / "Raum ü"))


@pytest.fixture(scope="module")
def field(scene):
    return lelight.calc(scene, target=0.1, settings=lelight.Settings(edge=0.5))


def panel_nodes(field):
    """Nodes on the side of the panel that shines."""
    (panel,) = [k for k, material in enumerate(field.scene.materials) if material.name == "panel"]
    return np.flatnonzero((field.mesh.materials == panel) & (field.mesh.sides == 1))


def test_calc_reaches_the_target_it_is_given(field):
    assert field.illuminance.shape == field.std_error.shape == (len(field.mesh),)
    assert (field.illuminance > 0).all() and (field.std_error > 0).all()
    floor = 0.05 * np.average(field.illuminance, weights=field.mesh.areas)
    relative = field.std_error / np.maximum(field.illuminance, floor)
    assert np.average(relative**2, weights=field.mesh.areas) <= 0.1**2


def test_calc_takes_what_the_contract_names():
    parameters = inspect.signature(lelight.calc).parameters
    assert list(parameters)[:3] == ["scene", "target", "time"]
    kinds = {name: parameter.kind for name, parameter in parameters.items() if name != "scene"}
    assert set(kinds.values()) == {inspect.Parameter.KEYWORD_ONLY}


def test_radiance_of_a_lamp_is_emission_and_reflection(field):
    # At the panel's middle: its 4000 cd/m², and 0.5 / pi of an illuminance between those of its nodes.
    (radiance,) = field.radiance(np.array([[1.0, 1.0, 1.9]]), np.array([[0.0, 0.0, -1.0]]))
    nodes = field.illuminance[panel_nodes(field)]
    assert radiance.shape == (1,)
    assert 0.5 / np.pi * nodes.min() <= radiance[0] - 4000 <= 0.5 / np.pi * nodes.max()


def test_radiance_does_not_depend_on_the_length_of_directions(field):
    points, directions = field.mesh.positions[:40], field.mesh.normals[:40]
    radiance = field.radiance(points, directions)
    assert radiance.shape == (40, 1)
    np.testing.assert_allclose(field.radiance(points, 7.0 * directions), radiance, rtol=1e-9)
    assert field.radiance(points[:0], directions[:0]).shape == (0, 1)


def test_a_lambertian_wall_sends_the_same_everywhere(field):
    point = np.array([[0.0, 1.1, 0.9]])
    directions = np.array([[1.0, 0.0, 0.0], [0.3, 0.9, -0.1], [0.1, -0.4, 0.8]])
    radiance = field.radiance(np.repeat(point, 3, axis=0), directions)
    np.testing.assert_allclose(radiance, np.full((3, 1), radiance[0]), rtol=1e-6)


def test_a_field_comes_back_from_its_file(field, scene, tmp_path):
    path = tmp_path / "Feld ü.vtp"
    field.save(path)
    loaded = lelight.RadianceField.load(path, scene)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    for name, values in vars(field.values).items():
        np.testing.assert_array_equal(getattr(loaded.values, name), values, err_msg=name)
    for name in ("vertices", "positions", "normals", "frames_x", "areas", "materials", "sides", "triangles"):
        np.testing.assert_array_equal(getattr(loaded.mesh, name), getattr(field.mesh, name), err_msg=name)
    points, directions = field.mesh.positions[::5], field.mesh.normals[::5]
    np.testing.assert_array_equal(loaded.radiance(points, directions), field.radiance(points, directions))


def test_a_coloured_scene_has_three_channels(tmp_path):
    scene = lelight.load(write_room(tmp_path, mtl=ROOM_MTL.replace("Kd 0.6 0.6 0.6", "Kd 0.6 0.4 0.3")))
    field = lelight.calc(scene, settings=lelight.Settings(edge=1.0, batches=2))
    assert field.values.illuminance.shape == (len(field.mesh), 3)
    assert field.illuminance.shape == (len(field.mesh),)
    weights = np.array([0.2126, 0.7152, 0.0722])  # ITU-R BT.709-6, item 3.2
    np.testing.assert_allclose(field.illuminance, field.values.illuminance @ weights, rtol=1e-12)
    radiance = field.radiance(field.mesh.positions[:6], field.mesh.normals[:6])
    assert radiance.shape == (6, 3)


def test_mistakes_are_errors_of_lelight(tmp_path):
    with pytest.raises(lelight.LelightError, match="no such file"):
        lelight.load(tmp_path / "missing.obj")
    with pytest.raises(AttributeError, match="'lelight' has no attribute 'render'"):
        _ = lelight.render
