"""Grids of measuring points on a plane, EN 12464-1, clause on illuminance grids.

Rule and exponent agree in two public re-implementations; they are not verified against the standard's text.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.scene import FloatArray, MeasuringPlane

#: m; no cell is larger.
LARGEST_SPACING = 10.0
#: Longer to shorter edge of a cell.
LARGEST_ASPECT = 2.0
#: Keeps a quotient that is an integer but for rounding from being rounded up.
_ROUNDING = 1e-9


def grid_spacing(d: float) -> float:
    """Largest cell size p = 0.2 · 5^(log10 d), at most 10 m, of a plane whose relevant side is d m."""
    _require_length("d", d)
    return min(0.2 * math.pow(5.0, math.log10(d)), LARGEST_SPACING)


def cell_counts(length_u: float, length_v: float) -> tuple[int, int]:
    """Cells along both edges of a rectangle (m), so that no cell is longer than p or more than 1:2.

    The relevant side is the longer one, or the shorter one where the rectangle is 2:1 or longer.
    """
    _require_length("length_u", length_u)
    _require_length("length_v", length_v)
    shorter, longer = sorted((length_u, length_v))
    spacing = grid_spacing(shorter if longer >= 2 * shorter else longer)
    count_u, count_v = _ceil(length_u / spacing), _ceil(length_v / spacing)
    cell_u, cell_v = length_u / count_u, length_v / count_v
    return (
        max(count_u, _ceil(length_u / (LARGEST_ASPECT * cell_v))),
        max(count_v, _ceil(length_v / (LARGEST_ASPECT * cell_u))),
    )


def grid_rule(length_u: float, length_v: float) -> str:
    """Say how the grid of a rectangle (m) follows from its sides."""
    shorter, longer = sorted((length_u, length_v))
    long_one = longer >= 2 * shorter
    d = shorter if long_one else longer
    count_u, count_v = cell_counts(length_u, length_v)
    cell_u, cell_v = length_u / count_u, length_v / count_v
    return (
        f"p = 0.2 · 5^(log10 d) = {grid_spacing(d):.4g} m for d = {d:.4g} m "
        f"({'shorter side: 2:1 or longer' if long_one else 'longer side'}); counts rounded up to the next "
        f"integer, {count_u} x {count_v}; cells {cell_u:.4g} m x {cell_v:.4g} m, aspect {cell_u / cell_v:.3g}"
    )


def _require_length(name: str, length: float) -> None:
    if not (math.isfinite(length) and length > 0):
        raise ValueError(f"{name} must be a positive length, found {length}")


def _ceil(quotient: float) -> int:
    return max(1, math.ceil(quotient - _ROUNDING))


def grid_points(plane: MeasuringPlane) -> tuple[FloatArray, tuple[int, int]]:
    """Centres of the cells of a plane's grid.

    Returns
    -------
    points : (rows * columns, 3) float, m; row by row, u running fastest
    shape : (rows, columns); rows run along v, columns along u
    """
    columns, rows = cell_counts(float(np.linalg.norm(plane.u)), float(np.linalg.norm(plane.v)))
    along_u = (np.arange(columns) + 0.5) / columns
    along_v = (np.arange(rows) + 0.5) / rows
    points = plane.origin + along_v[:, None, None] * plane.v + along_u[None, :, None] * plane.u
    return points.reshape(-1, 3), (rows, columns)
