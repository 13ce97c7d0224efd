"""The folder that ``lelight calc`` leaves, and the commands that work on it."""

from __future__ import annotations

import ast
import csv
import json
import math
import os
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
import pyvista
from commandline import NASTY, QUICK, lelight
from radianceprograms import environment, program

from lelight.calculation import calculate
from lelight.reading.loading import load
from lelight.reports.texts import read_texts
from lelight.settings import PRESETS, Settings

#: The observer's name, fit to be a file's.
STEM = "a_b_ _üλ_ _x_"

POINT_ARRAYS = {
    "illuminance_lx": 1,
    "illuminance_std_error_lx": 1,
    "luminance_cd_m2": 1,
    "exitance_lm_m2": 1,
    "scalar_illuminance_lx": 1,
    "light_vector_lx": 3,
    "normal": 3,
    "sh_degree": 1,
    "frame_x": 3,
    "hidden": 1,
}
FILES = {
    "field.vtp",
    "luminaires.vtp",
    "metrics.csv",
    "metrics.json",
    f"observers/{STEM}.exr",
    f"observers/{STEM}.hdr",
    f"observers/{STEM}.png",
    "observers.vtp",
    "paraview.py",
    "planes/work plane.csv",
    "planes/work plane.vtp",
    "incident.npz",
    "replicates.npz",
    "run.json",
    "scene.vtm",
}


@pytest.fixture(scope="module")
def field(run):
    return pyvista.read(run.out / "field.vtp")


@pytest.fixture(scope="module")
def record(run):
    return json.loads((run.out / "run.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def metrics(run):
    return json.loads((run.out / "metrics.json").read_text(encoding="utf-8"))


def files(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir()}


def point_bytes(field_file: Path) -> dict[str, bytes]:
    arrays = pyvista.read(field_file).point_data
    return {name: np.asarray(arrays[name]).tobytes() for name in arrays}


def rms_error(field) -> float:
    """Root mean square by area of std_error / max(E, 5 % of the mean of E), over what is seen."""
    seen = field.point_data["hidden"] == 0
    illuminance, std_error, areas = (
        field.point_data[name][seen] for name in ("illuminance_lx", "illuminance_std_error_lx", "area_m2")
    )
    floor = 0.05 * np.average(illuminance, weights=areas)
    return math.sqrt(np.average((std_error / np.maximum(illuminance, floor)) ** 2, weights=areas))


def test_every_file_is_there_and_no_other(run, record):
    expected = set(FILES)
    if not any("overview.png: not drawn" in warning for warning in record["warnings"]):
        expected.add("overview.png")
    found = files(run.scene.parent)
    assert found == {f"room.lelight/{name}" for name in expected} | {"room.obj", "room.mtl", "room.toml"}
    assert all((run.scene.parent / name).stat().st_size > 0 for name in found)


def test_calc_says_what_it_did_on_stderr_only(run, record):
    assert run.outcome.stdout == ""
    lines = run.outcome.stderr.splitlines()
    assert lines[0].startswith("lelight: estimating: 1 replicates doubled 0 times, ")
    assert f"{record['nodes']} nodes, {record['replicates']} replicates" in lines[-5]
    assert lines[-4].startswith(f"relative standard error {record['error']['rms']:.2%} ")
    assert lines[-3] in record["bias"]
    assert re.fullmatch(r"work plane: Em \d+\.\d ± \d+\.\d lx", lines[-2])
    assert lines[-1] == f"results in {run.out}"


def test_field_has_the_promised_arrays(field):
    arrays = field.point_data
    for name, components in POINT_ARRAYS.items():
        shape = (field.n_points,) if components == 1 else (field.n_points, components)
        assert arrays[name].shape == shape, name
        assert np.isfinite(arrays[name]).all(), name
    assert {"material_id", "patch_id", "side"} <= set(field.cell_data.keys())
    assert set(np.unique(field.cell_data["side"])) <= {-1, 1}
    assert set(np.unique(arrays["hidden"])) <= {0, 1}
    assert (arrays["illuminance_lx"] > 0).all() and (arrays["illuminance_std_error_lx"] > 0).all()


def test_harmonics_are_named_one_by_one(field):
    degree = int(field.point_data["sh_degree"].max())
    array = field.GetPointData().GetAbstractArray("radiance_sh")
    names = [array.GetComponentName(index) for index in range(array.GetNumberOfComponents())]
    assert names == [f"Y_{n}_{m}" for n in range(degree + 1) for m in range(-n, n + 1)]
    # The lobe of exponent 12 gets the degree of exponent 16, ceil(sqrt(2 16 ln(1 / 0.001))) = 15.
    assert degree == 15
    materials = np.asarray(field.field_data["material_names"])[field.cell_data["material_id"]]
    glossy = np.unique(field.regular_faces[materials == "floor"])
    assert set(np.flatnonzero(field.point_data["sh_degree"])) == set(glossy)


def test_frames_are_orthonormal(field):
    normals, frames = field.point_data["normal"], field.point_data["frame_x"]
    for products, expected in (
        ((normals * normals).sum(axis=1), 1.0),
        ((frames * frames).sum(axis=1), 1.0),
        ((normals * frames).sum(axis=1), 0.0),
    ):
        np.testing.assert_allclose(products, expected, atol=1e-12)


def test_lambertian_exitance_is_reflectance_times_illuminance(field):
    walls = field.cell_data["material_id"] == list(field.field_data["material_names"]).index("wall")
    nodes = np.unique(field.regular_faces[walls])
    exitance = 0.6 * field.point_data["illuminance_lx"][nodes]
    np.testing.assert_allclose(field.point_data["exitance_lm_m2"][nodes], exitance, rtol=1e-9)
    np.testing.assert_allclose(field.point_data["luminance_cd_m2"][nodes], exitance / np.pi, rtol=1e-6)


def test_field_says_where_it_comes_from(field, record):
    (text,) = field.field_data["lelight"]
    told = json.loads(text)
    assert told["version"] == record["lelight"]
    assert told["seed"] == record["seed"] == 0
    assert told["up"] == "z" and told["units"]["illuminance"] == "lx"
    assert "no Condon-Shortley phase" in told["sh_convention"]
    assert told["files"] == record["files"] and set(told["files"]) == {"room.obj", "room.mtl", "room.toml"}
    assert list(field.field_data["material_names"]) == ["floor", "wall", "panel"]


def test_index_refers_to_files_that_are_there(run):
    tree = ElementTree.parse(run.out / "scene.vtm")
    blocks = {
        block.get("name"): {entry.get("name"): entry.get("file") for entry in block}
        for block in tree.getroot()[0]
    }
    assert blocks == {
        "field": {"field": "field.vtp"},
        "planes": {"work plane": "planes/work plane.vtp"},
        "luminaires": {"luminaires": "luminaires.vtp"},
        "observers": {"observers": "observers.vtp"},
    }
    assert [block.n_blocks for block in pyvista.read(run.out / "scene.vtm")] == [1, 1, 1, 1]


def test_every_figure_has_value_unit_error_and_method(metrics):
    plane, eye, room = metrics["planes"]["work plane"], metrics["observers"][NASTY], metrics["room"]
    figures = [
        (name, figure)
        for group in (plane, eye, room)
        for name, figure in group.items()
        if name not in {"file", "grid", "sources", "position", "direction"}
    ]
    for name, figure in figures:
        assert {"value", "unit", "std_error", "method"} <= set(figure), name
        assert figure.get("verdict", "absent") in {"pass", "fail", "undecided", "absent"}, name
    assert {"mean_illuminance", "uniformity", "mean_cylindrical_illuminance"} <= set(plane)
    assert {"ugr", "ugr_picture", "dgp", "background_luminance"} <= set(eye)
    assert [plane[name]["verdict"] for name in ("mean_illuminance", "uniformity")] != [None, None]
    assert plane["file"] == "work plane" and eye["file"] == STEM


def test_plane_files_agree_with_the_figures(run, metrics):
    plane = metrics["planes"]["work plane"]
    with (run.out / "planes" / "work plane.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    grid = pyvista.read(run.out / "planes" / "work plane.vtp").point_data
    assert len(rows) == plane["grid"]["rows"] * plane["grid"]["columns"] == len(grid["illuminance_lx"])
    columns = ("illuminance_lx", "illuminance_std_error_lx", "cylindrical_illuminance_lx")
    for column in columns:
        np.testing.assert_allclose([float(row[column]) for row in rows], grid[column], rtol=1e-9)
    assert np.mean(grid["illuminance_lx"]) == pytest.approx(plane["mean_illuminance"]["value"], rel=1e-9)
    assert [float(row["z_m"]) for row in rows] == [0.75] * len(rows)


def test_record_has_the_promised_keys(record):
    assert set(record) >= {
        *("plan", "settings", "seed", "seconds", "rays", "chains", "nodes"),
        *("error", "bias", "warnings", "versions"),
    }
    assert record["settings"]["edge"] == 0.5 and record["settings"]["preset"] == "draft"
    assert record["error"]["target"] == PRESETS["draft"].target
    assert record["error"]["met"] is True and record["error"]["rms"] <= PRESETS["draft"].target
    assert record["rays"] > record["nodes"] > 0
    assert record["scene_file"] == "../room.obj"


def test_stages_sum_up_to_the_total(record):
    stages = dict(record["seconds"])
    total = stages.pop("total")
    assert set(stages) == {"read", "remesh", "pilot", "estimate", "fit", "write"}
    assert sum(stages.values()) == pytest.approx(total, rel=0.02, abs=0.05)


def test_reported_error_is_that_of_the_field(field, record):
    assert record["nodes"] == field.n_points
    assert record["error"]["rms"] == pytest.approx(rms_error(field), rel=1e-9)
    assert record["convergence"][-1]["rms"] == record["error"]["rms"]


def test_exr_is_luminance(run):
    picture = OpenImageIO.ImageInput.open(str(run.out / "observers" / f"{STEM}.exr"))
    try:
        spec = picture.spec()
        assert tuple(spec.channelnames) == ("Y",)
        assert spec.format == OpenImageIO.FLOAT
        luminance = picture.read_image(OpenImageIO.FLOAT)[..., 0]
    finally:
        picture.close()
    assert np.isfinite(luminance).all() and (luminance >= 0).all()
    # The panel sends out its 4000 cd/m² and half of what falls on it.
    assert 4000 < luminance.max() < 4400


def test_hdr_header_has_view_and_exposure(run):
    head = (run.out / "observers" / f"{STEM}.hdr").read_bytes()[:400].split(b"\n\n")[0].decode()
    lines = head.splitlines()
    assert lines[0] == "#?RADIANCE" and "EXPOSURE=1.0" in lines
    (view,) = [line for line in lines if line.startswith("VIEW=")]
    assert "-vta" in view and "-vh 180" in view and "-vv 180" in view
    assert re.search(r"-vp 0\.3 1(\.0)? 1\.2 -vd 1(\.0)? 0(\.0)? 0(\.0)?", view)


def test_evalglare_reads_the_picture(run, metrics):
    told = subprocess.run(
        [program("evalglare"), "-d", run.out / "observers" / f"{STEM}.hdr"],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        env=environment(),
    )
    assert told.stderr == ""
    dgp = re.search(r"dgp,[^:]*: ([0-9.]+)", told.stdout)
    assert dgp is not None, told.stdout
    # Both are of the same picture; evalglare finds its glare sources by a threshold of its own.
    assert float(dgp[1]) == pytest.approx(metrics["observers"][NASTY]["dgp"]["value"], abs=0.02)


def test_paraview_script_knows_no_folder(run):
    text = (run.out / "paraview.py").read_text(encoding="utf-8")
    assert str(run.out) not in text and "Büro" not in text
    (table,) = [
        node.value
        for node in ast.parse(text).body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "SETTINGS"
    ]
    settings = ast.literal_eval(table)
    references = [
        settings["field"],
        *settings["planes"].values(),
        settings["luminaires"],
        settings["observers"],
    ]
    assert set(references) == {"field.vtp", "planes/work plane.vtp", "luminaires.vtp", "observers.vtp"}
    lower, upper = settings["range"]
    assert 0 < lower < upper


def test_paraview_opens_field_and_script(run, field):
    pvpython = shutil.which("pvpython")
    if pvpython is None:
        pytest.skip("ParaView (pvpython) is not installed")
    probe = (
        "import runpy, sys; from paraview import simple\n"
        "reader = simple.XMLPolyDataReader(FileName=[sys.argv[1] + '/field.vtp'])\n"
        "reader.UpdatePipeline()\n"
        "found = reader.PointData.keys()\n"
        "print('NODES', reader.GetDataInformation().GetNumberOfPoints(), 'illuminance_lx' in found)\n"
        "runpy.run_path(sys.argv[1] + '/paraview.py', run_name='__main__')\n"
        "print('SOURCES', sorted(name for name, _ in simple.GetSources()))\n"
    )
    script = run.scene.parent.parent / "probe.py"
    script.write_text(probe, encoding="utf-8")
    # ParaView brings a Python of its own: what configures ours must not reach it.
    environment = {name: text for name, text in os.environ.items() if not name.startswith("PYTHON")}
    told = subprocess.run(
        [pvpython, "--force-offscreen-rendering", script, run.out],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env={**environment, "QT_QPA_PLATFORM": "offscreen"},
    )
    assert told.returncode == 0 and "Traceback" not in told.stderr, told.stderr
    assert f"NODES {field.n_points} True" in told.stdout
    (line,) = [line for line in told.stdout.splitlines() if line.startswith("SOURCES ")]
    sources = set(ast.literal_eval(line.removeprefix("SOURCES ")))
    assert sources >= {"field", "field, visible nodes", "work plane", "luminaires", "observers"}


def test_the_same_seed_gives_the_same_bytes_with_any_threads(run, tmp_path):
    again = lelight("calc", run.scene, *QUICK, "--threads", "1", "--quiet", "-o", tmp_path / "again")
    assert (again.status, again.stdout, again.stderr) == (0, "", "")
    assert point_bytes(tmp_path / "again" / "field.vtp") == point_bytes(run.out / "field.vtp")


def test_another_seed_gives_another_estimate(run, field):
    settings = Settings(preset="draft", edge=0.5, seed=1)
    other = calculate(load(run.scene), settings).field
    np.testing.assert_array_equal(other.mesh.positions, field.points)
    spread = np.hypot(other.std_error, field.point_data["illuminance_std_error_lx"])
    apart = np.abs(other.illuminance - field.point_data["illuminance_lx"]) / spread
    # Two independent estimates of the same: nowhere equal, and apart by what they say of their error.
    assert (apart > 0).all()
    assert 0.5 < math.sqrt(np.mean(apart**2)) < 1.5


def test_metrics_prints_what_the_files_hold(run, metrics):
    assert json.loads(lelight("metrics", run.out, "--json").stdout) == metrics
    table = lelight("metrics", run.out, "--csv")
    assert table.stdout == (run.out / "metrics.csv").read_text(encoding="utf-8")
    text = lelight("metrics", run.out)
    assert (text.status, text.stderr) == (0, "")
    assert len(text.stdout.splitlines()) == len(table.stdout.splitlines()) - 1
    mean = metrics["planes"]["work plane"]["mean_illuminance"]
    told = f"{mean['value']:.4g} ± {2 * mean['std_error']:.2g} lx"
    assert re.search(
        rf"planes work plane +mean_illuminance +{re.escape(told)} {mean['verdict']}", text.stdout
    )


@pytest.mark.parametrize(
    ("arguments", "stem"),
    [
        (("--observer", NASTY), STEM),
        (("--view", "1,0.2,1.2:0,1,-0.2", "--projection", "perspective"), "view"),
    ],
    ids=["observer", "view"],
)
def test_render_takes_another_picture(run, copy, arguments, stem):
    told = lelight("render", copy, *arguments, "--size", "64")
    assert (told.status, told.stderr) == (0, "")
    assert told.stdout == f"{copy / 'renders' / stem}.png\n"
    assert files(copy / "renders") == {f"{stem}.exr", f"{stem}.hdr", f"{stem}.png"}


@pytest.mark.parametrize("kind", ["luminance", "glare"])
def test_reports_are_written_beside_the_results(copy, kind):
    told = lelight("report", kind, copy)
    assert (told.status, told.stderr) == (0, "")
    assert told.stdout == f"{copy / kind}.pdf\n"
    assert (copy / f"{kind}.pdf").read_bytes().startswith(b"%PDF-")


def test_every_figure_has_a_name_in_print(metrics):
    entries = [*metrics["planes"].values(), *metrics["observers"].values(), metrics["room"]]
    keys = {
        key
        for entry in entries
        for key, figure in entry.items()
        if isinstance(figure, dict) and "value" in figure
    }
    assert len(keys) > 50
    assert keys - set(read_texts().terms) == set()


@pytest.fixture
def copy(run):
    """The result in a folder of its own beside its scene, for commands that add to it."""
    folder = run.scene.with_name("copy.lelight")
    shutil.copytree(run.out, folder)
    yield folder
    shutil.rmtree(folder)


def test_render_refuses_another_scene_than_the_computed(run, copy, tmp_path):
    changed = tmp_path / "changed"
    shutil.copytree(run.scene.parent, changed)
    with (changed / "room.mtl").open("a", encoding="utf-8") as stream:
        stream.write("newmtl another\n")
    told = lelight("render", changed / "room.lelight", "--observer", NASTY)
    assert told.status == 1 and told.stdout == ""
    assert "changed since" in told.stderr and "run `lelight calc" in told.stderr
    assert told.stderr.count("\n") == 1


def test_check_tells_plan_lint_and_cost_on_stdout(run):
    told = lelight("check", run.scene, *QUICK)
    assert (told.status, told.stderr) == (0, "")
    titles = [line for line in told.stdout.splitlines() if line and not line.startswith(" ")]
    assert titles == ["Scene", "Plan", "Materials", "Lint", "A run will take"]
    assert "gloss of floor: harmonics of degree 15 by method sh" in told.stdout
    assert "1 point luminaires, 1 observers, 1 planes" in told.stdout
    assert "--adaptive" not in told.stdout
    assert "and what --adaptive adds" in lelight("check", run.scene, *QUICK, "--adaptive").stdout
