"""Where on the node mesh a surface point lies, and what the nodes around it say there."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from lelight.compilation import COMPILED
from lelight.mesh.nearest import TriangleGrid
from lelight.mesh.nodes import NodeMesh
from lelight.scene import BoolArray, FloatArray, IntArray


class Locator:
    """Finds the nodes and weights from which a value at a surface point is interpolated.

    Interpolation is linear in the triangle of the point's patch and side that is nearest to it: points that
    lie on a seam, or off a curved patch by its remeshing, get the weights of the nearest point of the mesh.
    """

    def __init__(self, mesh: NodeMesh) -> None:
        self._mesh = mesh
        self._grid = TriangleGrid(
            mesh.vertices[mesh.triangles], patch_sides(mesh.triangle_patches, mesh.triangle_sides)
        )
        self._visible = np.flatnonzero(~mesh.hidden)

    def __len__(self) -> int:
        """Count the nodes there are to find."""
        return len(self._mesh)

    def find(
        self, points: FloatArray, patches: IntArray, sides: IntArray, *, stand_in: bool = True
    ) -> tuple[IntArray, FloatArray]:
        """Find three nodes and their weights for each surface point.

        Hidden nodes weigh nothing; where they are all there is, the nearest visible node of the patch and
        side stands in, if any may. Where there is none the weights are zero.

        Parameters
        ----------
        points : (k, 3) float, m
        patches : (k,) int
        sides : (k,) int; +1 front, -1 back

        Returns
        -------
        nodes : (k, 3) int
        weights : (k, 3) float, non-negative, of sum 1 or all zero
        """
        if len(self._mesh) == 0:
            return np.zeros((len(points), 3), dtype=np.int64), np.zeros((len(points), 3))
        groups = patch_sides(np.asarray(patches), np.asarray(sides))
        triangles, weights = self._grid.find(points, groups)
        nodes = np.zeros((len(points), 3), dtype=np.int64)
        lost = _only_visible(triangles, self._mesh.triangles, self._mesh.hidden, nodes, weights)
        if stand_in and len(lost):
            nodes[lost, 0], weights[lost, 0] = self._nearest_visible(points[lost], groups[lost])
        return nodes, weights

    def _nearest_visible(self, points: FloatArray, groups: IntArray) -> tuple[IntArray, FloatArray]:
        """Nearest visible node (k,) of the group of each point and its weight (k,): 1, or 0 without one."""
        if len(self._visible) == 0:
            return np.zeros(len(points), dtype=np.int64), np.zeros(len(points))
        # A point's own patch is in the mesh: nodes of its group, if any is visible, are nearer than others.
        _, index = self._tree.query(np.column_stack([points, groups * self._apart]))
        return self._visible[index], (self._groups[index] == groups).astype(np.float64)

    @cached_property
    def _groups(self) -> IntArray:
        """Patch and side (v,) of each visible node."""
        return patch_sides(self._mesh.patches, self._mesh.sides)[self._visible]

    @cached_property
    def _apart(self) -> float:
        """Distance in m that sets groups apart in the tree, more than any within one."""
        return 2.0 * float(np.linalg.norm(np.ptp(self._mesh.vertices, axis=0))) + 1.0

    @cached_property
    def _tree(self) -> cKDTree:
        """Visible nodes, each group on a plane of its own."""
        return cKDTree(np.column_stack([self._mesh.positions[self._visible], self._groups * self._apart]))


def patch_sides(patches: IntArray, sides: IntArray) -> IntArray:
    """Tell apart the sides of patches: twice the patch for the front (+1), one more for the back (-1)."""
    return np.asarray(2 * patches + (sides < 0))


@njit(**COMPILED)
def _only_visible(
    found: IntArray, triangles: IntArray, hidden: BoolArray, nodes: IntArray, weights: FloatArray
) -> IntArray:
    """Write the nodes (k, 3) of the triangles found, hidden ones without weight; returns which points see none."""
    lost = np.zeros(len(found), dtype=np.bool_)
    for k in range(len(found)):
        t = found[k]
        if t < 0:
            continue
        total = 0.0
        for corner in range(3):
            node = triangles[t, corner]
            nodes[k, corner] = node
            if hidden[node]:
                weights[k, corner] = 0.0
            total += weights[k, corner]
        if total > 0.0:
            for corner in range(3):
                weights[k, corner] /= total
        else:
            lost[k] = True
    return np.flatnonzero(lost)


def interpolate(values: FloatArray, nodes: IntArray, weights: FloatArray) -> FloatArray:
    """Interpolate node values (n, ...) at located points: (k, ...), in the unit of the values; 0 without nodes."""
    if not len(values):
        return np.zeros((len(nodes), *values.shape[1:]))
    table = np.ascontiguousarray(values, dtype=np.float64).reshape(len(values), -1)
    return np.asarray(_mixed(table, nodes, weights).reshape(len(nodes), *values.shape[1:]))


@njit(**COMPILED)
def _mixed(values: FloatArray, nodes: IntArray, weights: FloatArray) -> FloatArray:
    """Mix rows of values (n, c) by weights (k, 3)."""
    mixed = np.empty((len(nodes), values.shape[1]))
    for k in range(len(nodes)):
        a, b, c = nodes[k, 0], nodes[k, 1], nodes[k, 2]
        for column in range(values.shape[1]):
            mixed[k, column] = (
                weights[k, 0] * values[a, column]
                + weights[k, 1] * values[b, column]
                + weights[k, 2] * values[c, column]
            )
    return mixed
