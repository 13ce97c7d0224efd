"""Values on a measuring plane's grid, as ``planes/NAME.csv`` holds them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lelight.errors import OutputError
from lelight.reports.folder import CALC, Subject
from lelight.scene import FloatArray

COLUMNS = ("x_m", "y_m", "z_m", "illuminance_lx")


@dataclass(frozen=True)
class PlaneGrid:
    """Illuminance at the points of a plane.

    Attributes
    ----------
    points : (rows, columns, 3) float, m; scene axes
    illuminance : (rows, columns) float, lx
    """

    points: FloatArray
    illuminance: FloatArray

    @property
    def steps(self) -> tuple[FloatArray, FloatArray]:
        """Vectors (3,) in m from a point to its neighbour in the row, and in the column.

        Where there is one row (or column) only, its width is not in the file: zero.
        """
        along_row = self.points[0, 1] - self.points[0, 0] if self.points.shape[1] > 1 else np.zeros(3)
        along_column = self.points[1, 0] - self.points[0, 0] if self.points.shape[0] > 1 else np.zeros(3)
        return along_row, along_column

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance in m of neighbours in a row and in a column; a lone row is as wide as the other step."""
        along_row, along_column = (float(np.linalg.norm(step)) for step in self.steps)
        return along_row or along_column or 1.0, along_column or along_row or 1.0

    @property
    def outline(self) -> FloatArray:
        """Corners (4, 3) in m of the rectangle of the grid's cells."""
        row, column = (step / 2.0 for step in self.steps)
        return np.array(
            [
                self.points[0, 0] - row - column,
                self.points[0, -1] + row - column,
                self.points[-1, -1] + row + column,
                self.points[-1, 0] - row + column,
            ]
        )


def read_plane_grid(path: Path, plane: Subject) -> PlaneGrid:
    """Read a plane's ``.csv`` into the grid that its entry in ``metrics.json`` announces."""
    rows, columns = _shape(path, plane)
    table = _table(path)
    if len(table) != rows * columns:
        raise OutputError(
            f"{path}: {len(table)} points, metrics.json announces {rows} x {columns}; {CALC} anew"
        )
    return PlaneGrid(table[:, :3].reshape(rows, columns, 3), table[:, 3].reshape(rows, columns))


def _shape(path: Path, plane: Subject) -> tuple[int, int]:
    grid = plane.entry.get("grid") or {}
    try:
        rows, columns = int(grid["rows"]), int(grid["columns"])
    except (TypeError, KeyError, ValueError) as error:
        raise OutputError(
            f"{path.parents[1] / 'metrics.json'}: planes.{plane.name}.grid is missing; {CALC} anew"
        ) from error
    if rows < 1 or columns < 1:
        raise OutputError(f"{path}: a grid of {rows} x {columns} points; {CALC} anew")
    return rows, columns


def _table(path: Path) -> FloatArray:
    """Columns of the file in the order of COLUMNS, (n, 4)."""
    lines = path.read_text(encoding="utf-8").splitlines()
    header = [name.strip() for name in lines[0].split(",")] if lines else []
    if missing := [name for name in COLUMNS if name not in header]:
        raise OutputError(f"{path}:1: no column {missing[0]}; {CALC} anew")
    places = [header.index(name) for name in COLUMNS]
    try:
        return np.loadtxt(lines[1:], delimiter=",", usecols=places, ndmin=2).reshape(-1, len(COLUMNS))
    except ValueError as error:
        raise OutputError(f"{path}: not a table of numbers ({error}); {CALC} anew") from error
