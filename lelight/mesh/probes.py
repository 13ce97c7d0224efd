"""Probe points between the nodes: there interpolation is held against the light itself.

No replicate sees the error of interpolation, since all share the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lelight.mesh.locate import Locator
from lelight.mesh.nearest import nearest_points
from lelight.mesh.nodes import NodeMesh
from lelight.scene import FloatArray, IntArray, triangle_areas, triangle_normals

#: One probe for so many nodes, and the least and most of them.
NODES_PER_PROBE, LEAST_PROBES, MOST_PROBES = 16, 16, 512


@dataclass(frozen=True)
class Probes:
    """k points drawn by area on the sides that carry nodes.

    Attributes
    ----------
    points, normals : (k, 3) float, m and unit length, on the traced surface
    nodes, weights : (k, 3) int and float, from which a value there is interpolated
    """

    points: FloatArray
    normals: FloatArray
    nodes: IntArray
    weights: FloatArray

    def __len__(self) -> int:
        """Count probes."""
        return len(self.points)


def draw_probes(mesh: NodeMesh, corners: FloatArray, labels: IntArray, *, seed: int) -> Probes:
    """Draw points inside the triangles of visible nodes, by area.

    Parameters
    ----------
    corners : (n_t, 3, 3) float, m, of the traced triangles
    labels : (n_t,) int, their patches
    """
    open_triangles = np.flatnonzero(mesh.open_triangles)
    if not len(open_triangles):
        return Probes(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3)))
    rng = np.random.default_rng((seed, NODES_PER_PROBE))
    count = int(np.clip(len(mesh) // NODES_PER_PROBE, LEAST_PROBES, MOST_PROBES))
    drawn = open_triangles[_by_area(mesh, open_triangles, (np.arange(count) + rng.random(count)) / count)]
    flat = np.einsum("kc,kcx->kx", rng.dirichlet(np.ones(3), count), mesh.vertices[mesh.triangles[drawn]])
    patches, sides = mesh.triangle_patches[drawn], mesh.triangle_sides[drawn]
    # On a curved patch the mesh leaves the surface that rays meet.
    points, traced = nearest_points(flat, patches, corners, labels)
    nodes, shares = Locator(mesh).find(points, patches, sides)
    return Probes(points, sides[:, None] * triangle_normals(corners[traced]), nodes, shares)


def _by_area(mesh: NodeMesh, triangles: IntArray, u: FloatArray) -> IntArray:
    """Choose among triangles (m,) by area, for uniform numbers (k,)."""
    reach = np.cumsum(triangle_areas(mesh.vertices[mesh.triangles[triangles]]))
    return np.asarray(np.minimum(np.searchsorted(reach, u * reach[-1], side="right"), len(triangles) - 1))
