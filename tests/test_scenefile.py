"""Scene files: every key of the contract, and one line for every mistake."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lelight.errors import InputError
from lelight.reading.quantities import relative_error, seconds
from lelight.reading.scenefile import read_scene_file
from lelight.reading.scenetables import SceneTables

EVERYTHING = """
geometry = "office.obj"
unit = "mm"
up = "y"
[materials]
"*" = { reflectance = 0.5 }
"floor*" = { reflectance = [0.30, 0.22, 0.15], specular = 0.05, exponent = 32 }
"panel" = { luminance = 3000, sides = "front" }
"tube" = { flux = 3400, sides = "both" }
[[luminaires]]
name = "L1"
intensity = 100
position = [2.0, 1.5, 2.8]
aim = [0, 0, -1]
c0 = [1, 0, 0]
dimming = 0.5
maintenance = 0.8
[[observers]]
name = "desk 1"
position = [4.0, 3.0, 1.2]
direction = [1, 0, 0]
[[planes]]
name = "work plane"
origin = [0.5, 0.5, 0.75]
u = [9, 0, 0]
v = [0, 7, 0]
target = { mean_illuminance = 500, uniformity = 0.6, ugr = 19 }
[calc]
target = "2%"
time = "5min"
preset = "fine"
method = "grid"
edge = 0.25
seed = 7
threads = 2
memory = "3GB"
estimator = "emitters"
batches = 16
directions = 64
relightable = 100
extension = "even"
colour = "rgb"
degree = 11
angular = "all"
mirrors = "stored"
sides = "both"
indirect = true
residual = false
emitters = "all"
pictures = false
"""

LUMINAIRE = '[[luminaires]]\nname = "L"\nposition = [0, 0, 0]\n'
OBSERVER = '[[observers]]\nname = "a"\nposition = [0, 0, 0]\n'
PLANE = '[[planes]]\nname = "a"\norigin = [0, 0, 0]\n'


def read(folder: Path, text: str) -> SceneTables:
    path = folder / "Büro 1.toml"
    path.write_text(text, encoding="utf-8")
    return read_scene_file(path)


def complaint(folder: Path, text: str) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, text)
    message = str(caught.value)
    assert message.isprintable()
    return message.removeprefix(f"{folder / 'Büro 1.toml'}:")


def test_every_key_arrives(tmp_path: Path) -> None:
    tables = read(tmp_path, EVERYTHING)
    assert (tables.geometry, tables.unit, tables.up) == ("office.obj", "mm", "y")
    assert list(tables.materials) == ["*", "floor*", "panel", "tube"]
    assert tables.materials["floor*"].reflectance == (0.30, 0.22, 0.15)
    assert tables.materials["floor*"].specular == (0.05, 0.05, 0.05)
    assert tables.materials["panel"].luminance == (3000, 3000, 3000)
    assert (tables.materials["tube"].flux, tables.materials["tube"].sides) == (3400, "both")
    assert tables.luminaires[0].intensity == (100, 100, 100)
    assert (tables.luminaires[0].dimming, tables.luminaires[0].maintenance) == (0.5, 0.8)
    assert tables.observers[0].direction == (1, 0, 0)
    assert tables.planes[0].target.model_dump() == {"mean_illuminance": 500, "uniformity": 0.6, "ugr": 19}
    assert tables.calc.model_dump() == {
        "target": 0.02,
        "time": 300,
        "preset": "fine",
        "method": "grid",
        "edge": 0.25,
        "seed": 7,
        "threads": 2,
        "memory": 3e9,
        "estimator": "emitters",
        "adaptive": None,
        "batches": 16,
        "directions": 64,
        "relightable": 100.0,
        "extension": "even",
        "colour": "rgb",
        "degree": 11,
        "angular": "all",
        "mirrors": "stored",
        "sides": "both",
        "indirect": True,
        "residual": False,
        "emitters": "all",
        "pictures": False,
    }


def test_empty_file_means_the_defaults(tmp_path: Path) -> None:
    assert read(tmp_path, "\ufeff# nothing\r\n") == SceneTables()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('unit = "km"', ' unit: found "km"; allowed is'),
        ('up = "x"', ' up: found "x"; allowed is'),
        ("geometry = 1", " geometry: found 1; allowed is a valid string"),
        ("observer = 1", " observer: unknown key; did you mean observers? allowed are geometry, unit, up,"),
        (
            '[materials]\n"floor*" = { reflectance = 1.4 }',
            ' materials."floor*".reflectance: found 1.4; allowed are one number or three numbers from 0 to 1',
        ),
        ("[materials]\nweiß = { reflectance = [1, 2] }", "2: not TOML:"),
        (
            '[materials]\n"weiß" = { specular = [0.1, 0.2] }',
            ' materials."weiß".specular: found [0.1, 0.2]; allowed',
        ),
        (
            "[materials]\na = { reflectence = 0.4 }",
            " materials.a.reflectence: unknown key; did you mean reflectance? allowed are",
        ),
        ("[materials]\na = { luminance = 1, flux = 1 }", " materials.a: found"),
        (
            "[materials]\na = { exponent = -1 }",
            " materials.a.exponent: found -1; allowed is a number from 0 to 1e+06",
        ),
        (
            "[materials]\na = { luminance = nan }",
            " materials.a.luminance: found nan; allowed are one number or",
        ),
        ("[materials]\na = { flux = true }", " materials.a.flux: found True; allowed is a number from 0"),
        ('[materials]\na = { sides = "back" }', ' materials.a.sides: found "back"; allowed is'),
        ("[materials]\na = 3", " materials.a: found 3; allowed is a table"),
        ("luminaires = 3", " luminaires: found 3; allowed is a list of tables"),
        ('[[luminaires]]\nname = "L"', " luminaires[0].position: is missing; add it"),
        (LUMINAIRE, " luminaires[0]: found"),
        (LUMINAIRE + "intensity = -1", " luminaires[0].intensity: found -1; allowed are"),
        (
            LUMINAIRE + "intensity = 1\ndimming = 2",
            " luminaires[0].dimming: found 2; allowed is a number from 0 to 1",
        ),
        (
            LUMINAIRE + "intensity = 1\naim = [0, 0, 0]",
            " luminaires[0].aim: found (0.0, 0.0, 0.0); allowed is a vector",
        ),
        (
            OBSERVER + "direction = [0, 0, 0]",
            " observers[0].direction: found (0.0, 0.0, 0.0); allowed is a vector",
        ),
        ((OBSERVER + "direction = [1, 0, 0]\n") * 2, ' observers: found "a"; a name that is given twice'),
        ((PLANE + "u = [1, 0, 0]\nv = [0, 1, 0]\n") * 2, ' planes: found "a"; a name that is given twice'),
        (PLANE + "u = [1, 0, 0]\nv = [-2, 0, 0]", " planes[0]: found"),
        (PLANE + "u = [0, 0, 0]\nv = [1, 0, 0]", " planes[0].u: found (0.0, 0.0, 0.0); allowed is a vector"),
        (PLANE + "u = [1e-9, 0, 0]\nv = [0, 1, 0]", " planes[0]: found"),
        (
            PLANE + "u = [1, 0, 0]\nv = [0, 1, 0]\ntarget = { ugrr = 1 }",
            " planes[0].target.ugrr: unknown key; did you",
        ),
        ("[calc]\nbatches = 0", " calc.batches: found 0; allowed is greater than or equal to 2"),
        ('[calc]\nestimator = "x"', ' calc.estimator: found "x"; allowed is'),
        ("[calc]\nthreads = 1.5", " calc.threads: found 1.5; allowed is a valid integer"),
        ('[calc]\ntarget = "200%"', ' calc.target: found "200%"; allowed is a share like 0.02 or "2%"'),
        ('[calc]\ntime = "5 hours"', ' calc.time: found "5 hours"; allowed is a time like 60'),
        (f"[calc]\nedge = {'9' * 400}", " calc.edge: found 999"),
        ("unit =\n", "1: not TOML: Invalid value"),
        ('\nunit = "', "2: not TOML: Unterminated string"),
        (f"a = {'[' * 5000}", " tables are nested too deeply"),
        (f"a = {'9' * 5000}", " not TOML:"),
    ],
)
def test_mistakes_name_key_or_line(tmp_path: Path, text: str, says: str) -> None:
    assert complaint(tmp_path, text).startswith(says)


def test_a_file_in_another_encoding_names_the_line(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes('unit = "m"\n# weiß\n'.encode("latin-1"))
    with pytest.raises(InputError, match=r"a\.toml:2: is not UTF-8 text; save the file as UTF-8$"):
        read_scene_file(path)


@pytest.mark.parametrize(
    ("written", "share"), [("2%", 0.02), (" 0.5 % ", 0.005), (0.02, 0.02), ("0.02", 0.02)]
)
def test_relative_errors(written: object, share: float) -> None:
    assert relative_error(written) == pytest.approx(share, rel=1e-15)


@pytest.mark.parametrize(
    "written", ["0%", "100%", 0, 1, -0.1, True, None, "", "2 %%", "1.2.3%", float("nan"), [1]]
)
def test_what_is_no_relative_error(written: object) -> None:
    with pytest.raises(ValueError, match="allowed is a share"):
        relative_error(written)


@pytest.mark.parametrize(
    ("written", "time"), [("60s", 60), ("5min", 300), ("1.5 h", 5400), (60, 60), ("60", 60), (0.5, 0.5)]
)
def test_times(written: object, time: float) -> None:
    assert seconds(written) == time


@pytest.mark.parametrize("written", ["0s", "-1s", "5 hours", 0, True, None, "", "s", float("inf"), "9" * 400])
def test_what_is_no_time(written: object) -> None:
    with pytest.raises(ValueError, match="allowed is a time"):
        seconds(written)


def test_mutated_files_are_read_or_refused_in_one_line(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    letters = list("019-.e[]{}\"'=,\n\\ aé\x00")
    outcomes = {"read": 0, "refused": 0}
    for _ in range(300):
        text = list(EVERYTHING)
        text[rng.integers(len(text))] = letters[rng.integers(len(letters))]
        try:
            read(tmp_path, "".join(text))
        except InputError as error:
            assert str(error).isprintable()
            outcomes["refused"] += 1
        else:
            outcomes["read"] += 1
    assert min(outcomes.values()) > 20
