"""Grids on flat quadrilaterals: the faces of boxes, walls and table tops, all at once.

Most patches of a building are rectangles. A structured grid covers them exactly, needs no remeshing engine
and wastes no node, whatever needles the modeller's triangulation holds.
"""

from __future__ import annotations

import numpy as np

from lelight.scene import FloatArray, IntArray


def grid_quads(corners: FloatArray, *, edge: float) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Lay a grid of cells of at most ``edge`` by ``edge`` over flat convex quadrilaterals.

    Parameters
    ----------
    corners : (k, 4, 3) float, m, anticlockwise seen from the front
    edge : float, m

    Returns
    -------
    vertices : (n, 3) float, m
    triangles : (m, 3) int, anticlockwise seen from the front
    vertex_quads : (n,) int, the quadrilateral of each vertex, ascending
    triangle_quads : (m,) int, ascending
    """
    counts = _cell_counts(corners, edge)
    shapes, shape_of = np.unique(counts, axis=0, return_inverse=True)
    vertex_counts, triangle_counts = (counts + 1).prod(axis=1), 2 * counts.prod(axis=1)
    first_vertex = np.cumsum(vertex_counts) - vertex_counts
    first_triangle = np.cumsum(triangle_counts) - triangle_counts
    vertices = np.empty((int(vertex_counts.sum()), 3))
    triangles = np.empty((int(triangle_counts.sum()), 3), dtype=np.int64)
    for number, (columns, rows) in enumerate(shapes):
        members = np.flatnonzero(shape_of.ravel() == number)
        points, cells = _bilinear(corners[members], columns, rows), _grid_cells(columns, rows)
        vertices[first_vertex[members, None] + np.arange(points.shape[1])] = points
        triangles[first_triangle[members, None] + np.arange(len(cells))] = (
            first_vertex[members, None, None] + cells
        )
    quads = np.arange(len(corners))
    return vertices, triangles, np.repeat(quads, vertex_counts), np.repeat(quads, triangle_counts)


def _cell_counts(corners: FloatArray, edge: float) -> IntArray:
    """Columns and rows (k, 2): enough for the longer of two opposite sides."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    longer = np.maximum(sides[:, :2], sides[:, 2:])
    return np.asarray(np.maximum(np.ceil(longer / edge * (1 - 1e-9)), 1).astype(np.int64))


def _bilinear(corners: FloatArray, columns: int, rows: int) -> FloatArray:
    """Points (k, (rows + 1) (columns + 1), 3) at equal parts of the sides, row by row."""
    v, u = (axis.ravel() for axis in np.meshgrid(_parts(rows), _parts(columns), indexing="ij"))
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
    return np.asarray(np.einsum("cp,kcx->kpx", weights, corners))


def _parts(count: int) -> FloatArray:
    return np.arange(count + 1) / count


def _grid_cells(columns: int, rows: int) -> IntArray:
    """Triangles (2 rows columns, 3) of a grid, the diagonal turning from cell to cell like a chessboard."""
    row, column = (axis.ravel() for axis in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    a = row * (columns + 1) + column
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    rising = np.stack([a, b, c, a, c, d], axis=1)
    falling = np.stack([a, b, d, b, c, d], axis=1)
    even = ((row + column) % 2 == 0)[:, None]
    return np.asarray(np.where(even, rising, falling).reshape(-1, 3))
