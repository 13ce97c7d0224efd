"""The node mesh of ``field.vtp``, as much of it as a plan of the scene shows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lelight.errors import OutputError
from lelight.reports.folder import CALC
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.writing.vtpreading import read_polydata

#: cos of the steepest slope that still counts as facing up.
UPWARD = 0.5


@dataclass(frozen=True)
class LitMesh:
    """Triangles with the illuminance at their corners.

    Attributes
    ----------
    points : (n, 3) float, m
    triangles : (m, 3) int into points
    illuminance : (n,) float, lx
    normals : (n, 3) float, unit, on the lit side
    hidden : (n,) bool; nodes that see no lit space
    """

    points: FloatArray
    triangles: IntArray
    illuminance: FloatArray
    normals: FloatArray
    hidden: BoolArray

    @property
    def upward(self) -> IntArray:
        """(k, 3) triangles seen from above, the lowest first, without those that touch a hidden node."""
        facing = (self.normals[self.triangles, 2] > UPWARD).all(axis=1)
        shown = self.triangles[facing & ~self.hidden[self.triangles].any(axis=1)]
        return np.asarray(shown[np.argsort(self.points[shown, 2].mean(axis=1), kind="stable")])

    @property
    def border(self) -> FloatArray:
        """(k, 2, 3) ends in m of the edges that belong to one triangle only: the outlines of surfaces."""
        edges = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, uses = np.unique(edges, axis=0, return_counts=True)
        return np.asarray(self.points[unique[uses == 1]])


def read_lit_mesh(path: Path) -> LitMesh:
    """Read ``field.vtp``; an array that is not there is an OutputError naming it."""
    content = read_polydata(path)
    arrays = content.point_arrays
    if missing := [name for name in ("illuminance_lx", "normal", "hidden") if name not in arrays]:
        raise OutputError(f"{path}: no array {missing[0]}; {CALC} anew")
    return LitMesh(
        points=np.asarray(content.points, dtype=np.float64),
        triangles=content.polygons.reshape(-1, 3),
        illuminance=np.asarray(arrays["illuminance_lx"], dtype=np.float64),
        normals=np.asarray(arrays["normal"], dtype=np.float64),
        hidden=arrays["hidden"] != 0,
    )
