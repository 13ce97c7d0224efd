"""The command line: its help, its exit codes, what it refuses and how it is interrupted."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import click
import pytest
from commandline import NASTY, QUICK, ROOM_MTL, ROOM_OBJ, ROOM_TOML, lelight, process, write_room

from lelight.cli.main import COMMANDS

README = Path(__file__).parents[1] / "README.md"


def command_of(name: str) -> click.Command:
    """The command behind ``lelight NAME``; of a group, one of its own: ``photometry info``."""
    first, *rest = name.split()
    command = import_module(f"lelight.cli.{first}").command
    assert isinstance(command, click.Command)
    return command.commands[rest[0]] if rest else command


def command_lines() -> list[str]:
    """Names of all commands, a group's as ``photometry info``."""
    names = []
    for name in sorted(COMMANDS):
        command = command_of(name)
        inner = sorted(command.commands) if isinstance(command, click.Group) else None
        names += [name] if inner is None else [f"{name} {one}" for one in inner]
    return names


def options_of(name: str) -> list[set[str]]:
    """Spellings of every option of a command but --help."""
    return [set(option.opts) for option in command_of(name).params if isinstance(option, click.Option)]


def spellings_in(text: str) -> set[str]:
    return set(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", text))


def usage_lines() -> dict[str, str]:
    """Usage of each command in the README's section on them; a line that goes on is indented."""
    section = re.search(r"^## Commands\n+```\w*\n(.*?)^```", README.read_text(encoding="utf-8"), re.M | re.S)
    assert section is not None, "README.md has no usage lines under ## Commands"
    joined = re.sub(r"\n\s+", " ", section[1])
    lines = [line for line in joined.splitlines() if line.startswith("lelight ")]
    return {_command_in(line): line for line in lines}


def _command_in(line: str) -> str:
    words = line.split()[1:3]
    return " ".join(words) if " ".join(words) in command_lines() else words[0]


@pytest.mark.parametrize("name", command_lines())
def test_help_and_readme_know_the_same_options(name):
    told = lelight(*name.split(), "--help")
    assert (told.status, told.stderr) == (0, "")
    described = usage_lines()
    assert name in described, f"README.md, ## Commands: no line for lelight {name}"
    in_help, in_readme = spellings_in(told.stdout), spellings_in(described[name])
    options = options_of(name)
    assert [spellings for spellings in options if not spellings & in_readme] == []
    assert in_readme <= set().union(*options) <= in_help


def test_readme_knows_no_other_commands():
    assert set(usage_lines()) == set(command_lines())


def test_help_lists_every_command():
    told = lelight("--help")
    assert told.status == 0
    listed = re.findall(r"^  ([a-z]+)  ", told.stdout.partition("Commands:")[2], re.M)
    assert listed == sorted(COMMANDS)
    assert lelight("-h").stdout == told.stdout


def test_version_is_that_of_the_package():
    from lelight import __version__

    assert lelight("--version").stdout == f"lelight, version {__version__}\n"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((), "Usage: lelight "),
        (("paint",), "No such command 'paint'"),
        (("calc",), "Missing argument 'SCENE'"),
        (("calc", ""), "the path is empty"),
        (("calc", "a.obj", "-o", ""), "the path is empty"),
        (("calc", "b\udcff.obj"), "is not UTF-8"),
        (("calc", "a.obj", "--colour"), "No such option"),
        (("calc", "a.obj", "--target", "0"), "above 0 and below 1"),
        (("calc", "a.obj", "--target", "150%"), "above 0 and below 1"),
        (("calc", "a.obj", "--time", "-1"), "allowed is a time like 60"),
        (("calc", "a.obj", "--time", "1 fortnight"), "allowed is a time like 60"),
        (("calc", "a.obj", "--edge", "nan"), "allowed is a length in m, above 0"),
        (("calc", "a.obj", "--edge", "inf"), "allowed is a length in m, above 0"),
        (("calc", "a.obj", "--edge", "1e300"), "allowed is a length in m, above 0"),
        (("calc", "a.obj", "--edge", "short"), "allowed is a length in m, above 0"),
        (("calc", "a.obj", "--seed", "9223372036854775808"), "is not in the range"),
        (("calc", "a.obj", "--threads", "0"), "is not in the range"),
        (("calc", "a.obj", "--directions", "1000000000"), "is not in the range"),
        (("calc", "a.obj", "--preset", "rough"), "'draft', 'normal', 'fine'"),
        (("render", "out"), "--observer NAME or --view"),
        (("render", "out", "--view", "1,2,3:0,0,0"), "with a direction"),
        (("render", "out", "--view", "1,2,nan:0,0,1"), "not finite"),
        (("render", "out", "--view", "1,2:0,0,1"), "X,Y,Z:DX,DY,DZ"),
        (("report", "colour", "out"), "'luminance', 'glare'"),
        (("report", "glare", "out", "--language", "xx"), "allowed: en"),
    ],
)
def test_misuse_ends_with_2_and_says_what_is_allowed(arguments, told):
    outcome = lelight(*arguments)
    assert outcome.status == 2 and outcome.stdout == ""
    assert told in outcome.stderr and "Traceback" not in outcome.stderr


def assert_refused(outcome, remedy: str) -> None:
    """One line on stderr that names the remedy, nothing on stdout."""
    assert (outcome.status, outcome.stdout) == (1, "")
    assert outcome.stderr.startswith("lelight: ") and outcome.stderr.count("\n") == 1, outcome.stderr
    assert re.search(remedy, outcome.stderr), outcome.stderr


def edited(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new)


DARK_TOML = edited(ROOM_TOML, "intensity = 100", "intensity = 0")
DARK_MTL = edited(ROOM_MTL, "Ke 4000 4000 4000", "")

BAD_SCENES = {
    "without light": ({"mtl": DARK_MTL, "toml": DARK_TOML}, r"room\.obj: no light: .*add \[\[luminaires\]\]"),
    "empty obj": ({"obj": ""}, r"room\.obj: has no faces"),
    "nan vertex": (
        {"obj": edited(ROOM_OBJ, "v 2 2 0", "v 2 nan 0")},
        r"room\.obj:4: v: .*allowed are finite",
    ),
    "huge vertex": ({"obj": edited(ROOM_OBJ, "v 2 2 0", "v 2 1e300 0")}, r"room\.obj:4: v: .*allowed are"),
    "far away": (
        {"obj": edited(ROOM_OBJ, "v 2 2 0", "v 2 1e11 0")},
        r"room\.obj: .*check the unit, which is m",
    ),
    "index past the end": (
        {"obj": edited(ROOM_OBJ, "f 1 2 3 4", "f 1 2 3 99")},
        r"room\.obj:15: f: found vertex number 99; allowed are 1 to 12",
    ),
    "index zero": (
        {"obj": edited(ROOM_OBJ, "f 1 2 3 4", "f 0 2 3 4")},
        r"room\.obj:15: f: .*allowed are 1 to",
    ),
    "two corners": (
        {"obj": edited(ROOM_OBJ, "f 1 2 3 4", "f 1 2")},
        r"room\.obj:15: f: .*allowed are 3 or more",
    ),
    "no area": ({"obj": "v 0 0 0\nf 1 1 1\n"}, r"room\.obj: no face has an area; .*check"),
    "missing mtl": ({"mtl": None}, r'room\.obj:1: mtllib: "room\.mtl" is not in the folder .*put it there'),
    "reflectance 1.4": (
        {"mtl": edited(ROOM_MTL, "Kd 0.6 0.6 0.6", "Kd 1.4 1.4 1.4")},
        r'"wall" \(room\.mtl:5\): found reflectance 1\.4 .*lower Kd or Ks',
    ),
    "diffuse and specular above 1": (
        {"mtl": edited(ROOM_MTL, "Ks 0.2 0.2 0.2", "Ks 0.8 0.8 0.8")},
        r'"floor" .*allowed is a sum of at most 1',
    ),
    "nan reflectance": ({"mtl": edited(ROOM_MTL, "Kd 0.6", "Kd nan")}, r"room\.mtl:6: Kd: .*finite numbers"),
    "negative emission": ({"mtl": edited(ROOM_MTL, "Ke 4000", "Ke -1")}, r"room\.mtl:9: Ke: .*0 or more"),
    "unknown key": (
        {"toml": "lumminaires = 3\n" + ROOM_TOML},
        r"room\.toml: lumminaires: unknown key; did you mean luminaires\?",
    ),
    "unknown key of a table": ({"toml": "[calc]\nmetod = 'sh'"}, r"room\.toml: calc\.metod: .*mean method\?"),
    "broken toml": ({"toml": "unit = "}, r"room\.toml:1: not TOML"),
    "unit of nobody": ({"toml": 'unit = "ell"'}, r"room\.toml: unit: found \"ell\"; allowed is 'm', "),
    "one batch": ({"toml": "[calc]\nbatches = 1"}, r"room\.toml: calc\.batches: found 1; allowed is .* 2"),
    "endless edge": ({"toml": "[calc]\nedge = 1e300"}, r"room\.toml: calc\.edge: .*above 0"),
    "edge of nothing": (
        {"toml": "[calc]\nedge = 1e-200"},
        r"room\.obj: an edge of 1e-200 m .*longer --edge",
    ),
    "endless plane": (
        {"toml": edited(ROOM_TOML, "u = [1, 0, 0]", "u = [1e6, 0, 0]")},
        r"room\.toml: planes\[0\]: .* points; allowed are 10000; give a shorter",
    ),
    "plane without area": (
        {"toml": edited(ROOM_TOML, "u = [1, 0, 0]", "u = [0, 2, 0]")},
        r"room\.toml: planes\[0\]: .*parallel; allowed are",
    ),
    "observer without direction": (
        {"toml": edited(ROOM_TOML, "direction = [1, 0, 0]", "direction = [0, 0, 0]")},
        r"room\.toml: observers\[0\]\.direction: .*allowed is a vector that is not zero",
    ),
    "nan position": (
        {"toml": edited(ROOM_TOML, "position = [0.5, 0.5, 1.5]", "position = [nan, 0, 0]")},
        r"room\.toml: luminaires\[0\]\.position: .*allowed are three numbers",
    ),
    "the same name twice": (
        {"toml": ROOM_TOML + ROOM_TOML[ROOM_TOML.index("[[observers]]") : ROOM_TOML.index("[[planes]]")]},
        r"room\.toml: observers: .*given twice; allowed are different names",
    ),
    "lamp that shines at nothing": (
        {"obj": ROOM_OBJ[: ROOM_OBJ.index("usemtl floor")] + "usemtl panel\nf 12 11 10 9\n", "toml": ""},
        r"no surface receives light; check where the lamps are",
    ),
}


@pytest.mark.parametrize(("files", "remedy"), BAD_SCENES.values(), ids=BAD_SCENES.keys())
def test_a_bad_scene_is_refused_in_one_line(tmp_path, files, remedy):
    scene = write_room(tmp_path / "Büro 1", **files)
    assert_refused(lelight("calc", scene, "--preset", "draft", "-o", tmp_path / "out"), remedy)
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize(
    ("name", "content", "remedy"),
    [
        ("missing.obj", None, r"missing\.obj: no such file; check the name"),
        ("missing.toml", None, r"missing\.toml: no such file; check the name"),
        ("room", b"", r'room: found the ending ""; allowed are \.obj and \.toml'),
        ("room.stl", b"solid", r'room\.stl: found the ending "\.stl"; allowed are \.obj and \.toml'),
        ("binary.obj", bytes(range(256)) * 9, r"binary\.obj: found zero bytes, .*allowed is a text file"),
        ("noise.obj", bytes(range(128, 256)) * 9, r"noise\.obj: has no faces"),
        ("binary.toml", bytes(range(128, 256)), r"binary\.toml:1: is not UTF-8 text; save"),
    ],
)
def test_what_is_no_scene_is_refused_in_one_line(tmp_path, name, content, remedy):
    scene = tmp_path / name
    if content is not None:
        scene.write_bytes(content)
    before = sorted(tmp_path.iterdir())
    for command in ("calc", "check"):
        assert_refused(lelight(command, scene), remedy)
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_is_no_scene(tmp_path):
    (tmp_path / "room.obj").mkdir()
    assert_refused(lelight("calc", tmp_path / "room.obj"), r"room\.obj: is a folder; give the file itself")
    assert_refused(lelight("calc", tmp_path), r"allowed are \.obj and \.toml")
    assert [path.name for path in tmp_path.iterdir()] == ["room.obj"]


@pytest.mark.parametrize(
    ("out", "remedy"),
    [
        ("file", "a file stands where the folder should be: move it away or choose another folder with -o"),
        ("file/out", "a part of its path is a file, not a folder: choose another folder with -o"),
        ("o" * 300, "the path is too long: choose a shorter folder name with -o"),
    ],
)
def test_results_that_cannot_be_written_are_refused_before_the_run(tmp_path, out, remedy):
    scene = write_room(tmp_path / "scene")
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    assert_refused(lelight("calc", scene, *QUICK, "-o", tmp_path / out), re.escape(remedy))
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"
    assert {path.name for path in tmp_path.iterdir()} == {"scene", "file"}


@pytest.mark.parametrize(
    "command",
    [
        ("metrics",),
        ("render", "--view", "1,1,1:1,0,0"),
        ("report", "luminance"),
        ("report", "glare"),
    ],
    ids=" ".join,
)
def test_what_is_no_result_folder_is_refused_in_one_line(tmp_path, command):
    (tmp_path / "file").write_text("", encoding="utf-8")
    (tmp_path / "empty").mkdir()
    (tmp_path / "damaged").mkdir()
    for name in ("run.json", "metrics.json"):
        (tmp_path / "damaged" / name).write_text("[1, 2", encoding="utf-8")
    for name in ("missing", "file", "empty", "damaged"):
        assert_refused(lelight(*command, tmp_path / name), rf"{name}.*`lelight calc ")
    assert not list((tmp_path / "empty").iterdir())


def test_a_name_that_no_observer_has_is_refused(run):
    told = lelight("render", run.out, "--observer", "nobody")
    assert_refused(told, r"no observer 'nobody'; there are: a/b")
    assert not (run.out / "renders").exists()


def test_a_target_out_of_reach_is_a_warning(tmp_path):
    scene = write_room(tmp_path)
    told = lelight("calc", scene, *QUICK, "--time", "1s", "--target", "0.5%", "--quiet")
    assert (told.status, told.stdout) == (0, "")
    assert re.fullmatch(r"lelight: warning: target 0\.50% not reached, got \d+\.\d\d%\n", told.stderr)
    record = json.loads((tmp_path / "room.lelight" / "run.json").read_text(encoding="utf-8"))
    assert record["error"]["met"] is False and record["error"]["rms"] > record["error"]["target"] == 0.005
    (warning,) = record["warnings"]
    assert warning.startswith("target not reached") and warning.endswith("give more --time")


@pytest.fixture(scope="module")
def overridden(tmp_path_factory):
    """A run whose scene file asks for one thing and whose command line for another."""
    toml = '[calc]\nseed = 3\npreset = "fine"\nmethod = "grid"\nedge = 1\nbatches = 2\n'
    mtl = edited(ROOM_MTL, "newmtl wall\n", "newmtl wall\nillum 2\nd 0.5\n")
    scene = write_room(tmp_path_factory.mktemp("overridden"), mtl=mtl, toml=toml)
    told = lelight("calc", scene, "--seed", "0", "--preset", "normal", "--method", "sh")
    assert told.status == 0, told.stderr
    return told, json.loads((scene.parent / "room.lelight" / "run.json").read_text(encoding="utf-8"))


def test_the_command_line_wins_over_the_scene_file(overridden):
    # Even with a value that happens to be the default.
    _, record = overridden
    expected = {"seed": 0, "preset": "normal", "method": "sh", "edge": 1, "batches": 2, "target": 0.02}
    assert {name: record["settings"][name] for name in expected} == expected


def test_warnings_of_the_scene_are_told(overridden):
    told, record = overridden
    ignored = "room.mtl: illum, d carry no photometric meaning here and are ignored"
    assert told.stderr.splitlines().count(f"lelight: warning: {ignored}") == 1
    assert record["warnings"].count(ignored) == 1


def test_data_that_the_terminal_cannot_show_are_escaped(run):
    command = [sys.executable, "-c", "from lelight.cli.main import main; main()", "metrics", run.out]
    environment = {**os.environ, "PYTHONIOENCODING": "latin-1"}
    told = subprocess.run(command, capture_output=True, check=True, env=environment, cwd=README.parent)
    # Latin-1 has ü and ² and no λ.
    assert told.stderr == b""
    assert b'observers a/b: "\xfc\\u03bb" <x>' in told.stdout and b"cd/m\xb2" in told.stdout


def test_a_run_that_cannot_finish_leaves_no_record_of_another(tmp_path):
    scene = write_room(tmp_path, toml=ROOM_TOML + "[calc]\nbatches = 2\nedge = 1\n")
    out = tmp_path / "room.lelight"
    out.mkdir()
    for name in ("run.json", "metrics.json"):
        (out / name).write_text("{}", encoding="utf-8")
    (out / "observers").write_text("mine", encoding="utf-8")
    told = lelight("calc", scene)
    assert told.status == 1 and told.stdout == ""
    assert re.search(r"observers: cannot be written: a file stands where the folder", told.stderr)
    assert not {"run.json", "metrics.json"} & {path.name for path in out.iterdir()}
    assert_refused(lelight("render", out, "--observer", NASTY), r"run\.json: No such file .*`lelight calc ")
    assert [path.name for path in out.rglob(".*")] == []


def interrupted(running: subprocess.Popen[str]) -> tuple[int, str, str, float]:
    """Send SIGINT; exit status, what is told from then on, seconds until the end."""
    begun = time.perf_counter()
    running.send_signal(signal.SIGINT)
    stdout, stderr = running.communicate(timeout=30)
    return running.returncode, stdout, stderr, time.perf_counter() - begun


def test_ctrl_c_ends_a_run_in_time_and_in_one_line(tmp_path):
    scene = write_room(tmp_path, toml="[calc]\nbatches = 1000000\n")
    running = process("calc", scene, *QUICK)
    assert running.stderr is not None
    assert running.stderr.readline().startswith("lelight: estimating: 1 replicates doubled 0 times, ")
    status, stdout, stderr, seconds = interrupted(running)
    kept = tmp_path / "room.lelight" / "checkpoint"
    assert (status, stdout) == (130, "") and seconds < 2.0
    assert stderr == f"lelight: interrupted; what was done is kept in {kept}, --resume goes on\n"
    assert list((tmp_path / "room.lelight").iterdir()) == [kept]


def test_ctrl_c_does_not_wait_for_a_loop_that_does_not_let_go():
    # The pool waits for its thread when the block ends, here for a minute.
    code = (
        "import time\nfrom concurrent.futures import ThreadPoolExecutor\n"
        "from lelight.cli.interruption import end_in_time\n"
        "with end_in_time(), ThreadPoolExecutor(1) as pool:\n"
        "    task = pool.submit(time.sleep, 60)\n    print('ready', flush=True)\n    task.result()\n"
    )
    running = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert running.stdout is not None and running.stdout.readline() == "ready\n"
    status, stdout, stderr, seconds = interrupted(running)
    assert (status, stdout, stderr) == (130, "", "lelight: interrupted\n")
    assert seconds < 2.0
