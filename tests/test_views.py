"""The overview: drawn where OpenGL is, a line of warning where it is not."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import OpenImageIO
import pytest
from matplotlib import colormaps

from lelight.mesh.nodes import NodeMesh
from lelight.results import NodeValues
from lelight.writing import views
from lelight.writing.views import partly_seen, robust_range, shown_values, write_overview
from lelight.writing.vtkfiles import write_field

GL_HINT = "libegl1 or libosmesa6"


def write_floor_and_ceiling(path):
    """A floor of 100 lx whose front is up, under a ceiling of 500 lx whose front is down, both 4 m x 3 m."""
    floor = np.array([[0.0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]])
    corners = np.concatenate([floor, floor[::-1] + np.array([0, 0, 2.5])])
    light = np.repeat([100.0, 500.0], 4)[:, None]
    mesh = NodeMesh(
        vertices=corners,
        positions=corners,
        normals=np.repeat([[0.0, 0, 1], [0, 0, -1]], 4, axis=0),
        frames_x=np.tile([1.0, 0, 0], (8, 1)),
        areas=np.ones(8),
        materials=np.zeros(8, dtype=np.int64),
        patches=np.repeat([0, 1], 4),
        sides=np.ones(8, dtype=np.int64),
        hidden=np.zeros(8, dtype=bool),
        triangles=np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]),
    )
    values = NodeValues(
        illuminance=light,
        std_error=light[:, 0],
        direct=light,
        scalar_illuminance=light,
        light_vector=np.zeros((8, 3, 1)),
        sh_degree=np.zeros(8, dtype=np.int64),
        radiance_sh=np.zeros((8, 1, 1), dtype=np.float32),
        truncation=np.zeros(8, dtype=np.float32),
    )
    write_field(path, mesh, values, exitance=light, luminance=light, material_names=["a"], header={})


def test_one_looks_under_the_ceiling_onto_the_floor(tmp_path):
    folder = tmp_path / "Büro 1"
    folder.mkdir()
    write_floor_and_ceiling(folder / "field.vtp")
    warning = write_overview(folder / "overview.png", folder / "field.vtp")
    if warning is not None and GL_HINT in warning:
        told = subprocess.run(
            views._command(folder / "field.vtp", tmp_path / "again.png"),
            capture_output=True,
            text=True,
            check=False,
        ).stderr
        assert "Traceback" not in told or "ImportError" in told, told
        pytest.skip(f"no OpenGL off screen here: {warning}")
    assert warning is None
    assert sorted(file.name for file in folder.iterdir()) == ["field.vtp", "overview.png"]
    pixels = (255 * OpenImageIO.ImageBuf(str(folder / "overview.png")).get_pixels(OpenImageIO.FLOAT)).round()
    # The floor has the colour of the scale's lower end; nothing left of the legend has the ceiling's.
    picture = pixels[:, :1150, :3]
    lowest, highest = (np.round(255 * np.array(colormaps["viridis"](end)[:3])) for end in (0.0, 1.0))
    assert np.all(np.abs(picture - lowest) <= 2, axis=-1).mean() > 0.1
    assert not np.all(np.abs(picture - highest) <= 2, axis=-1).any()


@pytest.mark.parametrize(
    "code",
    ["import os; os.abort()", "raise ImportError('libGL.so.1')", "pass"],
    ids=["the interpreter dies", "a library is missing", "nothing is drawn"],
)
def test_without_opengl_there_is_a_line_that_names_the_package(tmp_path, monkeypatch, code):
    monkeypatch.setattr(views, "_command", lambda *_: [sys.executable, "-c", code])
    warning = write_overview(tmp_path / "overview.png", tmp_path / "field.vtp")
    assert warning is not None and GL_HINT in warning and "\n" not in warning
    assert list(tmp_path.iterdir()) == []


def test_a_child_that_hangs_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(views, "_command", lambda *_: [sys.executable, "-c", "import time; time.sleep(60)"])
    monkeypatch.setattr(views, "TIME_LIMIT", 0.5)
    warning = write_overview(tmp_path / "overview.png", tmp_path / "field.vtp")
    assert warning is not None and "within" in warning and GL_HINT in warning


def test_a_broken_field_is_not_blamed_on_opengl(tmp_path):
    (tmp_path / "field.vtp").write_text("<VTKFile>", encoding="utf-8")
    warning = write_overview(tmp_path / "overview.png", tmp_path / "field.vtp")
    assert warning is not None and "field.vtp: cut off" in warning and GL_HINT not in warning


def test_a_missing_folder_is_a_warning_too(tmp_path):
    warning = write_overview(tmp_path / "gone" / "overview.png", tmp_path / "field.vtp")
    assert warning is not None and "folder does not exist" in warning


def test_the_range_spans_the_visible_nodes_but_for_five_percent_at_either_end():
    illuminance = np.concatenate([np.arange(101.0), [1e9, np.nan]])
    hidden = np.zeros(103, dtype=bool)
    hidden[101] = True
    assert robust_range(illuminance, hidden) == pytest.approx((5, 95))


def test_the_range_of_a_flat_or_empty_field_still_spans_something():
    for illuminance in (np.full(4, 300.0), np.zeros(4), np.zeros(0)):
        lower, upper = robust_range(illuminance, np.zeros(len(illuminance), dtype=bool))
        assert lower < upper


def test_hidden_nodes_are_shown_by_their_visible_neighbours():
    """And triangles that have none are not shown."""
    triangles = np.array([[0, 1, 2], [1, 2, 3], [0, 4, 5]])
    hidden = np.array([True, False, False, False, True, True])
    values = np.array([0.0, 10.0, 20.0, 30.0, 0.0, 0.0])
    np.testing.assert_array_equal(partly_seen(triangles, hidden), [True, True, False])
    np.testing.assert_array_equal(shown_values(triangles, values, hidden), [15, 10, 20, 30, 0, 0])
