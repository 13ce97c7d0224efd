"""``lelight batch``: what one scene does wrong costs the others nothing, and nothing is done twice."""

from __future__ import annotations

import csv
import signal
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
from commandline import ROOM_OBJ, lelight, write_room

OPTIONS = ("--preset", "draft", "--edge", "0.7", "--target", "20%", "--threads", "2")


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    """A good scene, one that cannot be read, one of a nasty name, twice the same name."""
    folder = tmp_path_factory.mktemp("batch")
    good = write_room(folder / "one")
    bad = write_room(folder / "two", obj=ROOM_OBJ + "f 1 2 999\n")
    nasty = folder / "three" / '<b>&"x.obj'
    write_room(folder / "three").rename(nasty)
    for name in ("room.toml",):
        (folder / "three" / name).unlink()
    out = folder / "out"
    return (good, bad, nasty), out, lelight("batch", good, bad, nasty, good, "-o", out, *OPTIONS)


def rows(out: Path) -> list[dict[str, str]]:
    with (out / "index.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_a_bad_scene_does_not_stop_the_others(batch):
    scenes, out, told = batch
    assert told.status == 1
    assert told.stderr.splitlines()[-1] == f"lelight: 1 scene of 3 failed: room.obj; see {out / 'index.csv'}"
    assert [row["status"] for row in rows(out)] == ["done", "failed", "done"]
    assert [row["scene"] for row in rows(out)] == [str(scene) for scene in scenes]
    assert "999" in rows(out)[1]["message"] and str(scenes[1]) in rows(out)[1]["message"]
    assert (out / "room.lelight" / "run.json").exists() and not (out / "room-2.lelight" / "run.json").exists()
    assert len(told.stdout.splitlines()) == 4


def test_the_page_shows_every_scene_and_takes_names_for_text(batch):
    scenes, out, _ = batch
    tags, text = [], []
    parser = HTMLParser()
    parser.handle_starttag = lambda tag, attributes: tags.append((tag, dict(attributes)))
    parser.handle_data = text.append
    parser.feed((out / "index.html").read_text(encoding="utf-8"))
    assert str(scenes[2]) in "".join(text) and "b" not in [tag for tag, _ in tags]
    pictures = [attributes["src"] for tag, attributes in tags if tag == "img"]
    assert pictures[0] == "room.lelight/overview.png" and len(pictures) == 2
    assert "mean illuminance" in "".join(text)


def test_a_second_call_skips_what_is_finished_and_does_what_was_not(batch):
    scenes, out, _ = batch
    before = (out / "room.lelight" / "run.json").read_bytes()
    write_room(scenes[1].parent)
    told = lelight("batch", *scenes, "-o", out, *OPTIONS)
    assert told.status == 0, told.stderr
    assert [row["status"] for row in rows(out)] == ["finished before", "done", "finished before"]
    assert (out / "room.lelight" / "run.json").read_bytes() == before


def test_a_batch_that_was_stopped_goes_on(tmp_path):
    scene, other = write_room(tmp_path / "a"), write_room(tmp_path / "b")
    out = tmp_path / "out"
    options = ("--edge", "0.3", "--target", "1%", "--preset", "draft")
    command = [
        sys.executable, "-c", "from lelight.cli.main import main; main()", "batch", str(scene), str(other),
        "-o", str(out), *options,
    ]  # fmt: skip
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, cwd=Path(__file__).parents[1]
    ) as running:
        assert running.stderr is not None
        assert running.stderr.readline().startswith("lelight: 1 of 2, room: estimating: 1 replicates")
        running.send_signal(signal.SIGINT)
        assert running.wait(timeout=10) == 130
    assert (out / "room.lelight" / "checkpoint" / "run.json").exists() and not (out / "index.csv").exists()
    # Another target is another run: it begins anew and does not fail.
    told = lelight("batch", scene, "-o", out, *OPTIONS)
    assert told.status == 0 and rows(out)[0]["status"] == "done"
    assert not (out / "room.lelight" / "checkpoint").exists()
