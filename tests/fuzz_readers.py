"""Damaged scenes, checkpoints and results in bulk: ``python tests/fuzz_readers.py 100000 SEED``.

Each file is either read, or refused in one line by an error of ours; none takes long or much memory. The suite runs
the same on fewer files; `fuzz_photometry` does photometric ones.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from commandline import ROOM_MTL, ROOM_OBJ, ROOM_TOML
from mutations import POISON_OF_SCENES, mutated

from lelight.calculation import calculate
from lelight.checkpoint.folder import CheckpointFolder
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import form_of
from lelight.checkpoint.segments import CHECKSUM, MAGIC, read_segment
from lelight.course import course_form
from lelight.errors import LelightError
from lelight.field import RadianceField
from lelight.metrics.table import to_csv
from lelight.pipelines.calc import run_calc
from lelight.pipelines.results import read_metrics, read_run, table_lines
from lelight.placement import Placed
from lelight.reading.loading import load
from lelight.receivers import space_receivers
from lelight.reports.folder import open_folder
from lelight.reports.method import method_page
from lelight.reports.sources import source_rows, sources_of
from lelight.reports.surfaces import luminaire_table, material_rows
from lelight.settings import Settings

#: Longest time in s for one file, on a busy machine.
LONGEST = 5.0
#: A scene file with everything in it.
TOML = (
    ROOM_TOML
    + """
[materials]
"*" = { reflectance = 0.5 }
"floor*" = { reflectance = [0.3, 0.2, 0.1], specular = 0.05, exponent = 32 }
"panel" = { luminance = 3000, sides = "front" }

[outdoor]
plane = "work plane"
reflectance = 0.2

[calc]
target = "5%"
edge = 0.5
"""
)

Read = Callable[[bytes], object]


def readers(folder: Path) -> dict[str, tuple[list[bytes], Read]]:
    """What each reader is given to begin with, and how it reads what became of it."""
    scene = {".obj": ROOM_OBJ.encode(), ".mtl": ROOM_MTL.encode(), ".toml": TOML.encode()}
    for suffix, content in scene.items():
        (folder / f"room{suffix}").write_bytes(content)
    result = _result(folder)
    out = folder / "out"

    there: dict[Path, bytes] = {}

    def put(files: dict[Path, bytes]) -> None:
        """Write the files that have changed since the last time."""
        for path, text in files.items():
            if there.get(path) != text:
                path.write_bytes(text)
                there[path] = text

    def of_scene(suffix: str) -> Read:
        def read(content: bytes) -> object:
            put({folder / f"room{ending}": text for ending, text in {**scene, suffix: content}.items()})
            return load(folder / "room.toml")

        return read

    def segment(content: bytes) -> object:
        return _read_segment(folder / "000001.kept", content)

    def of_result(name: str, read: Callable[[Path], object]) -> Read:
        def written(content: bytes) -> object:
            put({out / each: text for each, text in {**result, name: content}.items()})
            return read(out)

        return written

    sound = load(folder / "room.toml")
    return {
        "obj": ([scene[".obj"]], of_scene(".obj")),
        "mtl": ([scene[".mtl"]], of_scene(".mtl")),
        "toml": ([scene[".toml"]], of_scene(".toml")),
        "checkpoint": ([path.read_bytes() for path in sorted(folder.glob("checkpoint/*.kept"))], segment),
        "run.json": ([result["run.json"]], of_result("run.json", _read_run)),
        "metrics.json": ([result["metrics.json"]], of_result("metrics.json", _read_metrics)),
        "field.vtp": (
            [result["field.vtp"]],
            of_result("field.vtp", lambda out: RadianceField.load(out / "field.vtp", sound)),
        ),
    }


def _result(folder: Path) -> dict[str, bytes]:
    """Files of a result folder, and beside it what a run kept."""
    scene = load(folder / "room.toml")
    identity: dict[str, dict[str, Any]] = {"versions": {}, "settings": {}, "files": {}}
    keep = Keeper(CheckpointFolder(folder / "checkpoint", identity))
    calculate(scene, Settings(edge=1.0, batches=2, threads=1), keep=keep)
    settings = Settings(edge=1.0, target=0.5, preset="draft", threads=1)
    out, _ = run_calc(folder / "room.toml", folder / "out", settings=settings)
    return {name: (out / name).read_bytes() for name in ("run.json", "metrics.json", "field.vtp")}


def _read_segment(path: Path, content: bytes) -> None:
    """Read a segment as it is, and again with a checksum that holds: as an enemy would write it."""
    path.write_bytes(content)
    try:
        read_segment(path)
        raise AssertionError("damage was not noticed")
    except LelightError:
        pass
    body = content[:-CHECKSUM] if content.startswith(MAGIC) else MAGIC + content[:-CHECKSUM]
    path.write_bytes(body + hashlib.sha256(body).hexdigest().encode() + b"\n")
    segment = read_segment(path)
    places = space_receivers(np.zeros((3, 3)), np.zeros((3, 3)))
    for key in segment.entries:
        record = segment.read(key)
        for form in (form_of(Placed), course_form(places, width=0, channels=1)):
            try:
                form.unpack(record)
            except (KeyError, TypeError, ValueError):
                continue


def _read_run(out: Path) -> None:
    run = read_run(out)
    folder = open_folder(out)
    method_page(folder)
    material_rows(run)
    luminaire_table(run, folder.texts)


def _read_metrics(out: Path) -> None:
    table = read_metrics(out)
    table_lines(table)
    to_csv(table)
    folder = open_folder(out)
    for observer in folder.observers:
        source_rows(sources_of(observer), folder.texts)


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """Damage a file as a text, as an archive of bytes, or as a tree of JSON."""
    kind = int(rng.integers(3))
    if kind == 0:
        return mutated(content, rng, POISON_OF_SCENES)
    if kind == 1 and content.lstrip()[:1] == b"{":
        return json.dumps(_pruned(json.loads(content), rng)).encode()
    changed = bytearray(content)
    first = int(rng.integers(len(changed)))
    length = min(int(rng.integers(1, 1 + 4 ** int(rng.integers(1, 7)))), len(changed) - first)
    changed[first : first + length] = [bytes(length), rng.bytes(length), b"\xff" * length][
        int(rng.integers(3))
    ]
    return bytes(changed)


def _pruned(tree: Any, rng: np.random.Generator) -> Any:
    """Put something else into one place of a tree."""
    strange = [
        None,
        True,
        -1,
        1e308,
        10**400,
        float("nan"),
        "",
        "x" * 300,
        "../../x",
        [],
        {},
        [[1]],
        {"value": "x"},
    ]
    parent, place, inner = None, None, tree
    while isinstance(inner, dict | list) and inner and (parent is None or rng.random() < 0.85):
        parent = inner
        place = (
            list(inner)[int(rng.integers(len(inner)))]
            if isinstance(inner, dict)
            else int(rng.integers(len(inner)))
        )
        inner = parent[place]
    parent[place] = strange[int(rng.integers(len(strange)))]
    return tree


def fuzz(source: tuple[list[bytes], Read], *, count: int, seed: int, name: str) -> int:
    """Try damaged files; returns how many could be read."""
    corpus, read = source
    rng = np.random.default_rng(seed)
    accepted = 0
    for k in range(count):
        content = damaged(corpus[k % len(corpus)], rng)
        if content in corpus:
            continue
        started = time.perf_counter()
        try:
            read(content)
            accepted += 1
        except LelightError as refusal:
            told = str(refusal)
            assert "\n" not in told, told
            assert len(told) < 700, told[:700]
        except BaseException:
            (Path(tempfile.gettempdir()) / f"failed {name}").write_bytes(content)
            raise
        assert time.perf_counter() - started < LONGEST
    return accepted


if __name__ == "__main__":
    import resource
    import warnings

    warnings.simplefilter("error")
    count, seed = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with tempfile.TemporaryDirectory() as folder:
        for name, source in readers(Path(folder)).items():
            if len(sys.argv) > 3 and name not in sys.argv[3:]:
                continue
            started = time.perf_counter()
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            accepted = fuzz(source, count=count, seed=seed, name=name)
            more = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
            print(
                f"{name}: {count} files, {accepted} read, {time.perf_counter() - started:.0f} s, {more:.0f} MB more",
                flush=True,
            )
