"""``lelight render``: a new picture from a stored field, without a new run."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from lelight.camera import Camera, Fisheye, Perspective
from lelight.errors import OutputError
from lelight.field import RadianceField
from lelight.pipelines.results import read_run
from lelight.reading.changes import changed
from lelight.reading.loading import load
from lelight.scene import FloatArray, Observer, Scene
from lelight.settings import Settings
from lelight.writing.falsecolour import write_falsecolour
from lelight.writing.files import make_folder, safe_name
from lelight.writing.pictures import write_exr
from lelight.writing.radiancehdr import write_hdr

Projection = Literal["fisheye", "perspective"]

#: Horizontal angle of a perspective picture, rad.
PERSPECTIVE_ANGLE = np.radians(70.0)


@dataclass(frozen=True)
class Eye:
    """Where to look from: a name for the files, position (3,) m, direction (3,)."""

    name: str
    position: FloatArray
    direction: FloatArray


def run_render(out: Path, eye: str | Eye, *, projection: Projection, size: int, samples: int) -> Path:
    """Write ``OUT/renders/NAME.exr``, ``.hdr`` and ``.png``; returns the path of the last.

    Parameters
    ----------
    eye : an observer's name, or a place and direction
    size, samples : pixels across, and rays a pixel
    """
    field = stored_field(out)
    seen_by = _observer(field.scene, eye) if isinstance(eye, str) else eye
    camera = _camera(seen_by, projection)
    height = size if projection == "fisheye" else size * 3 // 4
    with ThreadPoolExecutor(max_workers=Settings().workers) as executor:
        luminance = field.picture(camera, size, height, samples=samples, executor=executor)
    stem = make_folder(out / "renders") / safe_name(seen_by.name)
    view = camera.view(size, height)
    write_exr(stem.with_name(f"{stem.name}.exr"), luminance, view=view)
    write_hdr(stem.with_name(f"{stem.name}.hdr"), np.nan_to_num(luminance), view=view)
    png = stem.with_name(f"{stem.name}.png")
    write_falsecolour(png, luminance, title=seen_by.name)
    return png


def stored_field(out: Path) -> RadianceField:
    """Read the field of a result folder, with the scene that it was computed for."""
    run = read_run(out)
    path = Path(os.path.normpath(out / str(run.get("scene_file", ""))))
    scene = load(path)
    if scene.files != run.get("files"):
        raise OutputError(f"{path}: changed since {out} was computed; run `lelight calc {path}` again")
    return RadianceField.load(out / "field.vtp", changed(scene, run.get("relit", {})))


def _observer(scene: Scene, name: str) -> Eye:
    known = {eye.name: eye for eye in scene.observers}
    if name not in known:
        raise OutputError(f"no observer {name!r}; there are: {', '.join(known) or 'none'}")
    eye: Observer = known[name]
    return Eye(eye.name, eye.position, eye.direction)


def _camera(eye: Eye, projection: Projection) -> Camera:
    if projection == "fisheye":
        return Fisheye(eye.position, eye.direction)
    return Perspective(eye.position, eye.direction, horizontal_angle=float(PERSPECTIVE_ANGLE))
