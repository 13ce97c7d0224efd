"""``lelight calc``: from a scene file to a folder of results."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from lelight.calculation import Calculation, Progress, calculate
from lelight.checkpoint.identity import Identity, identity_of
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.lock import held
from lelight.checkpoint.stop import Stop
from lelight.mesh.remesh import remesher_missing
from lelight.pipelines.beginning import begin, default_out
from lelight.pipelines.eyes import Sight, look
from lelight.pipelines.figures import figures
from lelight.pipelines.folder import (
    file_stems,
    prepare_folder,
    withdraw_record,
    write_geometry,
    write_json,
    write_sights,
    write_tables,
)
from lelight.pipelines.likeness import SHARED_SETTINGS, settings_like
from lelight.pipelines.pacing import paced
from lelight.pipelines.record import run_record
from lelight.pipelines.resuming import Resume, checkpoint, is_finished
from lelight.settings import Settings
from lelight.writing.files import remove_temporary
from lelight.writing.views import write_overview

#: Told the name of each stage as it begins, or what is odd about a run.
Announce = Callable[[str], None]


def run_calc(
    scene_path: Path,
    out: Path | None = None,
    *,
    settings: Settings,
    given: Collection[str] = (),
    like: Path | None = None,
    resume: Resume = "no",
    stop: Stop | None = None,
    announce: Announce = lambda _: None,
    tell: Announce = lambda _: None,
    warn: Announce = lambda _: None,
    progress: Progress = lambda _: None,
) -> tuple[Path, Calculation | None]:
    """Compute a scene and write all its results.

    Parameters
    ----------
    given : names of the settings that win over the scene file's ``[calc]`` table
    like : result folder of a run to sample like, with its seed, edge and whatever else was not given
    resume : whether to go on with what an earlier run has kept in the folder
    stop : asked to stop the run, which then keeps what it has
    tell : told at once what was found of earlier runs in the folder
    warn : told, once all is written, what ``run.json`` lists as warnings beside a target that was missed

    Returns
    -------
    out : the folder
    run : what was found; None where the folder to resume in holds the finished result already
    """
    started = perf_counter()
    announce("reading")
    sampling = None
    if like is not None:
        settings, sampling = settings_like(like, settings, given=given)
        # The number of replicates tells a checkpoint of this run from those of runs that are like no other.
        settings = replace(settings, batches=sampling.replicates)
        given = {*given, *SHARED_SETTINGS, "batches"}
    scene = begin(scene_path, settings, given=given)
    out = out if out is not None else default_out(scene_path)
    prepare_folder(out)
    identity = identity_of(scene, settings.over(scene.settings))
    with held(out):
        if resume != "no" and not (out / "checkpoint").exists() and is_finished(out, identity):
            tell(f"{out} is finished: nothing to do")
            return out, None
        remove_temporary(out)
        folder = checkpoint(out, identity, resume=resume, tell=tell)
        read = perf_counter() - started
        announce("estimating")
        keep = Keeper(folder, stop=stop)
        dialled, pace = paced(scene, settings, keep, spent=read)
        run = calculate(scene, dialled, like=sampling, pace=pace, progress=progress, keep=keep)
        announce("writing")
        for warning in _write(scene_path, out, run, read, identity):
            warn(warning)
        folder.remove()
        remove_temporary(out)
    return out, run


def _write(
    scene_path: Path, out: Path, run: Calculation, read_seconds: float, identity: Identity
) -> list[str]:
    """Write all results, the record of the run last; returns its warnings but for a target that was missed."""
    written = perf_counter()
    withdraw_record(out)
    stems = file_stems(run)
    write_geometry(out, run, stems)
    with ThreadPoolExecutor(max_workers=1) as aside:
        # Drawn by a process of its own, while this one looks through the observers' eyes.
        overview = aside.submit(write_overview, out / "overview.png", out / "field.vtp")
        sights = _sights(run)
        write_sights(out, sights, stems["observers"])
        write_tables(out, figures(run, sights, stems))
    undrawn = overview.result()
    warnings = [*run.scene.warnings, *_missing_parts(), *([undrawn] if undrawn else [])]
    seconds = {"read": read_seconds, "write": perf_counter() - written}
    scene_file = Path(os.path.relpath(scene_path, out)).as_posix()
    record = run_record(
        run,
        scene_file=scene_file,
        seconds=seconds,
        warnings=[*warnings, *_missed_target(run)],
        identity=identity,
    )
    write_json(out / "run.json", record)
    return warnings


def _sights(run: Calculation) -> tuple[Sight, ...]:
    """Look through every observer's eyes."""
    if run.settings.pictures is False:
        return ()
    preset = run.settings.values
    with ThreadPoolExecutor(max_workers=run.settings.workers) as executor:
        return tuple(
            look(run.field, eye, size=preset.picture_size, samples=preset.picture_samples, executor=executor)
            for eye in run.scene.observers
        )


def _missing_parts() -> list[str]:
    """Say what this machine lacks and the run had to do without."""
    missing = remesher_missing()
    return [missing] if missing else []


def _missed_target(run: Calculation) -> list[str]:
    """Say by how much the target was missed."""
    if run.target_met:
        return []
    return [
        f"target not reached: relative standard error {run.error.rms:.3g}, "
        f"asked for {run.settings.target_error:.3g}; give more --time",
    ]
