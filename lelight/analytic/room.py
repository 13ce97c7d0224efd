"""The room of the CIE 171 cases: 4 m x 4 m x 3 m, its row of points on wall and floor (CIE 171:2006, section 5).

Points A to F stand on the wall y = 0 at x = 2 m, G to N in a row over floor or ceiling at x = 2 m.
"""

from __future__ import annotations

import numpy as np

from lelight.analytic.solids import probe
from lelight.scene import MeasuringPlane

SIDE, HEIGHT = 4.0, 3.0
WALL_HEIGHTS = np.array([2.75, 2.25, 1.75, 1.25, 0.75, 0.25])
ROW = np.arange(0.25, SIDE, 0.5)


def wall_points(*, upwards: bool = False) -> list[MeasuringPlane]:
    """Points A to F, from the ceiling down or from the floor up, facing the room."""
    heights = WALL_HEIGHTS[::-1] if upwards else WALL_HEIGHTS
    return [probe(label, (2.0, 0.0, z), (0, 1, 0)) for label, z in zip("ABCDEF", heights, strict=True)]


def row_points(height: float) -> list[MeasuringPlane]:
    """Points G to N on the floor (``height`` 0), facing up, or on the ceiling, facing down."""
    up = -1.0 if height > 0 else 1.0
    return [probe(label, (2.0, y, height), (0, 0, up)) for label, y in zip("GHIJKLMN", ROW, strict=True)]
