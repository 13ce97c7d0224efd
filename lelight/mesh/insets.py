"""Insets: border nodes are drawn a little into their patch, off the walls that meet it there.

A node exactly on a concave edge lies in the plane of the wall beside it, sees nothing of that wall and gets
half the light it should; in a corner a quarter.
"""

from __future__ import annotations

import numpy as np

from lelight.mesh.edges import directed_edges, on_border
from lelight.scene import BoolArray, FloatArray, IntArray, triangle_normals

#: At a sharp corner the way inwards is at most this many insets long.
LONGEST_WAY = 4.0

#: A way leads into a triangle up to this rounding of its direction.
ROUNDING = 1e-9


def inset_positions(vertices: FloatArray, triangles: IntArray, *, inset: float) -> FloatArray:
    """Draw the vertices on the border of their patch inwards; the others stay.

    Both border edges at a vertex push it at right angles by ``inset`` local edge lengths, so it ends that far
    from either, but no further than half-way through the triangle that it is pushed into. Where that leads
    out of the patch (a slit, a border that touches itself) it goes towards the centroid of its largest
    triangle.

    Parameters
    ----------
    vertices : (n, 3) float, m
    triangles : (m, 3) int
    inset : in lengths of the edges around the vertex

    Returns
    -------
    (n, 3) float, m; on the triangles around each vertex
    """
    single = on_border(triangles)
    border = np.zeros(len(vertices), dtype=np.bool_)
    border[triangles.ravel()[_border_corners(single)]] = True
    # What is inside the patches, which is nearly all of a fine mesh, stays where it is.
    along = border[triangles].any(axis=1)
    triangles, single = triangles[along], single.reshape(-1, 3)[along].ravel()
    distance = inset * _local_edges(vertices, triangles)
    ahead, back = _corner_edges(vertices, triangles)
    vertex = triangles.ravel()
    steps, leads_in = _steps_inside(
        (_inward_ways(vertices, triangles, single) * distance[:, None])[vertex], ahead, back
    )
    chosen = _best_corners(vertex, leads_in, np.linalg.norm(np.cross(ahead, back), axis=1))
    centroids = _shortened((ahead[chosen] + back[chosen]) / 3, distance[vertex[chosen]])
    chosen_steps = np.where(leads_in[chosen, None], steps[chosen], centroids)
    moved = border[vertex[chosen]]
    positions = vertices.copy()
    positions[vertex[chosen[moved]]] += chosen_steps[moved]
    return positions


def _corner_edges(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, FloatArray]:
    """Edges from each corner (3 m, 3) of the triangles to the next corner and to the one before, m."""
    corners = vertices[triangles]
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    return ahead.reshape(-1, 3), back.reshape(-1, 3)


def _border_corners(single: BoolArray) -> IntArray:
    """Corners at either end of a border edge (3 m,), as indices into the raveled triangles."""
    leaving = np.flatnonzero(single)
    return np.concatenate([leaving, leaving - leaving % 3 + (leaving + 1) % 3])


def _local_edges(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Mean length (n,) m of the edges of the triangles around each vertex."""
    vertex, end = directed_edges(triangles)
    lengths = np.linalg.norm(vertices[end] - vertices[vertex], axis=1).reshape(-1, 3)
    total = np.bincount(vertex, np.repeat(lengths.mean(axis=1), 3), len(vertices))
    return np.asarray(total / np.maximum(np.bincount(vertex, minlength=len(vertices)), 1))


def _inward_ways(vertices: FloatArray, triangles: IntArray, single: BoolArray) -> FloatArray:
    """Ways (n, 3) of the vertices if the border, edges (3 m,), moved inwards by 1 (its mitre); zero elsewhere."""
    leaving = np.flatnonzero(single)
    start, end = (points[leaving] for points in directed_edges(triangles))
    normals = triangle_normals(vertices[triangles])[leaving // 3]
    along = vertices[end] - vertices[start]
    sides = np.cross(normals, along / np.linalg.norm(along, axis=1, keepdims=True))
    inward = np.zeros_like(vertices)
    np.add.at(inward, start, sides)
    np.add.at(inward, end, sides)
    length = np.linalg.norm(inward, axis=1, keepdims=True)
    reach = np.divide(2.0, length, out=np.zeros_like(length), where=length > ROUNDING)
    return np.asarray(_unit(inward) * np.minimum(reach, LONGEST_WAY))


def _steps_inside(ways: FloatArray, ahead: FloatArray, back: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Take steps (k, 3) within the triangle of each corner, and tell whether the way leads into it (k,)."""
    aa, ab, bb = (np.einsum("kx,kx->k", *pair) for pair in ((ahead, ahead), (ahead, back), (back, back)))
    wa, wb = np.einsum("kx,kx->k", ways, ahead), np.einsum("kx,kx->k", ways, back)
    parts = np.stack([wa * bb - wb * ab, wb * aa - wa * ab])
    determinant = aa * bb - ab * ab
    parts = np.divide(parts, determinant, out=np.zeros_like(parts), where=determinant > 0)
    total = np.abs(parts).sum(axis=0)
    leads_in = (total > 0) & (parts.min(axis=0) >= -ROUNDING * total)
    parts = np.maximum(parts, 0.0) * np.minimum(1.0, 0.5 / np.where(total > 0, total, 1.0))
    return parts[0][:, None] * ahead + parts[1][:, None] * back, leads_in


def _best_corners(vertex: IntArray, leads_in: BoolArray, areas: FloatArray) -> IntArray:
    """One corner (n,) for each vertex: the largest that its way leads into, else the largest."""
    order = np.lexsort((-areas, ~leads_in, vertex))
    return order[np.unique(vertex[order], return_index=True)[1]]


def _shortened(ways: FloatArray, distance: FloatArray) -> FloatArray:
    """Ways (k, 3) no longer than half and no longer than the distance (k,)."""
    length = np.linalg.norm(ways, axis=1)
    return np.asarray(_unit(ways) * np.minimum(distance, length / 2)[:, None])


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))
