"""Where observers and planes are: marks, places in words and the plan of the scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lelight.reports.figures.plan import Eye, Rectangle, scene_plan
from lelight.reports.folder import ResultFolder, Subject
from lelight.reports.nodemesh import LitMesh, read_lit_mesh
from lelight.reports.planegrid import PlaneGrid, read_plane_grid
from lelight.reports.rounding import MISSING, vector, with_unit
from lelight.reports.vocabulary import mark
from lelight.scene import FloatArray


@dataclass(frozen=True)
class Layout:
    """The scene as a plan shows it: mesh, eyes with their letters, planes with their numbers."""

    mesh: LitMesh
    eyes: tuple[Eye, ...]
    rectangles: tuple[Rectangle, ...]

    def drawn(self, *, width: float, height: float, only: int | None = None) -> bytes:
        """Draw the plan, with all eyes and planes or with one eye alone."""
        eyes = self.eyes if only is None else self.eyes[only : only + 1]
        rectangles = self.rectangles if only is None else ()
        return scene_plan(self.mesh, eyes, rectangles, width=width, height=height)


def read_layout(folder: ResultFolder, grids: Sequence[PlaneGrid]) -> Layout:
    """Collect what a plan shows from ``field.vtp``, the observers and the planes' grids."""
    return Layout(
        mesh=read_lit_mesh(folder.file("field.vtp")),
        eyes=tuple(_eye(index, observer) for index, observer in enumerate(folder.observers)),
        rectangles=tuple(Rectangle(f"P{index}", grid.outline) for index, grid in enumerate(grids, start=1)),
    )


def read_grids(folder: ResultFolder) -> list[PlaneGrid]:
    """Read the grid of every plane, in the order of ``metrics.json``."""
    return [read_plane_grid(folder.file("planes", f"{plane.stem}.csv"), plane) for plane in folder.planes]


def observer_place(index: int, observer: Subject) -> dict[str, str]:
    """Mark, name, position and line of sight of an observer in words."""
    return {
        "mark": mark(index),
        "name": observer.name,
        "position": _vector(observer, "position", unit="m"),
        "direction": _vector(observer, "direction", unit=""),
    }


def plane_place(index: int, plane: Subject, grid: PlaneGrid) -> dict[str, str]:
    """Mark, name, corner, size and grid of a plane in words."""
    rows, columns = grid.illuminance.shape
    sides = np.array([columns, rows]) * grid.spacing
    return {
        "mark": f"P{index + 1}",
        "name": plane.name,
        "corner": with_unit(vector(grid.outline[0].tolist()), "m"),
        "size": with_unit(f"{sides[0]:.2f} × {sides[1]:.2f}", "m"),
        "grid": f"{columns} × {rows}",
    }


def direction_of(observer: Subject) -> FloatArray:
    """Line of sight (3,), unit length; along x where the entry has none."""
    direction = np.asarray(observer.entry.get("direction") or (1.0, 0.0, 0.0), dtype=np.float64)
    return np.asarray(direction / (np.linalg.norm(direction) or 1.0))


def _eye(index: int, observer: Subject) -> Eye:
    position = np.asarray(observer.entry.get("position") or (0.0, 0.0, 0.0), dtype=np.float64)
    return Eye(mark(index), position, direction_of(observer))


def _vector(observer: Subject, key: str, *, unit: str) -> str:
    components = observer.entry.get(key)
    return with_unit(vector(components), unit) if components else MISSING
