"""Nodes: where the light is estimated.

A node has one position, one normal, one material and one side. A surface lit from both sides carries two
nodes at each of its mesh vertices, each with its own normal.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from lelight.mesh.insets import inset_positions
from lelight.scene import BoolArray, FloatArray, IntArray, triangle_areas


@dataclass(frozen=True)
class SurfaceMesh:
    """The remeshed surface, patch by patch, before sides are known.

    Attributes
    ----------
    vertices : (n, 3) float, m; no vertex belongs to two patches
    triangles : (m, 3) int into vertices, wound as the input
    triangle_patches : (m,) int
    normals : (n, 3) float, unit, on the front side of the input's winding
    vertex_patches : (n,) int
    patch_materials : (n_patches,) int into the scene's materials
    """

    vertices: FloatArray
    triangles: IntArray
    triangle_patches: IntArray
    normals: FloatArray
    vertex_patches: IntArray
    patch_materials: IntArray


@dataclass(frozen=True)
class NodeMesh:
    """Nodes and the triangles between them.

    Attributes
    ----------
    vertices : (n, 3) float, m; exact corners of the remeshed surface
    positions : (n, 3) float, m; where the estimate holds: ``vertices`` drawn in from the patch's border
    normals : (n, 3) float, unit, pointing to the node's own side
    frames_x : (n, 3) float, unit; x axis of the local frame whose z is the normal (y = z × x)
    areas : (n,) float, m²; a third of the triangles around the node
    materials, patches : (n,) int
    sides : (n,) int; +1 the front of the input's winding, -1 its back
    hidden : (n,) bool; the node sees no lit space (buried where solids touch)
    triangles : (m, 3) int into nodes, anticlockwise seen from the node's side
    """

    vertices: FloatArray
    positions: FloatArray
    normals: FloatArray
    frames_x: FloatArray
    areas: FloatArray
    materials: IntArray
    patches: IntArray
    sides: IntArray
    hidden: BoolArray
    triangles: IntArray

    @property
    def visible_areas(self) -> FloatArray:
        """(n,) float, m²: areas with those of hidden nodes set to zero."""
        return np.where(self.hidden, 0.0, self.areas)

    @property
    def open_triangles(self) -> BoolArray:
        """(m,) bool: triangles without hidden nodes."""
        return np.asarray(~self.hidden[self.triangles].any(axis=1))

    @property
    def triangle_patches(self) -> IntArray:
        """(m,) int: patch of each triangle."""
        return self.patches[self.triangles[:, 0]]

    @property
    def triangle_sides(self) -> IntArray:
        """(m,) int: side of each triangle."""
        return self.sides[self.triangles[:, 0]]

    @property
    def triangle_materials(self) -> IntArray:
        """(m,) int: material of each triangle."""
        return self.materials[self.triangles[:, 0]]

    def __len__(self) -> int:
        """Count nodes."""
        return len(self.positions)


#: Border nodes stand off the border of their patch by this part of the local edge length.
INSET = 2e-3


def node_mesh(surface: SurfaceMesh, lit: BoolArray, *, inset: float = INSET) -> NodeMesh:
    """Give each lit side of each patch nodes of its own: first all fronts, then all backs.

    Parameters
    ----------
    lit : (n_patches, 2) bool; column 0 the front, column 1 the back
    inset : distance of border nodes from the border, in lengths of the edges around them
    """
    positions = inset_positions(surface.vertices, surface.triangles, inset=inset)
    front = _side(surface, positions, lit[:, 0], 1)
    back = _side(surface, positions, lit[:, 1], -1)
    columns = {
        column.name: np.concatenate([getattr(front, column.name), getattr(back, column.name)])
        for column in fields(NodeMesh)
    }
    return NodeMesh(**columns | {"triangles": np.concatenate([front.triangles, back.triangles + len(front)])})


def hide(mesh: NodeMesh, mask: BoolArray) -> NodeMesh:
    """Copy the mesh with exactly the nodes of the mask (n,) hidden."""
    return replace(mesh, hidden=np.array(mask, dtype=bool))


def frames_x(normals: FloatArray) -> FloatArray:
    """Choose the x axes (n, 3) of frames whose z axes are the unit normals (n, 3).

    Duff et al., "Building an orthonormal basis, revisited", J. Computer Graphics Techniques 6 (2017): without
    branches, and well conditioned for every normal.
    """
    x, y, z = normals.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    return np.stack([1.0 + sign * x * x * a, sign * x * y * a, -sign * x], axis=1)


def _side(surface: SurfaceMesh, positions: FloatArray, lit: BoolArray, side: int) -> NodeMesh:
    """Nodes on one side (+1 or -1) of the patches that are lit (n_patches,) there."""
    chosen = lit[surface.vertex_patches]
    number = np.cumsum(chosen) - 1
    normals = side * surface.normals[chosen]
    patches = surface.vertex_patches[chosen]
    return NodeMesh(
        vertices=surface.vertices[chosen],
        positions=positions[chosen],
        normals=normals,
        frames_x=frames_x(normals),
        areas=_node_areas(surface)[chosen],
        materials=surface.patch_materials[patches],
        patches=patches,
        sides=np.full(len(patches), side, dtype=np.int64),
        hidden=np.zeros(len(patches), dtype=bool),
        triangles=number[surface.triangles[lit[surface.triangle_patches]][:, ::side]],
    )


def _node_areas(surface: SurfaceMesh) -> FloatArray:
    """Give each vertex a third (n,) m² of the triangles around it."""
    thirds = np.repeat(triangle_areas(surface.vertices[surface.triangles]) / 3, 3)
    return np.bincount(surface.triangles.ravel(), thirds, len(surface.vertices)).astype(np.float64)
