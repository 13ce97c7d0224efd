"""Runs that are stopped, killed or cut off go on where they were and end in the same bits; what is wrong is said."""

from __future__ import annotations

import json
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from commandline import ROOM_TOML, lelight, write_room
from mutations import mutated
from test_determinism import COLOURED, bits, differing

from lelight.calculation import calculate
from lelight.checkpoint import keeper
from lelight.checkpoint.folder import CheckpointFolder
from lelight.checkpoint.identity import differences, identity_of
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import ARRAY, Record, form_of
from lelight.checkpoint.segments import read_segment, write_segment
from lelight.checkpoint.stop import Stop
from lelight.errors import OutputError
from lelight.estimate.blocks import Effort
from lelight.reading.loading import load
from lelight.settings import Settings
from lelight.writing.vtpreading import read_polydata

#: Long enough for replicates that double, and short.
SETTINGS = Settings(edge=0.7, target=0.022, threads=2, adaptive=True)
IDENTITY = {"versions": {"lelight": "0"}, "settings": {"seed": 1}, "files": {"room.obj": "ab"}}


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    scene = load(write_room(tmp_path_factory.mktemp("room"), toml=ROOM_TOML + COLOURED))
    run = calculate(scene, SETTINGS)
    assert run.replicates.doublings >= 1 and run.replicates.count >= 8
    return scene, bits(run), run


class Killed(BaseException):
    """The end of a process that has no time to write anything."""


class StopAfter(Stop):
    """Stops, or kills, at one of the moments at which a run looks whether to stop."""

    def __init__(self, looks: int, ending: type[BaseException]) -> None:
        super().__init__()
        self.left, self.ending = looks, ending

    def check(self) -> None:
        self.left -= 1
        if self.left < 0:
            raise self.ending


@pytest.mark.parametrize(("ending", "interval"), [(KeyboardInterrupt, 1e9), (Killed, 0.0)])
def test_a_run_cut_off_many_times_ends_in_the_same_bits(room, tmp_path, monkeypatch, ending, interval):
    """Stopped, it has everything; killed, it has what was written, here every piece at once."""
    scene, expected, whole = room
    monkeypatch.setattr(keeper, "INTERVAL", interval)
    monkeypatch.setattr(keeper, "SHARE_OF_RUN", 0.0)
    monkeypatch.setattr(keeper, "TIMES_LAST_WRITING", 0.0)
    rng = random.Random(1)
    identity = identity_of(scene, SETTINGS)
    parts, run = 0, None
    while run is None:
        parts += 1
        folder = CheckpointFolder(tmp_path / "checkpoint", identity)
        if folder.exists:
            folder.open()
        try:
            stop = StopAfter(rng.randrange(10, 150), ending)
            run = calculate(scene, SETTINGS, keep=Keeper(folder, stop=stop))
        except ending:
            pass
    assert parts > 3
    assert differing(expected, bits(run)) == []
    assert [(each.replicates, each.doublings, each.rays) for each in run.convergence] == [
        (each.replicates, each.doublings, each.rays) for each in whole.convergence
    ]


def test_what_the_clock_has_decided_is_not_decided_again(room, tmp_path):
    """Of the time that is asked for, all is spent before the kill: the run ends where it stood."""
    scene = room[0]
    settings = Settings(edge=0.5, time=2.0, threads=2)
    identity = identity_of(scene, settings)
    first = calculate(scene, settings, keep=Keeper(CheckpointFolder(tmp_path / "checkpoint", identity)))
    folder = CheckpointFolder(tmp_path / "checkpoint", identity)
    folder.open()
    again = calculate(scene, settings, keep=Keeper(folder))
    assert again.convergence == first.convergence
    assert differing(bits(first), bits(again)) == []
    assert again.seconds["estimate"] >= first.seconds["estimate"]


def test_a_folder_without_work_left_is_empty_but_for_the_newest(room, tmp_path, monkeypatch):
    """What has been superseded does not pile up."""
    scene = room[0]
    monkeypatch.setattr(keeper, "INTERVAL", 0.0)
    monkeypatch.setattr(keeper, "SHARE_OF_RUN", 0.0)
    monkeypatch.setattr(keeper, "TIMES_LAST_WRITING", 0.0)
    settings = Settings(edge=0.7, batches=3, threads=1)
    folder = CheckpointFolder(tmp_path / "checkpoint", identity_of(scene, settings))
    calculate(scene, settings, keep=Keeper(folder))
    kept = {key for path in folder.path.glob("*.kept") for key in read_segment(path).entries}
    assert kept == {"mesh", "clear share", "base", "known direct", "lack", "effort", "course"}
    folder.remove()
    assert list(tmp_path.iterdir()) == []


def kept_file(path: Path) -> Path:
    few = np.array([0, 255], dtype=np.uint8)
    record = Record(
        {"bound": 0.1}, {"light": np.arange(6.0).reshape(2, 3), "lit": np.array([True, False]), "few": few}
    )
    write_segment(path, {"run": "x"}, {"a/0": record, "b": Record()})
    return path


def test_records_come_back_as_they_were(tmp_path):
    segment = read_segment(kept_file(tmp_path / "000001.kept"))
    found = segment.read("a/0")
    assert found.values == {"bound": 0.1} and segment.head == {"run": "x"}
    assert np.array_equal(found.arrays["light"], np.arange(6.0).reshape(2, 3))
    assert found.arrays["lit"].dtype == np.bool_ and found.arrays["lit"].tolist() == [True, False]
    assert found.arrays["few"].dtype == np.uint8 and found.arrays["few"].tolist() == [0, 255]
    effort = Effort(5, 2, 3, 1 / 3)
    assert form_of(Effort).unpack(form_of(Effort).pack(effort)) == effort
    with pytest.raises(ValueError, match="no type that a checkpoint holds"):
        write_segment(tmp_path / "x", {}, {"a": ARRAY.pack(np.array([object()]))})


def test_any_damage_to_a_segment_is_noticed(tmp_path):
    path = kept_file(tmp_path / "000001.kept")
    sound = path.read_bytes()
    rng = np.random.default_rng(3)
    cases = [sound[:k] + bytes([sound[k] ^ 1]) + sound[k + 1 :] for k in range(len(sound))]
    cases += [sound[:k] for k in range(len(sound))] + [mutated(sound, rng) for _ in range(2000)]
    for case in cases:
        if case == sound:
            continue
        path.write_bytes(case)
        with pytest.raises(OutputError) as caught:
            read_segment(path)
        assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_everything_in_which_two_runs_differ_is_named():
    other = {
        "versions": {"lelight": "1", "numpy": "2"},
        "settings": {"seed": 2},
        "files": {"room.obj": "cd", "room.mtl": "ef"},
    }
    assert differences(IDENTITY, IDENTITY) == []
    assert differences(IDENTITY, other) == [
        "file room.mtl was not there",
        "file room.obj has changed",
        "--seed was 1, is 2",
        "lelight was version 0, is 1",
        "numpy was version not given, is 2",
    ]


def slow(*arguments: str | Path, interval: float = 0.2) -> subprocess.Popen[str]:
    """A run as a process of its own that writes often."""
    code = (
        "from lelight.checkpoint import keeper\n"
        f"keeper.INTERVAL, keeper.TIMES_LAST_WRITING = {interval}, 0.0\n"
        "from lelight.cli.main import main\nmain()\n"
    )
    return subprocess.Popen(
        [sys.executable, "-c", code, "calc", *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        cwd=Path(__file__).parents[1],
    )


#: A run of some seconds.
LONG = ("--edge", "0.5", "--target", "2%", "--preset", "draft")


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    """A scene, and the field of a run of it that nobody disturbed."""
    scene = write_room(tmp_path_factory.mktemp("long"), toml=ROOM_TOML + COLOURED)
    begun = time.perf_counter()
    outcome = lelight("calc", scene, *LONG, "--threads", "2")
    assert outcome.status == 0, outcome.stderr
    field = read_polydata(scene.with_name("room.lelight") / "field.vtp")
    shutil.rmtree(scene.with_name("room.lelight"))
    return scene, field, time.perf_counter() - begun


def same_field(out: Path, expected) -> bool:
    found = read_polydata(out / "field.vtp")
    return {name: array.tobytes() for name, array in found.point_arrays.items()} == {
        name: array.tobytes() for name, array in expected.point_arrays.items()
    }


@pytest.mark.parametrize("seed", [1, 2])
def test_a_killed_run_goes_on_to_the_same_bits(long, tmp_path, seed):
    scene, expected, seconds = long
    rng = random.Random(seed)
    out = tmp_path / "out"
    for threads in ("1", "4"):
        with slow(scene, "-o", out, "--resume", *LONG, "--threads", threads) as running:
            with suppress(subprocess.TimeoutExpired):
                running.communicate(timeout=rng.uniform(0.5, seconds))
            running.kill()
    outcome = lelight("calc", scene, "-o", out, "--resume", *LONG, "--threads", "2")
    assert outcome.status == 0, outcome.stderr
    assert same_field(out, expected)
    assert not (out / "checkpoint").exists() and [path.name for path in out.rglob(".*")] == []
    told = lelight("calc", scene, "-o", out, "--resume", *LONG)
    assert (told.status, told.stderr) == (0, f"lelight: {out} is finished: nothing to do\n")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_stop_a_run_in_time_with_its_state(long, tmp_path, number):
    scene, expected, _ = long
    out = tmp_path / "out"
    running = slow(scene, "-o", out, *LONG, interval=1e9)
    assert running.stderr is not None
    assert running.stderr.readline().startswith("lelight: estimating: 1 replicates")
    begun = time.perf_counter()
    running.send_signal(number)
    stderr = running.communicate(timeout=30)[1]
    assert running.returncode == 130 and time.perf_counter() - begun < 2.0
    assert (
        stderr == f"lelight: interrupted; what was done is kept in {out / 'checkpoint'}, --resume goes on\n"
    )
    if number == signal.SIGTERM:
        outcome = lelight("calc", scene, "-o", out, "--resume", *LONG)
        assert re.match(r"lelight: going on after \d+ s of work kept in .*checkpoint\n", outcome.stderr)
        assert same_field(out, expected)


def test_a_second_signal_ends_at_once():
    # Nobody looks whether to stop.
    code = (
        "import sys\nfrom lelight.cli.interruption import STOP, end_in_time\n"
        "with end_in_time(), STOP.listening():\n    print('ready', flush=True)\n    import time\n"
        "    for _ in range(1000):\n        time.sleep(0.1)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None and running.stdout.readline() == "ready\n"
        running.send_signal(signal.SIGINT)
        time.sleep(0.3)
        assert running.poll() is None
        begun = time.perf_counter()
        running.send_signal(signal.SIGTERM)
        assert running.wait(timeout=10) == 130 and time.perf_counter() - begun < 0.5


def stopped(scene: Path, out: Path) -> None:
    """Leave a checkpoint behind."""
    running = slow(scene, "-o", out, *LONG)
    assert running.stderr is not None
    running.stderr.readline()
    running.terminate()
    running.communicate()
    assert (out / "checkpoint" / "run.json").exists()


def test_resume_refuses_what_has_changed_and_what_is_damaged(long, tmp_path):
    scene = write_room(tmp_path, toml=ROOM_TOML + COLOURED)
    out = tmp_path / "out"
    stopped(scene, out)
    before = {path: path.read_bytes() for path in (out / "checkpoint").iterdir()}

    def told(*changed: str) -> str:
        outcome = lelight("calc", scene, "-o", out, *LONG, *changed, "--resume")
        assert outcome.status == 1 and outcome.stderr.count("\n") == 1, outcome.stderr
        return outcome.stderr

    assert re.search(r"another run: --seed was 0, is 3; make it as it was", told("--seed", "3"))
    scene.with_suffix(".mtl").write_text(
        scene.with_suffix(".mtl").read_text().replace("0.6", "0.5"), encoding="utf-8"
    )
    assert "file room.mtl has changed" in told()
    write_room(tmp_path, toml=ROOM_TOML + COLOURED)
    identity = json.loads((out / "checkpoint" / "run.json").read_text())
    identity["identity"]["versions"]["numpy"] = "1.0"
    (out / "checkpoint" / "run.json").write_text(json.dumps(identity), encoding="utf-8")
    assert "its checksum does not hold" in told()
    (out / "checkpoint" / "run.json").write_bytes(before[out / "checkpoint" / "run.json"])
    victim = max(before, key=lambda path: len(before[path]))
    victim.write_bytes(before[victim][:-1000])
    assert re.search(rf"{victim.name}: damaged", told())
    victim.write_bytes(before[victim])
    assert {path: path.read_bytes() for path in (out / "checkpoint").iterdir()} == before


def test_a_run_that_begins_anew_says_so_and_two_at_once_are_refused(long, tmp_path):
    out = tmp_path / "out"
    stopped(long[0], out)
    running = slow(long[0], "-o", out, *LONG)
    assert running.stderr is not None
    assert "holds an unfinished run, which --resume goes on with" in running.stderr.readline()
    outcome = lelight("calc", long[0], "-o", out, *LONG)
    assert outcome.status == 1 and f"{out}: another run is at work here" in outcome.stderr
    running.terminate()
    running.communicate()


@pytest.mark.parametrize("trouble", ["full", "gone"])
def test_trouble_with_the_disk_is_one_line_and_what_was_kept_stays(long, tmp_path, trouble):
    scene, expected, _ = long
    out = tmp_path / "out"
    stopped(scene, out)
    before = {path.name: path.read_bytes() for path in (out / "checkpoint").iterdir()}
    limit = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))\n"
    code = (
        "from lelight.checkpoint import keeper\nkeeper.INTERVAL = 0.0\n"
        f"from lelight.cli.main import main\n{limit if trouble == 'full' else ''}main()\n"
    )
    command = [sys.executable, "-c", code, "calc", str(scene), "-o", str(out), *LONG, "--resume"]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=Path(__file__).parents[1])
    if trouble == "gone":
        assert running.stderr is not None
        while "estimating" not in running.stderr.readline():
            pass
        shutil.rmtree(out)
    stderr = running.communicate(timeout=60)[1]
    assert running.returncode == 1, stderr
    last = stderr.splitlines()[-1]
    if trouble == "full":
        assert re.search(r"\.kept: cannot be written: larger than a file may be here", last)
        assert last.endswith(f"what was done is kept in {out / 'checkpoint'}, --resume goes on")
        after = {path.name: path.read_bytes() for path in (out / "checkpoint").iterdir()}
        assert {name: after.get(name) for name in before} == before
    else:
        assert "folder does not exist any more" in last and "Traceback" not in stderr
        return
    outcome = lelight("calc", scene, "-o", out, *LONG, "--resume")
    assert outcome.status == 0 and same_field(out, expected)
