"""Faces that lie exactly on one another, as exporters write them.

A face written twice is one face: a ray meets one of the two by chance, and a lamp drawn twice would shine
twice. Two faces back to back are the two sides of a sheet without thickness, each with a material of its own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lelight.mesh.patches import weld
from lelight.scene import BoolArray, FloatArray, IntArray, Scene


def repeated_faces(
    vertices: FloatArray, triangles: IntArray, materials: IntArray, *, two_sided: BoolArray
) -> BoolArray:
    """Mark triangles (m,) that an earlier one makes superfluous: same corners, and the same front.

    Back to back, too, a face of the same material is superfluous where that material looks the same from
    both sides.

    Parameters
    ----------
    vertices : (n, 3) float, m
    triangles : (m, 3) int
    materials : (m,) int
    two_sided : (m,) bool, whether the triangle's material looks the same from both sides
    """
    places, winding = _places(vertices, triangles)
    # A sheet of one material is the same sheet whichever way its second face is wound.
    by_side = np.column_stack([places, np.where(two_sided, materials, -1)])
    return _later(np.column_stack([places, winding])) | (two_sided & _later(by_side))


def without_repeated_faces(scene: Scene) -> Scene:
    """Copy a scene without the faces that lie on an earlier one; the scene itself where there are none."""
    repeated = repeated_faces(
        scene.vertices,
        scene.triangles,
        scene.triangle_materials,
        two_sided=~scene.emitting,
    )
    if not repeated.any():
        return scene
    return replace(
        scene,
        triangles=scene.triangles[~repeated],
        triangle_materials=scene.triangle_materials[~repeated],
    )


def backs(vertices: FloatArray, triangles: IntArray) -> IntArray:
    """Triangle (m,) that lies back to back with each, on the same three corners; -1 where none does."""
    places, winding = _places(vertices, triangles)
    back = np.full(len(triangles), -1, dtype=np.int64)
    order = np.lexsort((winding, *places.T))
    same = (np.diff(places[order], axis=0) == 0).all(axis=1) & (np.diff(winding[order]) != 0)
    one, other = order[:-1][same], order[1:][same]
    back[one], back[other] = other, one
    return back


def _places(vertices: FloatArray, triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Corners (m, 3) as ascending numbers, equal for equal places, and the sense (m,) of their order, 1 or -1."""
    points = weld(vertices)[triangles]
    order = np.argsort(points, axis=1, kind="stable")
    even = (np.roll(order, -1, axis=1)[:, 0] - order[:, 0]) % 3 == 1
    return np.take_along_axis(points, order, axis=1), np.where(even, 1, -1)


def _later(rows: IntArray) -> BoolArray:
    """Mark the rows (m, k) that repeat an earlier one."""
    order = np.lexsort(rows.T)
    later = np.zeros(len(rows), dtype=np.bool_)
    later[order[1:]] = (np.diff(rows[order], axis=0) == 0).all(axis=1)
    return later
