"""Luminance pictures as OpenEXR: one float channel ``Y`` in cd/m²."""

from __future__ import annotations

import errno
from pathlib import Path

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from lelight.errors import OutputError
from lelight.scene import FloatArray
from lelight.writing.files import whole

LUMINANCE_CHANNEL = "Y"


def write_exr(path: Path, luminance: NDArray[np.floating], *, view: str) -> None:
    """Write a luminance picture (h, w) in cd/m²; nan, outside a fisheye's disc, becomes 0.

    ``view``, as Radiance describes views (empty for none), and the unit are kept as attributes of the file.
    """
    height, width = luminance.shape
    spec = OpenImageIO.ImageSpec(width, height, 1, OpenImageIO.FLOAT)
    spec.channelnames = (LUMINANCE_CHANNEL,)
    spec.attribute("Software", "lelight")
    if view:
        spec.attribute("radiance_view", view)
    spec.attribute("unit", "cd/m2")
    pixels = np.where(np.isnan(luminance), 0, luminance).astype(np.float32)[..., None]
    with whole(path) as beside:
        _write_image(beside, spec, pixels)


def read_exr(path: Path) -> FloatArray:
    """Read the luminance (h, w) in cd/m² of a picture that `write_exr` wrote.

    Raises
    ------
    OutputError
        where the file is missing, damaged or has no channel ``Y``
    """
    picture = OpenImageIO.ImageInput.open(str(path))
    if picture is None:
        raise OutputError(
            f"{path}: cannot be read: {OpenImageIO.geterror()}: write it again with lelight render"
        )
    try:
        return _luminance_of(picture, path)
    finally:
        picture.close()


def _luminance_of(picture: OpenImageIO.ImageInput, path: Path) -> FloatArray:
    names = picture.spec().channelnames
    if LUMINANCE_CHANNEL not in names:
        raise OutputError(f"{path}: has the channels {', '.join(names)}, a luminance picture has Y")
    pixels = picture.read_image(OpenImageIO.FLOAT)
    if pixels is None:
        reason = " ".join(picture.geterror().split())
        raise OutputError(f"{path}: damaged: {reason}: write it again with lelight render")
    return np.asarray(pixels[..., names.index(LUMINANCE_CHANNEL)], dtype=np.float64)


def _write_image(path: Path, spec: OpenImageIO.ImageSpec, pixels: NDArray[np.float32]) -> None:
    picture = OpenImageIO.ImageOutput.create(str(path))
    if picture is None:
        raise OSError(errno.EIO, OpenImageIO.geterror())
    if not (picture.open(str(path), spec) and picture.write_image(pixels) and picture.close()):
        raise OSError(errno.EIO, picture.geterror())
