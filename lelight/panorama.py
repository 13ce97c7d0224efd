"""Cylindrical panorama: the azimuth runs evenly across the picture, upright lines stay upright and straight."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lelight.camera import CENTRE, in_scene, pixel_plane, upwards, view_axes, view_options
from lelight.scene import BoolArray, FloatArray


@dataclass(frozen=True)
class Cylindrical:
    """Projection on a cylinder around the viewer's upward axis, unrolled: x is azimuth, y the tangent of elevation.

    Attributes
    ----------
    position : (3,) float, m
    direction : (3,) float, line of sight of any length
    up : (3,) float, axis of the cylinder as far as it is square to the line of sight
    horizontal_angle : float, rad, from the left to the right border, at most 2 pi
    """

    position: FloatArray
    direction: FloatArray
    up: FloatArray = field(default_factory=upwards)
    horizontal_angle: float = 2 * np.pi

    def __post_init__(self) -> None:
        if not 0 < self.horizontal_angle <= 2 * np.pi:
            raise ValueError(f"horizontal_angle: {self.horizontal_angle}, must lie between 0 and 2 pi")

    def mask(self, width: int, height: int) -> BoolArray:
        """Tell which pixels (h, w) have rays: all of them."""
        return np.ones((height, width), dtype=bool)

    def rays(
        self, width: int, height: int, *, offset: tuple[float, float] = CENTRE
    ) -> tuple[FloatArray, FloatArray]:
        """Origins (k, 3) in m and unit directions (k, 3) of all pixels, row by row.

        Parameters
        ----------
        offset : where in the pixel, as fractions of its width from the left and its height from the top
        """
        x, y = pixel_plane(width, height, offset)
        azimuth = 0.5 * self.horizontal_angle * x.ravel()
        tangent = self._tangent(width, height) * y.ravel()
        local = np.column_stack([np.sin(azimuth), tangent, np.cos(azimuth)])
        local /= np.hypot(1.0, tangent)[:, None]
        return in_scene(self.position, local, view_axes(self.direction, self.up))

    def solid_angles(self, width: int, height: int) -> FloatArray:
        """Solid angles (h, w) in sr, exact: a step of azimuth times a step of the sine of elevation."""
        borders = self._tangent(width, height) * (1 - 2 * np.arange(height + 1) / height)
        sines = borders / np.hypot(1.0, borders)
        return np.repeat(-np.diff(sines)[:, None] * self.horizontal_angle / width, width, axis=1)

    def view(self, width: int, height: int) -> str:
        """Describe the view in Radiance's options."""
        vertical = 2 * np.degrees(np.arctan(self._tangent(width, height)))
        return view_options("c", self, (float(np.degrees(self.horizontal_angle)), float(vertical)))

    def _tangent(self, width: int, height: int) -> float:
        """Tangent of the elevation at the upper border, such that pixels at eye level are square."""
        return 0.5 * self.horizontal_angle * height / width
