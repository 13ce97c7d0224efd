"""The nearest triangle: of a group of triangles, the one closest to a point, and where on it.

Each group (a patch, or one side of it) has a grid of square cells in the coordinate plane that it faces
most. A point that lies on a triangle of its own cell is found there at once, by linear functions; for others cells are
searched in growing squares around the point until nothing nearer can lie further out, so the answer is exact on curved
groups and for points beside them too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.mesh.closest import closest
from lelight.scene import FloatArray, IntArray

#: A point this much nearer to a triangle than a cell is wide lies on it: look no further.
ON_SURFACE = 1e-7
#: Least cosine between a triangle's normal and the axis left out, for which two coordinates tell where a point is.
LEAST_FACING = 0.1


class Grids(NamedTuple):
    """Where the cells of each of g groups lie and which triangles they hold.

    Attributes
    ----------
    corners : (m, 3, 3) float, m
    axes : (g, 2) int, the coordinates kept
    lows : (g, 2) float, m, lowest of these
    steps : (g,) float, m, width of a cell
    shapes : (g, 2) int, columns and rows; zero without triangles
    first_cells : (g + 1,) int
    starts : (cells + 1,) int into members
    members : (k,) int, triangles cell by cell
    linear : (m, 10) float; of the two kept coordinates the weights of corners b and c, of all three the height over
        the plane in m, each with its constant last; NaN for a triangle that is seen nearly edge on
    """

    corners: FloatArray
    axes: IntArray
    lows: FloatArray
    steps: FloatArray
    shapes: IntArray
    first_cells: IntArray
    starts: IntArray
    members: IntArray
    linear: FloatArray


class TriangleGrid:
    """Bucket grids over groups of triangles.

    Parameters
    ----------
    corners : (m, 3, 3) float, m
    groups : (m,) int, at least 0: the group of each triangle
    """

    def __init__(self, corners: FloatArray, groups: IntArray) -> None:
        self._centre = corners.mean(axis=(0, 1)) if len(corners) else np.zeros(3)
        empty = _layout(np.ascontiguousarray(corners - self._centre), groups)
        counts = np.zeros(int(empty.first_cells[-1]) + 1, dtype=np.int64)
        _visit_cells(empty, groups, counts, np.empty(0, dtype=np.int64))
        ends = np.cumsum(counts)
        members = np.empty(int(ends[-1]), dtype=np.int64)
        _visit_cells(empty, groups, ends - counts, members)
        self._grids = empty._replace(starts=ends - counts, members=members)

    def find(self, points: FloatArray, groups: IntArray) -> tuple[IntArray, FloatArray]:
        """Find the nearest triangle of its group for each point.

        Parameters
        ----------
        points : (k, 3) float, m
        groups : (k,) int

        Returns
        -------
        triangles : (k,) int, -1 where the group has no triangle
        weights : (k, 3) float: barycentric weights of the nearest point, non-negative, of sum 1
        """
        found = np.full(len(points), -1, dtype=np.int64)
        weights = np.zeros((len(points), 3))
        points = np.ascontiguousarray(points, dtype=np.float64)
        groups = np.asarray(groups, dtype=np.int64)
        _find_on_own_cell(points, self._centre, groups, self._grids, found, weights)
        _search(points, self._centre, groups, self._grids, found, weights)
        return found, weights


def nearest_points(
    points: FloatArray, groups: IntArray, corners: FloatArray, triangle_groups: IntArray
) -> tuple[FloatArray, IntArray]:
    """Put points on the triangles of their group: nearest points (k, 3), m, and the triangle (k,) of each.

    Parameters
    ----------
    points : (k, 3) float, m
    groups : (k,) int, each of which has a triangle
    corners : (m, 3, 3) float, m
    triangle_groups : (m,) int
    """
    triangles, weights = TriangleGrid(corners, triangle_groups).find(points, groups)
    return np.asarray(np.einsum("kc,kcx->kx", weights, corners[triangles])), triangles


def _layout(corners: FloatArray, groups: IntArray) -> Grids:
    """Lay out grids without members: about as many cells as triangles, none smaller than a mean triangle."""
    count = int(groups.max(initial=-1)) + 1
    axes, lows = np.zeros((count, 2), dtype=np.int64), np.zeros((count, 2))
    steps, shapes = np.ones(count), np.zeros((count, 2), dtype=np.int64)
    order = np.argsort(groups, kind="stable")
    filled, first, numbers = np.unique(groups[order], return_index=True, return_counts=True)
    if len(filled):
        axes[filled], lows[filled], spans, sizes = _footprints(corners[order], first, numbers)
        wanted = np.maximum(np.sqrt(spans.prod(axis=1) / numbers), spans.max(axis=1) / numbers)
        step = np.maximum(wanted, sizes.max(axis=1))
        steps[filled] = np.where(step > 0, step, 1.0)
        shapes[filled] = np.floor(spans / steps[filled, None]).astype(np.int64) + 1
    first_cells = np.concatenate([[0], np.cumsum(shapes.prod(axis=1))])
    nothing = np.empty(0, dtype=np.int64)
    linear = _linear(corners, axes[groups]) if len(groups) else np.empty((0, 10))
    return Grids(corners, axes, lows, steps, shapes, first_cells, nothing, nothing, linear)


def _linear(corners: FloatArray, axes: IntArray) -> FloatArray:
    """Linear functions of `Grids` for triangles (m, 3, 3) of which the coordinates ``axes`` (m, 2) are kept."""
    flat = np.take_along_axis(corners, axes[:, None, :], axis=2)
    a, ab, ac = flat[:, 0], flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
        of_b = np.column_stack([ac[:, 1], -ac[:, 0], a[:, 1] * ac[:, 0] - a[:, 0] * ac[:, 1]]) / area[:, None]
        of_c = np.column_stack([-ab[:, 1], ab[:, 0], a[:, 0] * ab[:, 1] - a[:, 1] * ab[:, 0]]) / area[:, None]
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    foot = np.einsum("mx,mx->m", normals, corners[:, 0])
    linear = np.column_stack([of_b, of_c, normals, -foot])
    facing = np.take_along_axis(normals, 3 - axes.sum(axis=1, keepdims=True), axis=1)[:, 0]
    linear[~(np.abs(facing) >= LEAST_FACING)] = np.nan
    return np.asarray(linear)


def _footprints(
    corners: FloatArray, first: IntArray, numbers: IntArray
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Look at groups from the axis they face most: kept axes, lows, spans, mean triangle sizes, all (g, 2).

    The groups start at ``first`` (g,) among the corners and have ``numbers`` (g,) triangles.
    """
    sides = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    faced = np.argmax(np.add.reduceat(sides, first), axis=1)
    axes = np.array([[1, 2], [0, 2], [0, 1]])[faced]
    rows = np.arange(len(first))[:, None]
    lows = np.minimum.reduceat(corners.min(axis=1), first)[rows, axes]
    spans = np.maximum.reduceat(corners.max(axis=1), first)[rows, axes] - lows
    sizes = np.add.reduceat(np.ptp(corners, axis=1), first)[rows, axes] / numbers[:, None]
    return axes, lows, spans, sizes


@njit(**LEAF)
def _cell(height: float, step: float, count: int) -> int:
    """Row or column at a height above the grid's foot, held inside the grid."""
    return min(max(int(height / step), 0), count - 1)


@njit(**COMPILED)
def _visit_cells(grids: Grids, groups: IntArray, cursor: IntArray, members: IntArray) -> None:
    """Step the cursor of each cell that a triangle's box touches; write members if there is room."""
    for triangle in range(len(groups)):
        group = groups[triangle]
        step, columns, rows = grids.steps[group], grids.shapes[group, 0], grids.shapes[group, 1]
        us = grids.corners[triangle, :, grids.axes[group, 0]] - grids.lows[group, 0]
        vs = grids.corners[triangle, :, grids.axes[group, 1]] - grids.lows[group, 1]
        for column in range(_cell(us.min(), step, columns), _cell(us.max(), step, columns) + 1):
            for row in range(_cell(vs.min(), step, rows), _cell(vs.max(), step, rows) + 1):
                cell = grids.first_cells[group] + column * rows + row
                if len(members) > 0:
                    members[cursor[cell]] = triangle
                cursor[cell] += 1


@njit(**LEAF)
def _find_on_own_cell(
    points: FloatArray,
    centre: FloatArray,
    groups: IntArray,
    grids: Grids,
    found: IntArray,
    weights: FloatArray,
) -> None:
    """Find the points that lie on a triangle of their own cell."""
    axes, lows, steps, shapes = grids.axes, grids.lows, grids.steps, grids.shapes
    first_cells, starts, members, linear = grids.first_cells, grids.starts, grids.members, grids.linear
    for k in range(len(points)):
        group = groups[k]
        if group < 0 or group >= len(shapes) or shapes[group, 0] == 0:
            continue
        x, y, z = points[k, 0] - centre[0], points[k, 1] - centre[1], points[k, 2] - centre[2]
        first, second = axes[group, 0], axes[group, 1]
        u, v = points[k, first] - centre[first], points[k, second] - centre[second]
        column = _cell(u - lows[group, 0], steps[group], shapes[group, 0])
        row = _cell(v - lows[group, 1], steps[group], shapes[group, 1])
        cell = first_cells[group] + column * shapes[group, 1] + row
        for place in range(starts[cell], starts[cell + 1]):
            t = members[place]
            wb = linear[t, 0] * u + linear[t, 1] * v + linear[t, 2]
            wc = linear[t, 3] * u + linear[t, 4] * v + linear[t, 5]
            if wb >= 0.0 and wc >= 0.0 and wb + wc <= 1.0:
                height = linear[t, 6] * x + linear[t, 7] * y + linear[t, 8] * z + linear[t, 9]
                if abs(height) <= ON_SURFACE * steps[group]:
                    found[k] = t
                    weights[k, 0], weights[k, 1], weights[k, 2] = 1.0 - wb - wc, wb, wc
                    break


@njit(**LEAF)
def _search(
    points: FloatArray,
    centre: FloatArray,
    groups: IntArray,
    grids: Grids,
    found: IntArray,
    weights: FloatArray,
) -> None:
    """Search rings of cells around each point not found yet, nearest first, until the next ring is too far away."""
    corners = grids.corners
    axes, lows, steps, shapes = grids.axes, grids.lows, grids.steps, grids.shapes
    first_cells, starts, members = grids.first_cells, grids.starts, grids.members
    for k in range(len(points)):
        group = groups[k]
        if found[k] >= 0 or group < 0 or group >= len(shapes) or shapes[group, 0] == 0:
            continue
        step, columns, rows = steps[group], shapes[group, 0], shapes[group, 1]
        x, y, z = points[k, 0] - centre[0], points[k, 1] - centre[1], points[k, 2] - centre[2]
        first, second = axes[group, 0], axes[group, 1]
        p, q = points[k, first] - centre[first], points[k, second] - centre[second]
        u, v = p - lows[group, 0], q - lows[group, 1]
        column, row = _cell(u, step, columns), _cell(v, step, rows)
        least = np.inf
        for ring in range(max(columns, rows)):
            for i in range(max(column - ring, 0), min(column + ring, columns - 1) + 1):
                whole = ring == 0 or i == column - ring or i == column + ring
                for j in range(row - ring, row + ring + 1, 1 if whole else 2 * ring):
                    if j < 0 or j >= rows:
                        continue
                    cell = first_cells[group] + i * rows + j
                    for place in range(starts[cell], starts[cell + 1]):
                        triangle = members[place]
                        distance, wb, wc = closest(x, y, z, corners, triangle)
                        if distance < least:
                            least = distance
                            found[k] = triangle
                            weights[k, 0], weights[k, 1], weights[k, 2] = max(1.0 - wb - wc, 0.0), wb, wc
            reach = min(_reach(u, column, ring, columns, step), _reach(v, row, ring, rows, step))
            if least <= max(reach, 0.0, ON_SURFACE * step) ** 2:
                break


@njit(**LEAF)
def _reach(height: float, cell: int, ring: int, count: int, step: float) -> float:
    """Distance from a coordinate to the nearest cell beyond the ring, infinite where the grid ends."""
    reach = np.inf
    if cell - ring > 0:
        reach = height - (cell - ring) * step
    if cell + ring < count - 1:
        reach = min(reach, (cell + ring + 1) * step - height)
    return reach
