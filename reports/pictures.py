"""Luminance pictures of observers: reading them, and how much of the view each pixel covers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from lelight.camera import Fisheye
from lelight.errors import OutputError
from lelight.scene import BoolArray, FloatArray
from lelight.writing.pictures import read_exr

RENDER = "`lelight render OUT` writes it"

#: Where it stands and looks does not matter for the size of its pixels.
_FISHEYE = Fisheye(np.zeros(3), np.array([1.0, 0.0, 0.0]))


@dataclass(frozen=True)
class LuminancePicture:
    """A square equi-angular fisheye of 180°, the line of sight in its middle.

    Attributes
    ----------
    luminance : (n, n) float, cd/m²; row 0 is the top
    solid_angles : (n, n) float, sr; zero outside the disc
    """

    luminance: FloatArray
    solid_angles: FloatArray

    @property
    def disc(self) -> BoolArray:
        """(n, n) bool: pixels whose centre is in view."""
        return self.solid_angles > 0

    @property
    def mean(self) -> float:
        """Mean luminance over the solid angle in view, cd/m²."""
        return float(np.average(self.luminance, weights=self.solid_angles))

    def quantile(self, share: float) -> float:
        """Luminance in cd/m² that this share of the solid angle in view does not exceed."""
        luminance, shares = self.distribution()
        return float(luminance[min(int(np.searchsorted(shares, share)), len(luminance) - 1)])

    def distribution(self) -> tuple[FloatArray, FloatArray]:
        """Luminances in view, ascending in cd/m², and the share of the solid angle up to each, 0 to 1."""
        luminance, weights = self.luminance[self.disc], self.solid_angles[self.disc]
        order = np.argsort(luminance, kind="stable")
        shares = np.cumsum(weights[order])
        return luminance[order], np.asarray(shares / shares[-1])

    def extremum(self, largest: bool) -> tuple[int, int]:
        """Row and column of the brightest (or the darkest) pixel in view."""
        beyond = -np.inf if largest else np.inf
        in_view = np.where(self.disc, self.luminance, beyond)
        index = int(np.argmax(in_view) if largest else np.argmin(in_view))
        row, column = np.unravel_index(index, in_view.shape)
        return int(row), int(column)


def disc_coordinates(pixels: int) -> tuple[FloatArray, FloatArray]:
    """Centres of pixels on the unit disc: x (1, n) to the right, y (n, 1) upwards."""
    centres = (2.0 * np.arange(pixels) + 1.0) / pixels - 1.0
    return centres[None, :], -centres[:, None]


def read_picture(path: Path) -> LuminancePicture:
    """Read an observer's ``.exr``.

    Raises
    ------
    OutputError
        The file is not a square luminance picture, or holds a luminance that is none.
    """
    luminance = read_exr(path)
    rows, columns = luminance.shape
    if rows != columns:
        raise OutputError(f"{path}: {columns} x {rows} pixels, a fisheye is square; {RENDER} anew")
    if not np.all(np.isfinite(luminance)) or np.any(luminance < 0):
        raise OutputError(f"{path}: holds a luminance that is negative or not a number; {RENDER} anew")
    return LuminancePicture(luminance, _solid_angles(rows))


@cache
def _solid_angles(pixels: int) -> FloatArray:
    """Solid angles (n, n) in sr of a square picture's pixels: one array for all pictures of a size."""
    return _FISHEYE.solid_angles(pixels, pixels)
