"""``lelight relight``: another material for the last bounce, without a new run."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from lelight.camera import Fisheye
from lelight.errors import OutputError
from lelight.field import RadianceField
from lelight.pipelines.folder import INCIDENT, prepare_folder, write_json, write_pictures
from lelight.pipelines.render import stored_field
from lelight.pipelines.results import read_run
from lelight.reading.changes import changed
from lelight.reading.lint import material_rows
from lelight.relighting import relit
from lelight.scene import FloatArray
from lelight.settings import PRESETS, Settings
from lelight.writing.fieldfile import read_field
from lelight.writing.files import safe_names
from lelight.writing.incidentfile import read_incident
from lelight.writing.paraview import write_paraview_script
from lelight.writing.views import robust_range
from lelight.writing.vtkfiles import write_index, write_observers

#: What a relit result does not show.
LIMIT = (
    "Relit: {names} sends to the eye what the new material makes of the light that was computed. Light that other "
    "surfaces receive from it, and so every illuminance, is still that of the old one."
)


def run_relight(
    out: Path, changes: Mapping[str, Mapping[str, Any]], *, to: Path | None = None
) -> tuple[Path, str]:
    """Write a result folder of the same light on other materials.

    Parameters
    ----------
    changes : keys of materials by pattern, as `lelight.reading.changes.read_changes` reads them
    to : the new folder; default beside the old one, with ``-relit`` in its name

    Returns
    -------
    the folder, and what it does not show

    Raises
    ------
    OutputError
        where the old folder is not whole, or keeps too little for the new materials
    """
    record = read_run(out)
    if "relit" in record:
        origin = record.get("relit_of", "another folder")
        raise OutputError(f"{out}: relit already; relight {origin} with all changes")
    to = to or out.with_name(f"{out.stem}-relit{out.suffix}")
    if to.resolve() == out.resolve():
        raise OutputError(f"{to}: is the folder to be relit; give another with -o")
    field = stored_field(out)
    if (out / INCIDENT).exists():
        field = replace(field, incident=read_incident(out / INCIDENT))
    field = relit(field, changed(field.scene, changes))
    limit = LIMIT.format(names=", ".join(changes))
    _write(to, out, field, record, changes, limit)
    return to, limit


def _write(
    to: Path,
    out: Path,
    field: RadianceField,
    record: dict[str, Any],
    changes: Mapping[str, Mapping[str, Any]],
    limit: str,
) -> None:
    """Write field, index, pictures and record."""
    prepare_folder(to)
    (to / "run.json").unlink(missing_ok=True)
    _, _, header = read_field(out / "field.vtp")
    header = {key: told for key, told in header.items() if key not in ("channels", "units", "sh_convention")}
    field.save(to / "field.vtp", header=header | {"relit": changes})
    eyes = field.scene.observers
    blocks = {"field": {"field": to / "field.vtp"}}
    if eyes:
        blocks["observers"] = {"observers": to / "observers.vtp"}
        write_observers(to / "observers.vtp", eyes)
    write_index(to / "scene.vtm", blocks)
    write_paraview_script(
        to / "paraview.py",
        title=f"{field.scene.name}, relit",
        field=to / "field.vtp",
        illuminance_range=robust_range(field.illuminance, field.mesh.hidden),
        observers=to / "observers.vtp" if eyes else None,
        eyes=eyes,
        channels=field.world.channels,
    )
    names = [eye.name for eye in eyes]
    write_pictures(to, _pictures(field, record), dict(zip(names, safe_names(names), strict=True)))
    write_json(to / "run.json", _relit_record(to, out, field, record, changes, limit))


def _pictures(field: RadianceField, record: dict[str, Any]) -> list[tuple[str, FloatArray, str]]:
    """Look through every observer's eyes, as the run that is relit did."""
    preset = PRESETS.get(record.get("settings", {}).get("preset"), PRESETS["normal"])
    size, taken = preset.picture_size, []
    with ThreadPoolExecutor(max_workers=Settings().workers) as executor:
        for eye in field.scene.observers:
            camera = Fisheye(eye.position, eye.direction)
            seen = field.picture(camera, size, size, samples=preset.picture_samples, executor=executor)
            taken.append((eye.name, seen, camera.view(size, size)))
    return taken


def _relit_record(
    to: Path,
    out: Path,
    field: RadianceField,
    record: dict[str, Any],
    changes: Mapping[str, Mapping[str, Any]],
    limit: str,
) -> dict[str, Any]:
    """Tell of the run that was relit, and what was changed."""
    scene_file = Path(os.path.normpath(out / str(record.get("scene_file", ""))))
    kept = {key: told for key, told in record.items() if key != "fingerprint"}
    return kept | {
        "relit": changes,
        "relit_of": Path(os.path.relpath(out, to)).as_posix(),
        "scene_file": Path(os.path.relpath(scene_file, to)).as_posix(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "bias": [*record.get("bias", []), limit],
        "materials": material_rows(field.scene),
    }
