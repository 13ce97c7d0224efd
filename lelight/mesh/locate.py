"""Where on the node mesh a surface point lies, and what the nodes around it say there."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from lelight.mesh.nearest import TriangleGrid
from lelight.mesh.nodes import NodeMesh
from lelight.scene import FloatArray, IntArray


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

    def find(self, points: FloatArray, patches: IntArray, sides: IntArray) -> tuple[IntArray, FloatArray]:
        """Find three nodes and their weights for each surface point.

        Hidden nodes weigh nothing; where they are all there is, the nearest visible node of the patch and
        side stands in. Where a patch's side has no visible node the weights are zero.

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
        nodes[triangles >= 0] = self._mesh.triangles[triangles[triangles >= 0]]
        weights[self._mesh.hidden[nodes]] = 0.0
        total = weights.sum(axis=1)
        seen = total > 0
        weights[seen] /= total[seen, None]
        lost = np.flatnonzero(~seen & (triangles >= 0))
        if len(lost):
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


def interpolate(values: FloatArray, nodes: IntArray, weights: FloatArray) -> FloatArray:
    """Interpolate node values (n, ...) at located points: (k, ...), in the unit of the values."""
    return np.asarray(np.einsum("kc,kc...->k...", weights, values[nodes]))
