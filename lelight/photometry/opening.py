"""The luminous opening of a luminaire: its shape, its size along the C planes, and how large it looks.

Sizes are along the luminaire's own axes: C0 to C180, C90 to C270, and the vertical. The two file formats name
them across each other: the length of LM-63 lies along C0, that of EULUMDAT along C90.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from lelight.scene import FloatArray

#: Area in m² below which there is none.
LEAST_AREA = 1e-9

#: ``rectangle`` and ``ellipse`` are horizontal and may have luminous sides; ``ellipsoid`` is a sphere, or a
#: vertical ellipse where one horizontal size is zero; a ``tube`` is a lying cylinder.
Shape = Literal["point", "rectangle", "ellipse", "ellipsoid", "tube_c0", "tube_c90"]


@dataclass(frozen=True)
class Opening:
    """A luminous opening.

    Attributes
    ----------
    along_c0, along_c90 : float, m, extents from C180 to C0 and from C270 to C90
    heights : 4 floats, m, of the luminous sides that face C0, C90, C180, C270; bodies have one height
    """

    shape: Shape = "point"
    along_c0: float = 0.0
    along_c90: float = 0.0
    heights: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    @property
    def height(self) -> float:
        """Largest height of a luminous side, m."""
        return max(self.heights)

    @property
    def size(self) -> float:
        """Largest extent, m; a luminaire farther off than five times this is a point."""
        return max(self.along_c0, self.along_c90, self.height)

    def projected_area(self, c: ArrayLike, gamma: ArrayLike) -> FloatArray:
        """Luminous area in m² as seen from a direction, on a plane across it.

        For rectangles ``a b |cos γ| + sin γ (b h₀ |cos C| + a h₉₀ |sin C|)``, the rule of CIE 190:2010 and
        EN 13032-2 for openings with luminous sides.

        Parameters
        ----------
        c, gamma : (...) float, degrees, direction in which the light leaves
        """
        c, gamma = np.radians(np.asarray(c, dtype=float)), np.radians(np.asarray(gamma, dtype=float))
        x, y, z = np.sin(gamma) * np.cos(c), np.sin(gamma) * np.sin(c), np.cos(gamma)
        return np.asarray(_AREAS[self.shape](self, x, y, z))

    def figure(self) -> tuple[FloatArray, FloatArray, bool]:
        """Largest plane section: edge vectors (3,), (3,) in m along the luminaire's axes, and whether round.

        The axes are C0, C90 and up. A luminaire that is near is spread over this figure.
        """
        extents = np.array([self.along_c0, self.along_c90, self.height])
        first, second = sorted(int(axis) for axis in np.argsort(-extents, kind="stable")[:2])
        edges = np.diag(extents)
        round_ = self.shape == "ellipsoid" or (self.shape == "ellipse" and second == 1)
        return edges[first], edges[second], round_


def _no_area(opening: Opening, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    return np.zeros(np.broadcast_shapes(np.shape(x), np.shape(y), np.shape(z)))


def _side_heights(opening: Opening, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Heights of the two sides that face a direction."""
    h = opening.heights
    return np.where(x >= 0, h[0], h[2]), np.where(y >= 0, h[1], h[3])


def _rectangle(opening: Opening, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    h0, h90 = _side_heights(opening, x, y)
    a, b = opening.along_c0, opening.along_c90
    return np.asarray(a * b * np.abs(z) + b * h0 * np.abs(x) + a * h90 * np.abs(y))


def _ellipse(opening: Opening, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    a, b = opening.along_c0, opening.along_c90
    # An upright cylinder looks as wide as its ellipse does from the side.
    side = opening.height * np.hypot(a * y, b * x)
    return np.asarray(math.pi / 4 * a * b * np.abs(z) + side)


def _ellipsoid(opening: Opening, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    a, b, h = opening.along_c0, opening.along_c90, opening.height
    return np.asarray(math.pi / 4 * np.sqrt((b * h * x) ** 2 + (a * h * y) ** 2 + (a * b * z) ** 2))


def _tube(
    length: float, width: float, height: float, along: FloatArray, across: FloatArray, z: FloatArray
) -> FloatArray:
    """Lying cylinder whose ends are ellipses: its silhouette is as wide as theirs."""
    side = length * np.hypot(height * across, width * z)
    return np.asarray(side + math.pi / 4 * width * height * np.abs(along))


def _tube_c0(opening: Opening, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    return _tube(opening.along_c0, opening.along_c90, opening.height, x, y, z)


def _tube_c90(opening: Opening, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    return _tube(opening.along_c90, opening.along_c0, opening.height, y, x, z)


#: Projected area of an opening along unit directions x (C0), y (C90), z (down).
Area = Callable[[Opening, FloatArray, FloatArray, FloatArray], FloatArray]

_AREAS: dict[Shape, Area] = {
    "point": _no_area,
    "rectangle": _rectangle,
    "ellipse": _ellipse,
    "ellipsoid": _ellipsoid,
    "tube_c0": _tube_c0,
    "tube_c90": _tube_c90,
}
