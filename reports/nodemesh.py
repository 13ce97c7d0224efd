"""The node mesh of ``field.vtp``, as much of it as pictures of the scene show."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from lelight.errors import OutputError
from lelight.reports.folder import CALC
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.writing.views import partly_seen, shown_values
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
    materials : (m,) int into ``material_names``, of the triangles; -1 where the file does not say
    """

    points: FloatArray
    triangles: IntArray
    illuminance: FloatArray
    normals: FloatArray
    hidden: BoolArray
    materials: IntArray
    material_names: tuple[str, ...] = field(default=())

    @property
    def lit(self) -> BoolArray:
        """(m,) bool: triangles with a corner that is not hidden."""
        return partly_seen(self.triangles, self.hidden)

    @property
    def shown(self) -> FloatArray:
        """(n,) illuminance in lx; a hidden node takes the mean of its visible neighbours, whose triangles are shown."""
        return shown_values(self.triangles, self.illuminance, self.hidden)

    @property
    def upward(self) -> IntArray:
        """(k, 3) triangles seen from above, the lowest first, without those that are all hidden."""
        facing = (self.normals[self.triangles, 2] > UPWARD).all(axis=1)
        shown = self.triangles[facing & self.lit]
        return np.asarray(shown[np.argsort(self.points[shown, 2].mean(axis=1), kind="stable")])

    @property
    def border(self) -> FloatArray:
        """(k, 2, 3) ends in m of the edges that belong to one triangle only: the outlines of surfaces."""
        return self.outline_of(self.triangles)

    def outlines_of(self, materials: Collection[str]) -> FloatArray:
        """(k, 2, 3) ends in m of the outlines of surfaces of these materials."""
        numbers = [number for number, name in enumerate(self.material_names) if name in materials]
        return self.outline_of(self.triangles[np.isin(self.materials, numbers)])

    def outline_of(self, triangles: IntArray) -> FloatArray:
        """(k, 2, 3) ends in m of the edges that belong to one of these triangles (m, 3) only."""
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, uses = np.unique(edges, axis=0, return_counts=True)
        return np.asarray(self.points[unique[uses == 1]])


def read_lit_mesh(path: Path) -> LitMesh:
    """Read ``field.vtp``; an array that is not there is an OutputError naming it."""
    content = read_polydata(path)
    arrays = content.point_arrays
    if missing := [name for name in ("illuminance_lx", "normal", "hidden") if name not in arrays]:
        raise OutputError(f"{path}: no array {missing[0]}; {CALC} anew")
    triangles = content.polygons.reshape(-1, 3)
    return LitMesh(
        points=np.asarray(content.points, dtype=np.float64),
        triangles=triangles,
        illuminance=np.asarray(arrays["illuminance_lx"], dtype=np.float64),
        normals=np.asarray(arrays["normal"], dtype=np.float64),
        hidden=arrays["hidden"] != 0,
        materials=np.asarray(
            content.cell_arrays.get("material_id", np.full(len(triangles), -1)), dtype=np.int64
        ),
        material_names=tuple(content.texts.get("material_names", ())),
    )
