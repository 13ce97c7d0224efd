"""VTK files: what is in them, and that the field comes back bit by bit."""

from __future__ import annotations

import csv
import dataclasses
import json
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import pyvista

from lelight.channels import channel_suffixes, luminance_weighted
from lelight.errors import OutputError
from lelight.mesh.nodes import NodeMesh
from lelight.results import NodeValues, PlaneValues
from lelight.scene import MeasuringPlane, Observer, PointLuminaire
from lelight.writing.files import whole
from lelight.writing.vtkfiles import (
    read_field,
    write_field,
    write_index,
    write_luminaires,
    write_observers,
    write_plane,
)

CONTRACT_POINT_ARRAYS = {
    "illuminance_lx",
    "illuminance_std_error_lx",
    "luminance_cd_m2",
    "exitance_lm_m2",
    "scalar_illuminance_lx",
    "light_vector_lx",
    "normal",
    "sh_degree",
    "frame_x",
    "hidden",
}
HEADER = {"version": "1", "seed": 7, "up": "z", "inputs": {"Büro.obj": "00ff"}}
NAMES = ["floor", "Wände <&>"]


def square(channels, degree, seed=1):
    """A unit square of two triangles on patch 3, lit from its front."""
    random = np.random.default_rng(seed)
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    mesh = NodeMesh(
        vertices=vertices,
        positions=0.9 * vertices + 0.05,
        normals=np.tile([0.0, 0, 1], (4, 1)),
        frames_x=np.tile([1.0, 0, 0], (4, 1)),
        areas=np.array([1 / 3, 1 / 6, 1 / 3, 1 / 6]),
        materials=np.ones(4, dtype=np.int64),
        patches=np.full(4, 3),
        sides=np.full(4, -1),
        hidden=np.array([False, True, False, False]),
        triangles=np.array([[0, 1, 2], [0, 2, 3]]),
    )
    values = NodeValues(
        illuminance=random.random((4, channels)),
        std_error=random.random(4),
        direct=random.random((4, channels)),
        scalar_illuminance=random.random((4, channels)),
        light_vector=random.random((4, 3, channels)),
        sh_degree=np.array([0, degree, 0, 0]),
        truncation=np.array([0.0, 0.25 if degree else 0.0, 0.0, 0.0], dtype=np.float32),
        radiance_sh=random.random((4, (degree + 1) ** 2, channels), dtype=np.float32),
    )
    return mesh, values


def write_square(path, channels=1, degree=0, weights=None):
    mesh, values = square(channels, degree)
    write_field(
        path,
        mesh,
        values,
        exitance=0.5 * values.illuminance,
        luminance=0.25 * values.illuminance,
        material_names=NAMES,
        header=HEADER,
        weights=weights,
    )
    return mesh, values


def assert_same(found, expected):
    for field in dataclasses.fields(expected):
        one, other = getattr(found, field.name), getattr(expected, field.name)
        if other is None:
            assert one is None
            continue
        assert one.dtype == other.dtype, field.name
        np.testing.assert_array_equal(one, other, err_msg=field.name)


@pytest.mark.parametrize(("channels", "degree"), [(1, 0), (1, 3), (3, 0), (3, 2), (5, 1)])
def test_the_field_comes_back_as_it_was(tmp_path, channels, degree):
    path = tmp_path / "Büro mit Leerzeichen.vtp"
    mesh, values = write_square(path, channels, degree, weights=np.ones(5) if channels == 5 else None)
    mesh_again, values_again, header = read_field(path)
    assert_same(mesh_again, mesh)
    assert_same(values_again, values)
    assert header["material_names"] == NAMES
    assert {name: header[name] for name in HEADER} == HEADER


def test_field_has_what_was_promised(tmp_path):
    write_square(tmp_path / "field.vtp", channels=1, degree=2)
    field = pyvista.read(tmp_path / "field.vtp")
    assert set(field.point_data) >= CONTRACT_POINT_ARRAYS | {"radiance_sh"}
    assert set(field.cell_data) == {"material_id", "patch_id", "side"}
    assert set(field.field_data) == {"lelight", "material_names"}
    assert field.points.dtype == np.float64
    assert field.point_data["hidden"].dtype == np.uint8
    assert field.point_data["radiance_sh"].dtype == np.float32
    harmonics = field.GetPointData().GetArray("radiance_sh")
    assert [harmonics.GetComponentName(index) for index in range(9)] == [
        "Y_0_0", "Y_1_-1", "Y_1_0", "Y_1_1", "Y_2_-2", "Y_2_-1", "Y_2_0", "Y_2_1", "Y_2_2",
    ]  # fmt: skip
    told = json.loads(field.field_data["lelight"][0])
    assert {"version", "seed", "units", "up", "sh_convention", "inputs"} <= set(told)
    assert list(field.cell_data["side"]) == [-1, -1] and list(field.cell_data["patch_id"]) == [3, 3]


def test_colour_is_weighted_and_kept_channel_by_channel(tmp_path):
    _, values = write_square(tmp_path / "field.vtp", channels=3, degree=1)
    field = pyvista.read(tmp_path / "field.vtp")
    # ITU-R BT.709-6, item 3.2
    weighted = values.illuminance @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(field["illuminance_lx"], weighted, rtol=1e-15)
    np.testing.assert_allclose(field["luminance_cd_m2"], 0.25 * weighted, rtol=1e-15)
    np.testing.assert_allclose(field["exitance_lm_m2"], 0.5 * weighted, rtol=1e-15)
    assert field["light_vector_lx"].shape == (4, 3)
    assert "radiance_sh" not in field.point_data
    for channel, letter in enumerate("rgb"):
        np.testing.assert_array_equal(field[f"radiance_sh_{letter}"], values.radiance_sh[..., channel])


def test_coefficients_that_no_node_uses_are_not_stored(tmp_path):
    mesh, values = square(1, 4)
    diffuse = dataclasses.replace(values, sh_degree=np.zeros(4, dtype=np.int64))
    write_field(
        tmp_path / "field.vtp",
        mesh,
        diffuse,
        exitance=values.illuminance,
        luminance=values.illuminance,
        material_names=NAMES,
        header=HEADER,
    )
    _, again, _ = read_field(tmp_path / "field.vtp")
    np.testing.assert_array_equal(again.radiance_sh, values.radiance_sh[:, :1])


def test_a_node_without_triangles_comes_back_hidden(tmp_path):
    mesh, values = square(1, 0)
    write_field(
        tmp_path / "field.vtp",
        dataclasses.replace(mesh, triangles=mesh.triangles[:1]),
        values,
        exitance=values.illuminance,
        luminance=values.illuminance,
        material_names=NAMES,
        header=HEADER,
    )
    again, _, _ = read_field(tmp_path / "field.vtp")
    assert list(again.hidden) == [False, True, False, True]


@pytest.mark.parametrize("kept", [0.0, 0.01, 0.5, 0.99])
def test_a_truncated_field_is_refused_in_one_line(tmp_path, kept, capfd):
    path = tmp_path / "field.vtp"
    write_square(path)
    content = path.read_bytes()
    path.write_bytes(content[: int(kept * len(content))])
    with pytest.raises(OutputError, match="cut off") as caught:
        read_field(path)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""


def test_files_that_are_missing_or_not_ours_are_refused(tmp_path):
    with pytest.raises(OutputError, match="No such file"):
        read_field(tmp_path / "field.vtp")
    pyvista.Sphere().save(tmp_path / "sphere.vtp")
    with pytest.raises(OutputError, match="not a field of lelight: it has no appended data"):
        read_field(tmp_path / "sphere.vtp")
    (tmp_path / "other.vtp").write_text("<VTKFile>nonsense</VTKFile>", encoding="utf-8")
    with pytest.raises(OutputError, match=r"other\.vtp"):
        read_field(tmp_path / "other.vtp")


def grid(rows, columns, name="work plane"):
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.75)])
    illuminance = 100 + np.arange(x.size) / 3
    plane = MeasuringPlane(name, np.zeros(3), np.array([columns, 0, 0.0]), np.array([0, rows, 0.0]))
    return PlaneValues(
        plane=plane,
        shape=(rows, columns),
        points=points,
        illuminance=illuminance,
        std_error=0.01 * illuminance,
        cylindrical=0.3 * illuminance,
        replicates=illuminance[None],
        cylindrical_replicates=illuminance[None],
    )


def test_a_plane_is_a_surface_facing_its_normal_and_a_table(tmp_path):
    values = grid(3, 4)
    write_plane(tmp_path / "work plane.vtp", values)
    surface = pyvista.read(tmp_path / "work plane.vtp")
    # Points at the centres of 1 m cells: 2 x 3 quadrangles of 1 m² between them.
    assert surface.n_cells == 6
    assert surface.area == pytest.approx(6, rel=1e-12)
    np.testing.assert_allclose(surface.face_normals, np.tile(values.plane.normal, (6, 1)), atol=1e-12)
    np.testing.assert_array_equal(surface["cylindrical_illuminance_lx"], values.cylindrical)
    with (tmp_path / "work plane.csv").open(encoding="utf-8", newline="") as stream:
        header, *rows = list(csv.reader(stream))
    assert header == [
        "x_m", "y_m", "z_m", "illuminance_lx", "illuminance_std_error_lx", "cylindrical_illuminance_lx",
    ]  # fmt: skip
    expected = np.column_stack([values.points, values.illuminance, values.std_error, values.cylindrical])
    np.testing.assert_allclose(np.array(rows, dtype=float), expected, rtol=1e-9)


def test_a_plane_of_one_row_shows_its_points(tmp_path):
    write_plane(tmp_path / "line.vtp", grid(1, 5))
    assert pyvista.read(tmp_path / "line.vtp").n_verts == 5


def test_the_index_reaches_every_file_whatever_its_name(tmp_path):
    name = 'work "plane" & <1> Ü'
    (tmp_path / "planes").mkdir()
    files = {
        "field": {"field": tmp_path / "field.vtp"},
        "planes": {name: tmp_path / "planes" / "Ü & 1.vtp"},
        "luminaires": {"luminaires": tmp_path / "luminaires.vtp"},
        "observers": {"observers": tmp_path / "observers.vtp"},
    }
    write_square(tmp_path / "field.vtp")
    write_plane(files["planes"][name], grid(2, 2))
    lamp = PointLuminaire("L1", np.array([0, 0, 2.5]), np.array([100.0, 100, 100]))
    write_luminaires(tmp_path / "luminaires.vtp", [lamp])
    eye = Observer("desk ü", np.array([1.0, 2, 1.2]), np.array([0.0, 1, 0]))
    write_observers(tmp_path / "observers.vtp", [eye], length=2.0)
    write_index(tmp_path / "scene.vtm", files)
    moved = tmp_path.rename(tmp_path.with_name(tmp_path.name + " moved"))
    scene = pyvista.read(moved / "scene.vtm")
    assert scene.keys() == list(files)
    assert scene["planes"].keys() == [name]
    assert scene["field"]["field"].n_cells == 2 and scene["planes"][name].n_cells == 1
    luminaires, observers = scene["luminaires"][0], scene["observers"][0]
    assert luminaires["intensity_cd"][0] == pytest.approx(100) and luminaires["name"][0] == "L1"
    assert observers["name"][0] == "desk ü"
    np.testing.assert_allclose(observers.points[:2], [[1, 2, 1.2], [1, 4, 1.2]])


def test_no_luminaires_and_no_observers_make_empty_files(tmp_path):
    write_luminaires(tmp_path / "luminaires.vtp", [])
    write_observers(tmp_path / "observers.vtp", [])
    assert pyvista.read(tmp_path / "luminaires.vtp").n_points == 0
    assert pyvista.read(tmp_path / "observers.vtp").n_points == 0


def test_a_full_disk_is_told_as_such(tmp_path, monkeypatch):
    # Whatever is written to /dev/full is refused for want of space.
    monkeypatch.setattr("lelight.writing.polydata.whole", whole_on_a_full_disk)
    with pytest.raises(OutputError, match="disk is full"):
        write_square(tmp_path / "field.vtp")
    assert list(tmp_path.iterdir()) == []


@contextmanager
def whole_on_a_full_disk(path):
    with whole(path):
        yield Path("/dev/full")


def test_channels_weigh_as_their_number_says():
    assert luminance_weighted(np.array([[4.0]])) == 4
    assert luminance_weighted([1, 1, 1]) == pytest.approx(1, abs=1e-15)
    assert luminance_weighted([1, 2], weights=[3, 4]) == 11
    with pytest.raises(ValueError, match="4 channels"):
        luminance_weighted(np.ones(4))
    with pytest.raises(ValueError, match="shape"):
        luminance_weighted(np.ones(3), weights=np.ones(2))
    assert channel_suffixes(1) == ("",) and channel_suffixes(3) == ("_r", "_g", "_b")
    assert channel_suffixes(4) == ("_1", "_2", "_3", "_4")
