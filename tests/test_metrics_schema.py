"""``metrics.json`` of real runs keeps to its schema, and the schema refuses what is wrong."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from commandline import NASTY, QUICK, ROOM_TOML, lelight, write_room

SCHEMA = json.loads(
    (Path(__file__).parents[1] / "lelight" / "metrics" / "metrics.schema.json").read_text(encoding="utf-8")
)

#: Everything that a scene file can ask of the figures.
DEMANDING = """
[materials]
"floor" = { reflectance = "floor.csv" }
"panel" = { luminance = 4000, spectrum = "lamp.spdx" }

[[luminaires]]
name = "lamp"
position = [0.5, 0.5, 1.5]
intensity = 100
maintenance = 0.8
spectrum = "F11"

[[observers]]
name = "down"
position = [0.3, 1.0, 1.2]
direction = [1, 0, -0.1]
task = [1.0, 1.0, 0.75]
threshold = "5 x task"

[[planes]]
name = "work plane"
origin = [0.3, 0.3, 0.75]
u = [1.4, 0, 0]
v = [0, 1.4, 0]
wall_band = 0.2
surrounding = 0.2
background = 3
target = { task = "writing", mean_illuminance = 100 }

[outdoor]
plane = "work plane"
reflectance = 0.3
"""
SPDX = """<?xml version="1.0"?>
<IESTM2714 xmlns="http://www.ies.org/iestm2714"><SpectralDistribution>
<SpectralData wavelength="380">0.1</SpectralData>
<SpectralData wavelength="580">1.0</SpectralData>
<SpectralData wavelength="780">0.3</SpectralData>
</SpectralDistribution></IESTM2714>
"""


@pytest.fixture(scope="module")
def metrics(run):
    return json.loads((run.out / "metrics.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def demanding(tmp_path_factory):
    scene = write_room(tmp_path_factory.mktemp("spectral"), toml=DEMANDING)
    (scene.parent / "floor.csv").write_text("nm,reflectance\n380,0.1\n780,0.5\n", encoding="utf-8")
    (scene.parent / "lamp.spdx").write_text(SPDX, encoding="utf-8")
    outcome = lelight("calc", scene, *QUICK, "--threads", "2")
    assert outcome.status == 0, outcome.stderr
    return json.loads((scene.with_name("room.lelight") / "metrics.json").read_text(encoding="utf-8"))


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


def test_a_plain_run_keeps_to_the_schema(metrics):
    jsonschema.validate(metrics, SCHEMA)
    eye = metrics["observers"][NASTY]
    assert eye["melanopic_edi"]["value"] is None
    assert "needs spectra" in eye["melanopic_edi"]["note"]


def test_a_demanding_run_keeps_to_the_schema(demanding):
    jsonschema.validate(demanding, SCHEMA)
    plane, eye = demanding["planes"]["work plane"], demanding["observers"]["down"]
    assert plane["mean_illuminance"]["target"] == 100.0
    assert plane["mean_cylindrical_illuminance"]["target"] == 150.0
    assert plane["ra"]["target"] == 80.0
    # 100 lx on the task ask for 100 lx around it, and a third of that in the background.
    assert plane["surrounding_mean_illuminance"]["target"] == 100.0
    assert plane["background_mean_illuminance"]["target"] == pytest.approx(100 / 3)
    assert plane["grid"]["wall_band"] == 0.2
    assert "1 m" in plane["grid"]["rule"]
    assert demanding["room"]["maintenance_factor"]["value"] == 0.8
    assert demanding["room"]["wall_illuminance"]["target"] == 150.0
    assert eye["gr"]["value"] is not None and eye["gr"]["std_error"] > 0
    for figures in (plane, eye):
        assert {"cct", "duv", "ra", "r9", "rf", "rg", "melanopic_edi", "melanopic_der"} <= set(figures)
        assert 2000 < figures["cct"]["value"] < 7000


def test_intervals_are_students(metrics):
    figure = metrics["planes"]["work plane"]["mean_illuminance"]
    low, high = figure["interval"]
    assert low < figure["value"] < high
    assert (low + high) / 2 == pytest.approx(figure["value"], rel=1e-12)
    assert 1.96 < (high - low) / 2 / figure["std_error"] < 3.2


@pytest.mark.parametrize(
    "spoil",
    [
        lambda m: m["room"].pop("maintenance_factor"),
        lambda m: m["planes"]["work plane"]["uniformity"].update(verdict="maybe"),
        lambda m: m["planes"]["work plane"]["uniformity"].pop("target"),
        lambda m: m["planes"]["work plane"].update(extra=3),
        lambda m: m["observers"][NASTY]["ugr"].update(value=None),
        lambda m: m["views"][NASTY]["rose"].pop(),
        lambda m: m["observers"][NASTY]["sources"][0].pop("share"),
    ],
)
def test_the_schema_refuses_what_is_wrong(metrics, spoil):
    wrong = copy.deepcopy(metrics)
    spoil(wrong)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, SCHEMA)


def test_the_rose_begins_with_the_observers_own_rating(metrics):
    eye, petals = metrics["observers"][NASTY], metrics["views"][NASTY]["rose"]
    assert petals[0]["ugr"] == pytest.approx(eye["ugr"]["value"], rel=1e-12)
    rated = [petal["ugr"] for petal in petals if petal["ugr"] is not None]
    assert eye["ugr_max"]["value"] == max(rated)
    assert np.isclose(petals[0]["background_luminance"], eye["background_luminance"]["value"])


@pytest.mark.parametrize(
    ("toml", "told"),
    [
        (ROOM_TOML + '[materials]\npanel = { spectrum = "D65" }\n', "no spectrum"),
        (ROOM_TOML + '[materials]\npanel = { spectrum = "D66" }\n', "CIE illuminant"),
        (ROOM_TOML + '[materials]\nwall = { reflectance = "gone.csv" }\n', "gone.csv"),
        (ROOM_TOML + '[outdoor]\nplane = "gone"\nreflectance = 0.2\n', "no such plane"),
        (ROOM_TOML.replace("ugr = 19", 'task = "typing"'), "no such task"),
        (ROOM_TOML.replace("v = [0, 1, 0]", "v = [0, 1, 0]\nwall_band = 0.5"), "wall_band"),
        (
            ROOM_TOML.replace("direction = [1, 0, 0]", 'direction = [1, 0, 0]\nthreshold = "5 x sky"'),
            "threshold",
        ),
    ],
)
def test_mistakes_are_told_in_one_line(tmp_path, toml, told):
    outcome = lelight("check", write_room(tmp_path, toml=toml))
    assert outcome.status == 1
    assert told in outcome.stderr
    assert len(outcome.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ("400,0.5\n700,1.5\n", "at most 1"),
        ("700,0.5\n400,0.5\n", "ascend"),
        ("400,0.5\n", "two or more"),
        ("400,0.5\n700,-1\n", "0 or more"),
        ("0.4,0.5\n0.7,0.5\n", "400 to 700 nm"),
        ("400,0.5\n500;x\n700,0.5\n", "two numbers"),
    ],
)
def test_impossible_spectra_are_refused(tmp_path, table, told):
    toml = ROOM_TOML + '[materials]\nwall = { reflectance = "wall.csv" }\n'
    scene = write_room(tmp_path, toml=toml)
    (tmp_path / "wall.csv").write_text(table, encoding="utf-8")
    outcome = lelight("check", scene)
    assert outcome.status == 1
    assert told in outcome.stderr
