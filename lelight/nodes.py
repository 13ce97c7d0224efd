"""Nodes: where the light is estimated.

A node has one position, one normal, one material and one side. A surface lit from both sides carries two
nodes at each of its mesh vertices, each with its own normal.
"""

from __future__ import annotations

from dataclasses import dataclass

from lelight.scene import BoolArray, FloatArray, IntArray


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
