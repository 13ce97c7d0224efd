"""Where observers, planes and luminaires are: marks, places in words and pictures of the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lelight.reports.figures.isometric import isometric_view
from lelight.reports.figures.plan import Eye, Lamp, PlanSheet, Rectangle, scene_plan, view_cones
from lelight.reports.figures.scales import LogScale, illuminance_scale
from lelight.reports.folder import ResultFolder, Subject
from lelight.reports.nodemesh import LitMesh, read_lit_mesh
from lelight.reports.planegrid import PlaneGrid, read_plane_grid
from lelight.reports.rounding import MISSING, vector
from lelight.reports.texts import Texts
from lelight.reports.vocabulary import mark
from lelight.scene import FloatArray

#: Radius in m at which a luminaire without size is drawn, and corners of a round opening.
POINT_RADIUS, ROUND_CORNERS = 0.06, 32


@dataclass(frozen=True)
class Layout:
    """The scene as pictures show it: mesh, eyes with their letters, planes and luminaires with their numbers.

    Attributes
    ----------
    shining : (k, 2, 3) float, m, outlines of surfaces that emit
    scale : of illuminance, one for plan and isometric view
    """

    mesh: LitMesh
    eyes: tuple[Eye, ...]
    rectangles: tuple[Rectangle, ...]
    lamps: tuple[Lamp, ...]
    shining: FloatArray
    scale: LogScale
    texts: Texts

    def plan(self, *, width: float, height: float, bare: bool = False) -> bytes:
        """Draw the plan with all that stands in the scene, or ``bare`` of eyes and planes."""
        eyes, rectangles = ((), ()) if bare else (self.eyes, self.rectangles)
        return scene_plan(
            self.mesh,
            self._sheet(width, height),
            self.scale,
            self.texts,
            shining=self.shining,
            lamps=self.lamps,
            eyes=eyes,
            rectangles=rectangles,
        )

    def cones(self, index: int, *, width: float, height: float) -> bytes:
        """Draw one eye and its cones of view, to lie over the bare plan of the same size."""
        return view_cones(self.eyes[index], self._sheet(width, height))

    def isometric(self, *, width: float, height: float) -> bytes:
        """Draw the scene in parallel projection."""
        return isometric_view(self.mesh, self.scale, width=width, height=height)

    def _sheet(self, width: float, height: float) -> PlanSheet:
        parts = [
            self.mesh.points,
            *(eye.position[None] for eye in self.eyes),
            *(rectangle.corners for rectangle in self.rectangles),
            *(lamp.outline for lamp in self.lamps),
        ]
        return PlanSheet.within(np.concatenate(parts), width=width, height=height)


def read_layout(folder: ResultFolder, grids: Sequence[PlaneGrid]) -> Layout:
    """Collect what pictures of the scene show from ``field.vtp``, ``run.json``, the observers and the planes' grids."""
    mesh = read_lit_mesh(folder.file("field.vtp"))
    luminaires = [entry for entry in folder.run.get("luminaires") or [] if isinstance(entry, dict)]
    lit = mesh.illuminance[~mesh.hidden]
    return Layout(
        mesh=mesh,
        eyes=tuple(_eye(index, observer) for index, observer in enumerate(folder.observers)),
        rectangles=tuple(Rectangle(f"P{index}", grid.outline) for index, grid in enumerate(grids, start=1)),
        lamps=tuple(_lamp(f"L{number}", entry) for number, entry in enumerate(luminaires, start=1)),
        shining=mesh.outlines_of(_shining(folder.run)),
        scale=illuminance_scale(lit),
        texts=folder.texts,
    )


def read_grids(folder: ResultFolder) -> list[PlaneGrid]:
    """Read the grid of every plane, in the order of ``metrics.json``."""
    return [read_plane_grid(folder.file("planes", f"{plane.stem}.csv"), plane) for plane in folder.planes]


def observer_place(index: int, observer: Subject) -> dict[str, str]:
    """Mark, name, position and line of sight of an observer in words."""
    return {
        "mark": mark(index),
        "name": observer.name,
        "position": _vector(observer, "position"),
        "direction": _vector(observer, "direction"),
    }


def plane_place(index: int, plane: Subject, grid: PlaneGrid) -> dict[str, str]:
    """Mark, name, corner, size and grid of a plane in words; corner and size in m."""
    rows, columns = grid.illuminance.shape
    sides = np.array([columns, rows]) * grid.spacing
    return {
        "mark": f"P{index + 1}",
        "name": plane.name,
        "corner": vector(grid.outline[0].tolist()),
        "size": f"{sides[0]:.2f} × {sides[1]:.2f}",
        "grid": f"{columns} × {rows}",
    }


def direction_of(observer: Subject) -> FloatArray:
    """Line of sight (3,), unit length; along x where the entry has none."""
    direction = np.asarray(observer.entry.get("direction") or (1.0, 0.0, 0.0), dtype=np.float64)
    return np.asarray(direction / (np.linalg.norm(direction) or 1.0))


def _eye(index: int, observer: Subject) -> Eye:
    position = np.asarray(observer.entry.get("position") or (0.0, 0.0, 0.0), dtype=np.float64)
    return Eye(mark(index), position, direction_of(observer))


def _lamp(name: str, entry: Mapping[str, Any]) -> Lamp:
    """Outline of an opening along its own axes; of a point luminaire a small circle without direction."""
    position = np.asarray(entry.get("position") or (0.0, 0.0, 0.0), dtype=np.float64)
    aim, c0 = entry.get("aim"), np.asarray(entry.get("c0") or (0.0, 0.0, 0.0), dtype=np.float64)
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND_CORNERS, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    sizes = np.asarray(entry.get("opening_m") or (0.0, 0.0, 0.0), dtype=np.float64)
    if aim is None or not sizes[:2].any():
        flat = POINT_RADIUS * np.column_stack([circle, np.zeros(len(circle))])
        return Lamp(name, position, position + flat, c0)
    across = np.cross(-np.asarray(aim, dtype=np.float64), c0)
    square = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    weights = 0.5 * sizes[:2] * (circle if entry.get("opening") in {"ellipse", "ellipsoid"} else square)
    return Lamp(name, position, position + weights @ np.stack([c0, across]), c0)


def _shining(run: Mapping[str, Any]) -> set[str]:
    """Names of the materials that emit."""
    materials = [entry for entry in run.get("materials") or [] if isinstance(entry, dict)]
    return {str(entry.get("name")) for entry in materials if any(entry.get("luminance_cd_m2") or ())}


def _vector(observer: Subject, key: str) -> str:
    components = observer.entry.get(key)
    return vector(components) if components else MISSING
