"""Surfaces of a scene out of an OBJ's geometry: metres, z up, nothing without area or twice, nothing unused."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lelight.errors import SceneError
from lelight.mesh.doubles import repeated_faces
from lelight.reading.limits import FARTHEST
from lelight.reading.obj import ObjGeometry
from lelight.scene import BoolArray, FloatArray, IntArray, triangle_areas

#: Metres in one unit of the OBJ; the foot and the inch are the international ones of 1959.
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}

#: A triangle lower than this share of its longest edge has no area at double precision.
FLATTEST = 1e-12

#: Triangles measured in one go.
AT_A_TIME = 1 << 17


@dataclass(frozen=True)
class Surfaces:
    """Triangles with area, and the materials they use.

    Attributes
    ----------
    vertices : (n, 3) float, m, z up; every one is used
    triangles : (m, 3) int into vertices
    triangle_materials : (m,) int into material_names
    material_areas : (k,) float, m², of all triangles of each material
    """

    vertices: FloatArray
    triangles: IntArray
    triangle_materials: IntArray
    material_names: tuple[str, ...]
    material_areas: FloatArray
    warnings: tuple[str, ...] = ()


def lit_surfaces(path: Path, geometry: ObjGeometry, *, unit: str, up: str) -> Surfaces:
    """Bring a geometry to metres and z up, and leave out what no light can fall on.

    Raises
    ------
    SceneError
        where nothing has an area, or something is farther off than any building
    """
    used, triangles = _renumbered(geometry.triangles, len(geometry.vertices))
    vertices = z_up(geometry.vertices[used], up) * METRES[unit]
    farthest = float(np.abs(vertices).max())
    if farthest > FARTHEST:
        raise SceneError(
            f"{path}: found a vertex {farthest:.3g} m from the origin; allowed are {FARTHEST:g} m; "
            f"check the unit, which is {unit}"
        )
    areas, longest = _extents(vertices, triangles)
    kept = 2 * areas > FLATTEST * longest**2
    if not kept.any():
        raise SceneError(f"{path}: no face has an area; nothing can be lit; check the unit and the export")
    flat = int(np.count_nonzero(~kept))
    kept[kept] = ~_repeated(vertices, triangles[kept])
    repeated = len(kept) - flat - int(np.count_nonzero(kept))
    return _surfaces(
        vertices,
        triangles[kept],
        geometry.triangle_materials[kept],
        areas[kept],
        geometry.material_names,
        warnings=_left_out(flat, repeated),
    )


def _repeated(vertices: FloatArray, triangles: IntArray) -> BoolArray:
    """Mark triangles (m,) written twice: left in, a lamp would shine twice and a material would be chance."""
    none = np.zeros(len(triangles), dtype=np.int64)
    return repeated_faces(vertices, triangles, none, two_sided=none > 0)


def _left_out(flat: int, repeated: int) -> tuple[str, ...]:
    said = [f"{flat} triangles without area are left out"] * (flat > 0)
    said += [f"{repeated} faces that lie on an earlier one are left out"] * (repeated > 0)
    return tuple(said)


def z_up(points: FloatArray, up: str) -> FloatArray:
    """Points (n, 3) turned so that the axis ``up``, y or z, becomes z: (x, y, z) to (x, -z, y)."""
    if up == "z":
        return points
    return np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)


def _renumbered(indices: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Which of ``count`` items the indices use, and the indices into those alone."""
    used = np.zeros(count, dtype=bool)
    used[indices] = True
    return np.flatnonzero(used), (np.cumsum(used) - 1)[indices]


def _extents(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, FloatArray]:
    """Area (m,) and longest edge (m,) of triangles, a part at a time to keep memory small."""
    areas, longest = np.empty(len(triangles)), np.empty(len(triangles))
    for first in range(0, len(triangles), AT_A_TIME):
        part = slice(first, first + AT_A_TIME)
        corners = vertices[triangles[part]]
        areas[part] = triangle_areas(corners)
        longest[part] = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return areas, longest


def _surfaces(
    vertices: FloatArray,
    triangles: IntArray,
    material_indices: IntArray,
    areas: FloatArray,
    material_names: tuple[str, ...],
    *,
    warnings: tuple[str, ...],
) -> Surfaces:
    used_vertices, renumbered = _renumbered(triangles, len(vertices))
    used_materials, materials = _renumbered(material_indices, len(material_names))
    return Surfaces(
        vertices=vertices[used_vertices],
        triangles=renumbered,
        triangle_materials=materials,
        material_names=tuple(material_names[material] for material in used_materials),
        material_areas=np.bincount(materials, weights=areas).astype(np.float64),
        warnings=warnings,
    )
