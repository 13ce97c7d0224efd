"""Cameras: which ray belongs to which pixel, and how large the pixel is in the field of view.

Axes are Radiance's (``rpict`` manual, ``-v`` options): x to the right of the viewer, y up, rows of a picture
from top to bottom. Pixel coordinates run from -1 at the left and bottom border to 1 at the right and top.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from lelight.scene import BoolArray, FloatArray

#: Centre of a pixel as fractions of its width and height.
CENTRE = (0.5, 0.5)

#: Sine of the angle below which an up vector counts as parallel to the line of sight.
_PARALLEL = 1e-6


class Camera(Protocol):
    """What a picture is made with."""

    def mask(self, width: int, height: int) -> BoolArray:
        """Tell which pixels (h, w) have rays."""
        ...

    def rays(
        self, width: int, height: int, *, offset: tuple[float, float] = CENTRE
    ) -> tuple[FloatArray, FloatArray]:
        """Origins (k, 3) in m and unit directions (k, 3) of the pixels of the mask, row by row."""
        ...

    def solid_angles(self, width: int, height: int) -> FloatArray:
        """Solid angles (h, w) in sr of the pixels, 0 outside the mask."""
        ...

    def view(self, width: int, height: int) -> str:
        """Describe the view in Radiance's options; empty where Radiance has no such view."""
        ...


def upwards() -> FloatArray:
    """Say where up is, the z axis."""
    return np.array([0.0, 0.0, 1.0])


#: How the angle to the line of sight follows from the radius r of the disc: pi/2 r, or 2 asin(r / sqrt 2).
Mapping = Literal["equi-angular", "equi-solid-angle"]


@dataclass(frozen=True)
class Fisheye:
    """Fisheye of 180°: equal steps of the radius are equal angles, or equal areas are equal solid angles.

    Attributes
    ----------
    position : (3,) float, m
    direction : (3,) float, line of sight of any length
    up : (3,) float, drawn upwards; replaced where it is parallel to the line of sight
    mapping : what the picture keeps; Radiance, and evalglare with it, knows the equi-angular one only
    """

    position: FloatArray
    direction: FloatArray
    up: FloatArray = field(default_factory=upwards)
    mapping: Mapping = "equi-angular"

    def mask(self, width: int, height: int) -> BoolArray:
        """Tell which pixels (h, w) have their centre in the hemisphere in front."""
        return np.hypot(*pixel_plane(width, height, CENTRE)) < 1

    def rays(
        self, width: int, height: int, *, offset: tuple[float, float] = CENTRE
    ) -> tuple[FloatArray, FloatArray]:
        """Origins (k, 3) in m and unit directions (k, 3) of the pixels of the mask, row by row.

        A pixel on the rim is sampled up to the rim.

        Parameters
        ----------
        offset : where in the pixel, as fractions of its width from the left and its height from the top
        """
        inside = self.mask(width, height)
        x, y = (plane[inside] for plane in pixel_plane(width, height, offset))
        radius = np.hypot(x, y)
        if self.mapping == "equi-angular":
            angle = np.pi / 2 * np.minimum(radius, 1)
            # sin(angle) / radius, which tends to pi / 2 on the axis.
            sideways = np.divide(np.sin(angle), radius, out=np.full_like(radius, np.pi / 2), where=radius > 0)
            forward = np.cos(angle)
        else:
            # With r = sqrt 2 sin(angle / 2): cos(angle) = 1 - r² and sin(angle) / r = sqrt(2 - r²).
            square = np.minimum(radius, 1) ** 2
            sideways = np.sqrt(2 - square) / np.maximum(radius, 1)
            forward = 1 - square
        local = np.column_stack([sideways * x, sideways * y, forward])
        return in_scene(self.position, local, view_axes(self.direction, self.up))

    def solid_angles(self, width: int, height: int) -> FloatArray:
        """Solid angles (h, w), sr, 2 pi in all: ``(pi/2)² sin(theta)/theta dx dy`` in the unit disc; or ``2 dx dy``."""
        density = np.full((height, width), 2.0)
        if self.mapping == "equi-angular":
            radius = np.hypot(*pixel_plane(width, height, CENTRE))
            density = (np.pi / 2) ** 2 * np.sinc(radius / 2)
        return np.where(self.mask(width, height), density * 4 / (width * height), 0)

    def view(self, width: int, height: int) -> str:
        """Describe the view in Radiance's options; empty where Radiance has no such view."""
        return view_options("a", self, (180, 180)) if self.mapping == "equi-angular" else ""


@dataclass(frozen=True)
class Perspective:
    """Central projection on a flat picture with square pixels.

    Attributes
    ----------
    position : (3,) float, m
    direction : (3,) float, line of sight of any length
    horizontal_angle : float, rad, between the left and right border, below pi
    up : (3,) float, drawn upwards; replaced where it is parallel to the line of sight
    """

    position: FloatArray
    direction: FloatArray
    horizontal_angle: float = np.pi / 3
    up: FloatArray = field(default_factory=upwards)

    def __post_init__(self) -> None:
        if not 0 < self.horizontal_angle < np.pi:
            raise ValueError(f"horizontal_angle: {self.horizontal_angle}, must lie between 0 and pi")

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
        half_width, half_height = self._half_extents(width, height)
        x, y = pixel_plane(width, height, offset)
        local = np.column_stack([half_width * x.ravel(), half_height * y.ravel(), np.ones(x.size)])
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        return in_scene(self.position, local, view_axes(self.direction, self.up))

    def solid_angles(self, width: int, height: int) -> FloatArray:
        """Solid angles (h, w) in sr, exact.

        A rectangle from the axis to (x, y) at unit distance fills ``atan(x y / sqrt(1 + x² + y²))``.
        """
        half_width, half_height = self._half_extents(width, height)
        x = np.linspace(-half_width, half_width, width + 1)
        y = np.linspace(-half_height, half_height, height + 1)[:, None]
        from_axis = np.arctan(x * y / np.sqrt(1 + x * x + y * y))
        return np.asarray(np.diff(np.diff(from_axis, axis=0), axis=1))

    def view(self, width: int, height: int) -> str:
        """Describe the view in Radiance's options."""
        horizontal, vertical = np.degrees(2 * np.arctan(self._half_extents(width, height)))
        return view_options("v", self, (horizontal, vertical))

    def _half_extents(self, width: int, height: int) -> tuple[float, float]:
        half_width = float(np.tan(self.horizontal_angle / 2))
        return half_width, half_width * height / width


def stratified_offsets(count: int) -> FloatArray:
    """Spread ``count`` points evenly over a pixel, the same for every pixel and run.

    They are Hammersley's set: equal steps in one coordinate, bit-reversed (van der Corput) steps in the
    other, both centred, so that a single point is the pixel's centre.

    Returns
    -------
    (count, 2) float in [0, 1)
    """
    steps = (np.arange(count) + 0.5) / count
    return np.column_stack([steps, _bit_reversed(count) + 0.5 / count])


def view_axes(direction: ArrayLike, up: ArrayLike) -> FloatArray:
    """Find the viewer's right, up and forward as the rows of a (3, 3) rotation.

    Where ``up`` is parallel to the line of sight the y axis takes its place, and then the z axis.
    """
    forward = np.asarray(direction, dtype=np.float64)
    length = np.linalg.norm(forward)
    if not (np.isfinite(length) and length > 0):
        raise ValueError(f"direction: {forward} has no length")
    forward = forward / length
    for candidate in (np.asarray(up, dtype=np.float64), np.array([0.0, 1.0, 0.0]), upwards()):
        right = np.cross(forward, candidate)
        if np.linalg.norm(right) > _PARALLEL * np.linalg.norm(candidate):
            break
    right = right / np.linalg.norm(right)
    return np.array([right, np.cross(right, forward), forward])


def as_picture(pixels: FloatArray, mask: BoolArray) -> FloatArray:
    """Lay values (k,) of the mask's pixels out as a picture (h, w), nan elsewhere."""
    picture = np.full(mask.shape, np.nan)
    picture[mask] = pixels
    return picture


def pixel_plane(width: int, height: int, offset: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Coordinates x and y (h, w) of a place in every pixel, -1 to 1."""
    x = 2 * (np.arange(width) + offset[0]) / width - 1
    y = 1 - 2 * (np.arange(height) + offset[1]) / height
    columns, rows = np.meshgrid(x, y)
    return columns, rows


def in_scene(position: FloatArray, local: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Turn directions (k, 3) of the viewer's axes into the scene; origins (k, 3) and directions (k, 3)."""
    directions = local @ axes
    return np.broadcast_to(np.asarray(position, dtype=np.float64), directions.shape), directions


def _bit_reversed(count: int) -> FloatArray:
    """Van der Corput's sequence in base 2: the digits of 0, 1, 2 ... mirrored at the point."""
    numbers = np.arange(count)
    mirrored = np.zeros(count)
    digit = 0.5
    while numbers.any():
        mirrored += digit * (numbers & 1)
        numbers >>= 1
        digit /= 2
    return mirrored


class Placed(Protocol):
    """What has a place and looks somewhere."""

    @property
    def position(self) -> FloatArray:
        """(3,) float, m."""

    @property
    def direction(self) -> FloatArray:
        """(3,) float, line of sight of any length."""

    @property
    def up(self) -> FloatArray:
        """(3,) float, drawn upwards."""


def view_options(kind: str, camera: Placed, angles: tuple[float, float]) -> str:
    """Describe a view in Radiance's options: kind, place, axes and angles in degrees."""
    _, upward, forward = view_axes(camera.direction, camera.up)
    vectors = {"-vp": camera.position, "-vd": forward, "-vu": upward}
    places = " ".join(f"{option} {_numbers(vector)}" for option, vector in vectors.items())
    return f"-vt{kind} {places} -vh {angles[0]:.9g} -vv {angles[1]:.9g}"


def _numbers(vector: FloatArray) -> str:
    # Adding zero turns -0 into 0.
    return " ".join(f"{number + 0.0:.9g}" for number in np.asarray(vector, dtype=np.float64))
