"""``lelight render``: a new picture from a stored field, without a new run."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from lelight.camera import Camera, Fisheye, Perspective
from lelight.errors import OutputError
from lelight.field import RadianceField
from lelight.panorama import Cylindrical
from lelight.pipelines.results import read_run
from lelight.reading.changes import changed
from lelight.reading.loading import load
from lelight.scene import FloatArray, Observer, Scene
from lelight.settings import Settings
from lelight.writing.falsecolour import Marks, decade_limits, write_falsecolour
from lelight.writing.files import make_folder, safe_name
from lelight.writing.pictures import write_exr
from lelight.writing.radiancehdr import write_hdr

Projection = Literal["fisheye", "equisolid", "perspective", "cylindrical"]

#: Horizontal angle of perspective and cylindrical pictures where none was asked for, degrees.
ANGLES: dict[Projection, float] = {"perspective": 70.0, "cylindrical": 360.0}
#: Height over width of pictures.
SHAPES: dict[Projection, float] = {"perspective": 0.75, "cylindrical": 0.375}


@dataclass(frozen=True)
class Eye:
    """Where to look from: a name for the files, position (3,) m, direction (3,)."""

    name: str
    position: FloatArray
    direction: FloatArray


@dataclass(frozen=True)
class Shot:
    """What picture to take.

    Attributes
    ----------
    eye : an observer's name, or a place and direction
    projection : how directions lie on the picture
    angle : horizontal angle of perspective and cylindrical pictures, degrees; None for the usual
    size, samples : int, pixels across, and rays a pixel
    """

    eye: str | Eye
    projection: Projection = "fisheye"
    angle: float | None = None
    size: int = 1000
    samples: int = 1

    @property
    def height(self) -> int:
        """Pixels from top to bottom."""
        return max(1, round(self.size * SHAPES.get(self.projection, 1.0)))

    def camera(self, scene: Scene) -> Camera:
        """Set the camera up in a scene."""
        eye = self.seen_by(scene)
        if self.projection == "fisheye":
            return Fisheye(eye.position, eye.direction)
        if self.projection == "equisolid":
            return Fisheye(eye.position, eye.direction, mapping="equi-solid-angle")
        angle = float(np.radians(self.angle or ANGLES[self.projection]))
        kind = Perspective if self.projection == "perspective" else Cylindrical
        return kind(eye.position, eye.direction, horizontal_angle=angle)

    def seen_by(self, scene: Scene) -> Eye:
        """Find the eye among the observers of a scene."""
        return _observer(scene, self.eye) if isinstance(self.eye, str) else self.eye


@dataclass(frozen=True)
class Colouring:
    """How luminance becomes false colour.

    Attributes
    ----------
    limits : cd/m², ends of the scale; None for those of the picture
    decades : int, length of the picture's own scale; None for three to four
    marks : what is drawn over the picture
    """

    limits: tuple[float, float] | None = None
    decades: int | None = None
    marks: Marks = field(default_factory=Marks)

    def limits_of(self, luminance: FloatArray) -> tuple[float, float]:
        """Choose the ends of the scale of a picture (h, w), cd/m²."""
        return self.limits or decade_limits(luminance, self.decades)


def run_render(out: Path, shot: Shot, *, colouring: Colouring, threads: int = 0) -> Path:
    """Write ``OUT/renders/NAME.exr``, ``.hdr`` and ``.png`` from the stored field; returns the path of the last."""
    field = stored_field(out)
    camera = shot.camera(field.scene)
    eye = shot.seen_by(field.scene)
    with ThreadPoolExecutor(max_workers=Settings(threads=threads).workers) as executor:
        luminance = field.picture(camera, shot.size, shot.height, samples=shot.samples, executor=executor)
    stem = make_folder(out / "renders") / safe_name(eye.name)
    return write_picture(stem, luminance, camera, title=eye.name, colouring=colouring)


def write_picture(
    stem: Path, luminance: FloatArray, camera: Camera, *, title: str, colouring: Colouring
) -> Path:
    """Write a picture (h, w) in cd/m² as EXR, HDR and PNG; returns the path of the last."""
    height, width = luminance.shape
    view = camera.view(width, height)
    write_exr(stem.with_name(f"{stem.name}.exr"), luminance, view=view)
    write_hdr(stem.with_name(f"{stem.name}.hdr"), np.nan_to_num(luminance), view=view)
    png = stem.with_name(f"{stem.name}.png")
    limits = colouring.limits_of(luminance)
    write_falsecolour(png, luminance, title=title, limits=limits, marks=colouring.marks)
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
