"""The result folder: every file of a run, each whole or not there."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import lelight
from lelight.calculation import Calculation
from lelight.errors import OutputError
from lelight.luminaires import have_direction
from lelight.metrics.table import to_csv
from lelight.pipelines.eyes import Sight
from lelight.scene import FloatArray
from lelight.writing.files import make_folder, safe_names, whole, write_text
from lelight.writing.incidentfile import write_incident
from lelight.writing.layout import write_layout
from lelight.writing.paraview import write_paraview_script
from lelight.writing.pictures import write_exr
from lelight.writing.radiancehdr import write_hdr
from lelight.writing.replicatesfile import write_replicates
from lelight.writing.views import robust_range
from lelight.writing.vtkfiles import write_index, write_luminaires, write_observers, write_plane

#: What every replicate found, for `lelight compare` and ``calc --like``.
REPLICATES = "replicates.npz"
#: Light that arrives at glossy nodes by direction, for `lelight relight`.
INCIDENT = "incident.npz"


def prepare_folder(out: Path) -> None:
    """Make the folder and try it, so that a run does not end at a closed door."""
    make_folder(out)
    with whole(out / ".probe") as probe:
        probe.write_bytes(b"")
    (out / ".probe").unlink()


def withdraw_record(out: Path) -> None:
    """Take away what says that an earlier run is whole, before its files are replaced one by one.

    Raises
    ------
    OutputError
        where it cannot be taken away
    """
    for name in ("run.json", "metrics.json"):
        try:
            (out / name).unlink(missing_ok=True)
        except OSError as error:
            raise OutputError(f"{out / name}: cannot be replaced: {error.strerror}; move it away") from error


def file_stems(run: Calculation) -> dict[str, dict[str, str]]:
    """File stems of planes and observers by their names."""
    planes = [plane.name for plane in run.scene.planes]
    eyes = [eye.name for eye in run.scene.observers]
    return {
        "planes": dict(zip(planes, safe_names(planes), strict=True)),
        "observers": dict(zip(eyes, safe_names(eyes), strict=True)),
    }


def write_geometry(out: Path, run: Calculation, stems: dict[str, dict[str, str]]) -> None:
    """Write field, planes, luminaires, observers, the index and the ParaView script."""
    field_file = out / "field.vtp"
    run.field.save(field_file, header=_header(run))
    if run.field.incident is not None:
        write_incident(out / INCIDENT, run.field.incident)
    with whole(out / REPLICATES) as beside:
        write_replicates(beside, run.replicates, run.planes, run.observers, run.sampling)
    blocks: dict[str, dict[str, Path]] = {"field": {"field": field_file}}
    make_folder(out / "planes")
    blocks["planes"] = {}
    for values in run.planes:
        path = out / "planes" / f"{stems['planes'][values.plane.name]}.vtp"
        write_plane(path, values)
        blocks["planes"][values.plane.name] = path
    if run.scene.luminaires:
        blocks["luminaires"] = {"luminaires": out / "luminaires.vtp"}
        write_luminaires(out / "luminaires.vtp", run.scene.luminaires)
    if have_direction(run.scene.luminaires):
        write_layout(out / "layout.svg", run.scene)
    if run.scene.observers:
        blocks["observers"] = {"observers": out / "observers.vtp"}
        write_observers(out / "observers.vtp", run.scene.observers)
    write_index(out / "scene.vtm", blocks)
    write_paraview_script(
        out / "paraview.py",
        title=run.scene.name,
        field=field_file,
        illuminance_range=robust_range(run.field.illuminance, run.field.mesh.hidden),
        planes=blocks["planes"],
        luminaires=out / "luminaires.vtp" if run.scene.luminaires else None,
        observers=out / "observers.vtp" if run.scene.observers else None,
        eyes=run.scene.observers,
        channels=run.field.world.channels,
    )


def write_sights(out: Path, sights: tuple[Sight, ...], stems: Mapping[str, str]) -> None:
    """Write each observer's picture as EXR, Radiance HDR and false colour, on one scale for all."""
    write_pictures(out, [(s.observer.name, s.luminance, s.view) for s in sights], stems)


def write_pictures(
    out: Path, pictures: Sequence[tuple[str, FloatArray, str]], stems: Mapping[str, str]
) -> None:
    """Write pictures of observers.

    Parameters
    ----------
    pictures : of each the observer's name, luminance (h, w) in cd/m², and Radiance's view options
    """
    folder = make_folder(out / "observers")
    if not pictures:
        return
    # Matplotlib takes a quarter of a second, and is here while the overview is drawn by another process.
    from lelight.writing.falsecolour import decade_limits, write_falsecolour

    limits = decade_limits(np.concatenate([seen[np.isfinite(seen)] for _, seen, _ in pictures]))
    for name, luminance, view in pictures:
        stem = stems[name]
        write_exr(folder / f"{stem}.exr", luminance, view=view)
        write_hdr(folder / f"{stem}.hdr", np.nan_to_num(luminance), view=view)
        write_falsecolour(folder / f"{stem}.png", luminance, title=name, limits=limits)


def write_tables(out: Path, table: Mapping[str, Any]) -> None:
    """Write the figures as JSON and CSV."""
    write_json(out / "metrics.json", table)
    write_text(out / "metrics.csv", to_csv(table))


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write JSON that others can read: no NaN, UTF-8."""
    write_text(path, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def _header(run: Calculation) -> dict[str, Any]:
    return {
        "version": lelight.__version__,
        "seed": run.settings.seed,
        "scene": run.scene.name,
        "input_unit": run.scene.unit,
        "up": "z",
        "input_up": run.scene.up,
        "files": run.scene.files,
    }
