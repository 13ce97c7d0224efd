"""``lelight batch``: many scenes one after the other; one that fails does not stop the others."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Callable, Collection
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from lelight.calculation import Progress
from lelight.checkpoint.stop import Stop
from lelight.errors import LelightError
from lelight.metrics.table import rows as figure_rows
from lelight.pipelines.calc import Announce, run_calc
from lelight.pipelines.results import read_metrics, read_run
from lelight.settings import Settings
from lelight.writing.files import make_folder, safe_names, write_text
from lelight.writing.indexpage import index_page

Status = Literal["done", "finished before", "failed"]


@dataclass(frozen=True)
class Row:
    """What became of one scene.

    Attributes
    ----------
    scene, folder : as text
    message : why it failed, empty where it did not
    seconds : of this call
    nodes, rays, error_rms, target, target_met : of the run, as ``run.json`` has them
    passed, failed, undecided : figures by verdict
    """

    scene: str
    status: Status
    folder: str
    message: str = ""
    seconds: float = 0.0
    nodes: int | None = None
    rays: int | None = None
    error_rms: float | None = None
    target: float | None = None
    target_met: bool | None = None
    passed: int | None = None
    failed: int | None = None
    undecided: int | None = None


@dataclass(frozen=True)
class Watch:
    """Who is told what.

    Attributes
    ----------
    scene : number, how many there are, and name, before each
    row : each row when its scene is through
    """

    scene: Callable[[int, int, str], None] = lambda number, count, name: None
    row: Callable[[Row], None] = lambda row: None
    announce: Announce = lambda _: None
    tell: Announce = lambda _: None
    progress: Progress = lambda _: None


def run_batch(
    scenes: Collection[Path],
    out: Path,
    *,
    settings: Settings,
    given: Collection[str] = (),
    stop: Stop | None = None,
    watch: Watch | None = None,
) -> list[Row]:
    """Compute scenes, each into a folder of its own in ``out``; go on where an earlier call was cut off.

    After every scene ``index.csv`` and ``index.html`` are written anew.

    Returns
    -------
    list : a row a scene, in their order
    """
    watch = watch or Watch()
    make_folder(out)
    paths = list(dict.fromkeys(scenes))
    names = safe_names(path.stem for path in paths)
    found: list[Row] = []
    for number, (path, name) in enumerate(zip(paths, names, strict=True), start=1):
        watch.scene(number, len(paths), name)
        row = _run(path, out / f"{name}.lelight", settings, given, stop, watch)
        found.append(row)
        write_text(out / "index.csv", _csv(found))
        write_text(out / "index.html", index_page([_summary(each, out) for each in found]))
        watch.row(row)
    return found


def _run(
    path: Path, folder: Path, settings: Settings, given: Collection[str], stop: Stop | None, watch: Watch
) -> Row:
    """Compute one scene; whatever goes wrong with it stays in its row."""
    started = time.perf_counter()
    try:
        _, run = run_calc(
            path,
            folder,
            settings=settings,
            given=given,
            resume="where it is the same",
            stop=stop,
            announce=watch.announce,
            tell=watch.tell,
            progress=watch.progress,
        )
        record, figures = read_run(folder), list(figure_rows(read_metrics(folder)))
    except LelightError as error:
        return _failed(path, folder, str(error), started)
    except MemoryError:
        return _failed(path, folder, "not enough memory; give a longer --edge", started)
    except Exception as error:  # a scene that finds a fault of the program must not cost the others
        return _failed(path, folder, f"fault of lelight: {type(error).__name__}: {error}", started)
    verdicts = [figure["verdict"] for figure in figures]
    reached = record["error"]
    return Row(
        scene=str(path),
        status="done" if run is not None else "finished before",
        folder=str(folder),
        seconds=round(time.perf_counter() - started, 1),
        nodes=record["nodes"],
        rays=record["rays"],
        error_rms=reached["rms"],
        target=reached["target"],
        target_met=reached["met"],
        passed=verdicts.count("pass"),
        failed=verdicts.count("fail"),
        undecided=verdicts.count("undecided"),
    )


def _failed(path: Path, folder: Path, message: str, started: float) -> Row:
    seconds = round(time.perf_counter() - started, 1)
    return Row(str(path), "failed", str(folder), " ".join(message.split()), seconds)


def _csv(found: list[Row]) -> str:
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, list(Row.__dataclass_fields__), lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(row) for row in found)
    return text.getvalue()


def _summary(row: Row, out: Path) -> dict[str, Any]:
    """Gather what the page shows of a scene: its row, the path of its folder from the page, figures with targets."""
    folder = Path(row.folder)
    figures: list[dict[str, Any]] = []
    if row.status != "failed":
        every = figure_rows(read_metrics(folder))
        figures = [figure for figure in every if figure["verdict"] or figure["figure"] == "mean_illuminance"]
    return asdict(row) | {"path": folder.relative_to(out).as_posix(), "figures": figures}


def table_lines(found: list[Row]) -> list[str]:
    """Rows as text."""
    lines = [f"{'scene':32} {'status':16} {'error':>8} {'pass':>5} {'fail':>5} {'open':>5} {'seconds':>8}"]
    for row in found:
        error = "-" if row.error_rms is None else f"{row.error_rms:.2%}"
        counts = (row.passed, row.failed, row.undecided)
        numbers = " ".join(f"{'-' if count is None else count:>5}" for count in counts)
        text = f"{Path(row.scene).name:32} {row.status:16} {error:>8} {numbers} {row.seconds:8.1f}  {row.message}"
        lines.append(text.rstrip())
    return lines
