"""Speed against accuracy: closed forms recognised, errors measured, the front, and the command with its files."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commandline import ROOM_OBJ, lelight, write_room
from rooms import furnace, grey, lamp, lit
from shapes import box, icosphere

import lelight as library
from lelight.analytic.known import known_illuminance
from lelight.calculation import calculate
from lelight.fielderror import illuminance_at, relative_rms, sample_points
from lelight.paretofront import front_error, pareto_front, slope
from lelight.pipelines import sweep
from lelight.pipelines.judging import in_words
from lelight.settings import Settings

SCENES = Path(__file__).parents[1] / "scenes"


@pytest.mark.parametrize(
    ("name", "points", "expected"),
    [
        ("furnace", [[1.0, 1.0, 0.0]], [785.398]),
        # Published on discs: sobolev.toml and sobolev_offset.toml; upper plane 2 m above the lower.
        ("sobolev", [[0, 0, 0], [2, 0, 0], [0, 5, 2]], [1.131955454, 0.163276183, 0.024537148]),
        ("sobolev_offset", [[1, 0, 0], [0, 1, 2]], [0.524639748, 0.418711615]),
    ],
)
def test_scenes_with_closed_forms_are_recognised(name, points, expected):
    found = known_illuminance(library.load(SCENES / f"{name}.toml"))
    assert found is not None
    points = np.array(points, dtype=float)
    assert np.allclose(found[1](points, np.zeros_like(points)), expected, rtol=2e-6)


def test_the_sphere_is_recognised_wherever_it_lies():
    points, faces = icosphere(2)
    scene = lit(
        (points + 5.0, faces[:, ::-1]), materials=[grey("s", 0.5)], luminaires=(lamp((5.0, 5.0, 5.0)),)
    )
    facing = points[faces].mean(axis=1)
    inward = np.einsum(
        "tx,tx->t", np.cross(*(scene.corners[:, [k]] - scene.corners[:, [0]] for k in (1, 2)))[:, 0], facing
    )
    found = known_illuminance(
        scene if inward.max() < 0 else replace(scene, triangles=scene.triangles[:, ::-1])
    )
    assert found is not None
    # E = I / r² + rho Phi / (A (1 - rho)): 100 lx and about as much again.
    assert found[1](np.array([[6.0, 5.0, 5.0]]), np.array([[-1.0, 0.0, 0.0]])) == pytest.approx(
        200.0, rel=0.05
    )


@pytest.mark.parametrize(
    "spoilt",
    [
        lambda scene: replace(
            scene, triangles=scene.triangles[1:], triangle_materials=scene.triangle_materials[1:]
        ),
        lambda scene: replace(scene, luminaires=(lamp((0.5, 0.5, 0.5)),)),
        lambda scene: replace(scene, materials=(replace(scene.materials[0], specular=np.full(3, 0.1)),)),
    ],
    ids=["open", "lamp", "glossy"],
)
def test_a_furnace_that_is_none_is_not_taken_for_one(spoilt):
    assert known_illuminance(furnace(0.5)) is not None
    assert known_illuminance(spoilt(furnace(0.5))) is None


def test_the_error_of_a_field_is_measured_where_it_lies():
    run = calculate(furnace(0.5), Settings(edge=0.5, batches=8, target=0.2, threads=2))
    at = sample_points(run.field.mesh, count=256)
    assert np.all(np.einsum("kdx,kx->kd", at.directions, at.normals) > 0)
    found = illuminance_at(run.field.mesh, run.field.values, at)
    exact = np.full(256, 2.0)
    error = relative_rms(found, exact)
    assert 0.0 < error < 1.5 * run.error.rms
    assert relative_rms(1.3 * found, exact) > 0.25


def test_points_lie_on_half_hidden_triangles_where_there_are_no_others():
    mesh = calculate(furnace(0.5), Settings(edge=0.5, batches=8, target=0.2, threads=2)).field.mesh
    seen = mesh.triangles[0, 0]
    mesh = replace(mesh, hidden=np.arange(len(mesh)) != seen)
    at = sample_points(mesh, count=64)
    around = mesh.vertices[mesh.triangles[(mesh.triangles == seen).any(axis=1)]]
    longest = np.linalg.norm(around - np.roll(around, 1, axis=1), axis=2).max()
    assert np.linalg.norm(at.points - mesh.vertices[seen], axis=1).max() <= longest
    assert set(at.patches) == {mesh.patches[seen]}


def test_the_front_holds_what_nothing_beats():
    seconds, errors = np.array([1.0, 2.0, 3.0, 4.0, 2.0]), np.array([0.4, 0.2, 0.25, 0.1, 0.3])
    assert pareto_front(seconds, errors).tolist() == [True, True, False, True, False]
    assert front_error(seconds, errors, 2.0) == pytest.approx(0.2)
    assert front_error(seconds, errors, 8.0**0.5) == pytest.approx(0.02**0.5)
    assert front_error(seconds, errors, 100.0) == pytest.approx(0.1)


def test_slopes_are_those_of_power_laws():
    seconds = np.array([1.0, 3.0, 9.0])
    assert slope(seconds, 0.3 * seconds**-0.5) == pytest.approx(-0.5)
    assert slope(seconds[:1], seconds[:1]) is None


def test_words_name_the_knob_that_pays_most():
    runs = [
        {
            "knob": "preset",
            "value": "draft",
            "error": 0.1,
            "predicted_error": 0.2,
            "cpu_seconds": 3.0,
            "front": True,
        }
    ]
    told = in_words(runs, {"chains": -0.1, "mesh": -1.0, "degree": 0.2})
    assert told[0] == "Mesh pays most: twice the time leaves 0.50 of the error."
    assert "Degree: more time brings nothing." in told
    assert "Preset draft: error 10.00% in 3 processor seconds, on the front." in told
    other = runs[0] | {"knob": "mesh", "error": 0.125}
    (preset,) = [line for line in in_words([*runs, other], {}) if line.startswith("Preset")]
    assert preset.endswith("on the front, 0.80 of the error of the other runs' front in the same time.")


def test_a_sweep_turns_degree_and_method_only_where_something_is_glossy():
    knobs = {each.knob for each in sweep.variations(lit(box(), materials=[grey("w", 0.5)]))}
    assert knobs == {"chains", "mesh", "preset"}
    glossy = lit(box(), materials=[grey("w", 0.5, specular=0.1, exponent=20.0)])
    found = sweep.variations(glossy)
    assert {each.knob for each in found} == {*knobs, "degree", "method"}
    assert len({each.stem for each in found}) == len(found)


def test_the_command_sweeps_goes_on_and_writes_all_files(tmp_path, monkeypatch):
    scene = write_room(tmp_path, obj=ROOM_OBJ, toml="")
    # The middle of the dial alone, on a coarse mesh; a budget that has room for no more once it is spent.
    few = [
        sweep.Variation("mesh", f"edge x {s}", f"edge-{s}", {"target": 0.3, "edge": 0.5 * s}, s)
        for s in (2.0, 1.0)
    ]
    monkeypatch.setattr("lelight.pipelines.tradeoff.variations", lambda _: few)
    monkeypatch.setattr(
        "lelight.pipelines.tradeoff.REFERENCE", {"target": 0.1, "edge": 0.4, "pictures": False}
    )
    out = tmp_path / "t"
    outcome = lelight("tradeoff", scene, "-o", out, "--time", "5min", "--threads", "2")
    assert outcome.status == 0, outcome.stderr
    assert "2 of 2" in outcome.stderr
    record = json.loads((out / "tradeoff.json").read_text(encoding="utf-8"))
    assert [row["value"] for row in record["runs"]] == ["edge x 2.0", "edge x 1.0"]
    for row in record["runs"]:
        assert 0.0 < row["error"] < 1.0
        assert row["cpu_seconds"] > 0.5
        assert row["memory"] > 1e8
        assert row["size"] > 1e4
    with (out / "tradeoff.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 2
    assert (out / "tradeoff.pdf").read_bytes().startswith(b"%PDF")
    assert (out / "pareto.svg").exists()
    again = lelight("tradeoff", scene, "-o", out, "--time", "5min", "--threads", "2")
    assert again.status == 0, again.stderr
    assert again.stderr.count("done before") == 3
    assert again.stdout == outcome.stdout


def test_a_budget_without_room_for_a_run_is_refused_in_one_line(tmp_path):
    scene = write_room(tmp_path, toml="")
    outcome = lelight("tradeoff", scene, "--against", tmp_path / "nothing", "--time", "1s")
    assert outcome.status == 1
    assert outcome.stderr.strip().splitlines()[-1].startswith("lelight: ")
    assert "Traceback" not in outcome.stderr
