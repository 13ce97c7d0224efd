"""The ParaView script: run by ParaView itself where it is installed."""

from __future__ import annotations

import ast
import json
import os
import shutil
import subprocess

import numpy as np
import pytest
from commandline import NASTY
from vtkmodules.numpy_interface import dataset_adapter
from vtkmodules.vtkCommonDataModel import vtkPolyData
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

from lelight.mesh.nodes import NodeMesh
from lelight.nodelight import seen_from
from lelight.pipelines.render import stored_field
from lelight.results import NodeValues
from lelight.scene import Observer, PointLuminaire
from lelight.writing.paraview import write_paraview_script
from lelight.writing.vtkfiles import write_field, write_luminaires, write_observers

TITLE = "Büro 'a' \"b\" \\ {x} @SETTINGS@\n'''"

#: Appended to the script: tells what ParaView has opened.
PROBE = """
import json
found = {
    name: [source.GetDataInformation().GetNumberOfPoints(), source.GetDataInformation().GetNumberOfCells()]
    for (name, _), source in simple.GetSources().items()
}
colours = simple.GetColorTransferFunction("illuminance_lx")
legend = simple.GetScalarBar(colours, simple.GetActiveView())
told = {"sources": found, "legend": legend.Title, "range": [colours.RGBPoints[0], colours.RGBPoints[-4]]}
print("TOLD " + json.dumps(told))
"""


def write_result(folder):
    """Two triangles, of which one touches a hidden node, with a lamp, an eye and two planes."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    mesh = NodeMesh(
        vertices=corners,
        positions=corners,
        normals=np.tile([0.0, 0, 1], (4, 1)),
        frames_x=np.tile([1.0, 0, 0], (4, 1)),
        areas=np.full(4, 0.25),
        materials=np.zeros(4, dtype=np.int64),
        patches=np.zeros(4, dtype=np.int64),
        sides=np.ones(4, dtype=np.int64),
        hidden=np.array([False, True, False, False]),
        triangles=np.array([[0, 1, 2], [0, 2, 3]]),
    )
    light = np.array([[100.0], [0], [300], [400]])
    values = NodeValues(
        illuminance=light,
        std_error=0.01 * light[:, 0],
        direct=light,
        scalar_illuminance=light,
        light_vector=np.zeros((4, 3, 1)),
        sh_degree=np.zeros(4, dtype=np.int64),
        radiance_sh=np.ones((4, 1, 1), dtype=np.float32),
        truncation=np.zeros(4, dtype=np.float32),
    )
    (folder / "planes").mkdir(parents=True)
    planes = {'work "plane"\\': folder / "planes" / "work.vtp", "Flur ü": folder / "planes" / "Flur ü.vtp"}
    for path in (folder / "field.vtp", *planes.values()):
        write_field(path, mesh, values, exitance=light, luminance=light, material_names=["a"], header={})
    write_luminaires(folder / "luminaires.vtp", [PointLuminaire("L1", corners[0], np.ones(3))])
    write_observers(folder / "observers.vtp", [Observer("eye", corners[0], corners[1])])
    write_paraview_script(
        folder / "paraview.py",
        title=TITLE,
        field=folder / "field.vtp",
        illuminance_range=(120.0, 390.0),
        planes=planes,
        luminaires=folder / "luminaires.vtp",
        observers=folder / "observers.vtp",
        eyes=[Observer('eye "1"', np.array([0.5, -2.0, 1.0]), np.array([0.0, 1.0, 0.0]))],
    )


def settings(script):
    tree = ast.parse(script.read_text(encoding="utf-8"))
    (table,) = [
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "SETTINGS"
    ]
    return ast.literal_eval(table)


def test_names_are_data_and_paths_are_relative(tmp_path):
    folder = tmp_path / "Büro 1.lelight"
    write_result(folder)
    assert settings(folder / "paraview.py") == {
        "title": TITLE,
        "legend": "Illuminance (lx)",
        "range": [120.0, 390.0],
        "field": "field.vtp",
        "planes": {'work "plane"\\': "planes/work.vtp", "Flur ü": "planes/Flur ü.vtp"},
        "luminaires": "luminaires.vtp",
        "observers": "observers.vtp",
        "eyes": {'eye "1"': [0.5, -2.0, 1.0]},
        "channels": {"radiance_sh": 1.0},
    }
    assert str(tmp_path) not in (folder / "paraview.py").read_text(encoding="utf-8")


def test_what_a_scene_does_not_have_is_left_out(tmp_path):
    write_paraview_script(
        tmp_path / "paraview.py", title="t", field=tmp_path / "field.vtp", illuminance_range=(0, 1)
    )
    found = settings(tmp_path / "paraview.py")
    assert (found["planes"], found["luminaires"], found["observers"]) == ({}, None, None)


def test_luminance_toward_an_eye_is_that_of_the_field(run):
    """What ParaView is given to run, run on the file by VTK's own Python wrapping of data sets."""
    tree = ast.parse((run.out / "paraview.py").read_text(encoding="utf-8"))
    (code,) = [
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "LUMINANCE"
    ]
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(run.out / "field.vtp"))
    reader.Update()
    source = dataset_adapter.WrapDataObject(reader.GetOutput())
    output = dataset_adapter.WrapDataObject(vtkPolyData())
    output.ShallowCopy(reader.GetOutput())
    eye = settings(run.out / "paraview.py")["eyes"][NASTY]
    names: dict[str, object] = {}
    exec(code, names)
    names["add_luminance"](source, output, eye, settings(run.out / "paraview.py")["channels"])
    found = np.asarray(output.PointData["luminance_toward_eye_cd_m2"])
    field = stored_field(run.out)
    away = np.array(eye) - field.mesh.positions
    away /= np.linalg.norm(away, axis=1)[:, None]
    facing = np.sum(away * field.mesh.normals, axis=1) > 0
    for node in np.flatnonzero(facing)[::7]:
        parts = seen_from(field, node, away[[node]])
        assert found[node] == pytest.approx(parts.stored[0] + parts.emitted, rel=1e-5, abs=1e-6)
    assert not found[~facing].any()
    assert field.emission.max() > 0 and field.values.sh_degree.max() > 0


def run_in_paraview(folder, cwd, script="paraview.py", *arguments):
    pvpython = shutil.which("pvpython")
    if pvpython is None:
        pytest.skip("ParaView (pvpython) is not installed")
    # ParaView brings a Python of its own: what configures ours must not reach it.
    environment = {name: text for name, text in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.run(
        [pvpython, "--force-offscreen-rendering", str(folder / script), *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=cwd,
        env={**environment, "QT_QPA_PLATFORM": "offscreen"},
    )


@pytest.mark.parametrize("inside", [True, False], ids=["run in its folder", "run from elsewhere"])
def test_paraview_opens_everything_after_the_folder_moved(tmp_path, inside):
    write_result(tmp_path / "first")
    folder = (tmp_path / "first").rename(tmp_path / "Büro 1.lelight")
    script = folder / "paraview.py"
    script.write_text(script.read_text(encoding="utf-8") + PROBE, encoding="utf-8")
    before = sorted(folder.rglob("*"))
    run = run_in_paraview(folder, folder if inside else tmp_path)
    assert run.returncode == 0, run.stderr
    assert "Traceback" not in run.stderr
    (line,) = [line for line in run.stdout.splitlines() if line.startswith("TOLD ")]
    told = json.loads(line.removeprefix("TOLD "))
    assert told["legend"] == "Illuminance (lx)"
    assert told["range"] == pytest.approx([120, 390])
    assert told["sources"]["field"] == [4, 2]
    # Of two triangles the one with the hidden node goes.
    assert told["sources"]["field, visible nodes"] == [3, 1]
    assert told["sources"]['work "plane"\\'] == told["sources"]["Flur ü"] == [4, 2]
    assert told["sources"]["luminaires"] == [1, 1] and told["sources"]["observers"] == [4, 1]
    assert sorted(folder.rglob("*")) == before


def test_paraview_saves_the_picture_that_is_asked_for(tmp_path):
    if not os.environ.get("DISPLAY"):
        pytest.skip("no display, which a ParaView that is built for X needs to draw")
    write_result(tmp_path / "out")
    picture = tmp_path / "view.png"
    run = run_in_paraview(tmp_path / "out", tmp_path, "paraview.py", str(picture))
    assert run.returncode == 0, run.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")
