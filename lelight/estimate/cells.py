"""Cells: the sides of the traced triangles cut small, so that places can be drawn more often where it pays.

A triangle with n segments to an edge has n² cells of equal shape. Its rows run parallel to the edge between its
first and its third corner; row i holds 2 (n - i) - 1 cells, upright and inverted ones in turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.scene import FloatArray, IntArray, triangle_areas

#: Most segments to an edge: keeps the root of a cell's number exact, and a floor of a kilometre in bounds.
MOST_SEGMENTS = 512


@dataclass(frozen=True)
class Drawn:
    """Places on k sides of triangles.

    Attributes
    ----------
    triangle, side : (k,) int; +1 front, -1 back
    points : (k, 3) float, m
    area : (k,) float, m² that each stands for, one over its density
    """

    triangle: IntArray
    side: IntArray
    points: FloatArray
    area: FloatArray


@dataclass(frozen=True)
class Cells:
    """Cells of f faces, a face being one side of a triangle, with a probability each.

    Attributes
    ----------
    corners : (n_t, 3, 3) float, m, of all traced triangles
    triangle, side, segments : (f,) int
    first : (f + 1,) int, number of each face's first cell; the last is the number of all
    face_of : (n_t, 2) int, face of the front and of the back of a triangle, -1 for none
    probability : (first[-1],) float, of sum 1
    """

    corners: FloatArray
    triangle: IntArray
    side: IntArray
    segments: IntArray
    first: IntArray
    face_of: IntArray
    probability: FloatArray

    def __len__(self) -> int:
        """Count cells."""
        return len(self.probability)

    def with_weights(self, weights: FloatArray) -> Cells:
        """Copy them with probabilities in proportion to weights, one a cell."""
        return replace(self, probability=weights / weights.sum())

    def draw(self, numbers: FloatArray) -> tuple[Drawn, IntArray]:
        """Draw places by uniform numbers (k, 3); also the cell (k,) that each is in."""
        cumulative = np.cumsum(self.probability)
        cell = np.searchsorted(cumulative, numbers[:, 0] * cumulative[-1], side="right")
        cell = np.minimum(cell, len(cumulative) - 1)
        face = np.searchsorted(self.first, cell, side="right") - 1
        row, column, inverted = _position(cell - self.first[face], self.segments[face])
        root = np.sqrt(numbers[:, 1])
        along, across = root * (1.0 - numbers[:, 2]), root * numbers[:, 2]
        along, across = np.where(inverted, 1.0 - along, along), np.where(inverted, 1.0 - across, across)
        v, w = (row + along) / self.segments[face], (column + across) / self.segments[face]
        weights = np.stack([1.0 - v - w, v, w], axis=1)
        triangle = self.triangle[face]
        points = np.einsum("kc,kcx->kx", weights, self.corners[triangle])
        return Drawn(triangle, self.side[face], points, self._areas(face) / self.probability[cell]), cell

    def at(self, triangle: IntArray, side: IntArray, points: FloatArray) -> IntArray:
        """Find the cell (k,) around each point (k, 3) on a side of a triangle, -1 where that has none."""
        face = self.face_of[triangle, np.where(side > 0, 0, 1)]
        cell = np.empty(len(points), dtype=np.int64)
        _find(self.corners, triangle, face, self.first, self.segments, points, cell)
        return cell

    def density(self, triangle: IntArray, side: IntArray, points: FloatArray) -> FloatArray:
        """Density (k,) in 1/m² with which places on sides of triangles are drawn; 0 where none are."""
        cell = self.at(triangle, side, points)
        density = np.zeros(len(points))
        known = cell >= 0
        own = self.face_of[triangle[known], np.where(side[known] > 0, 0, 1)]
        density[known] = self.probability[cell[known]] / self._areas(own)
        return density

    def _areas(self, face: IntArray) -> FloatArray:
        """Area (k,) in m² of a cell of each face."""
        return np.asarray(triangle_areas(self.corners[self.triangle[face]]) / self.segments[face] ** 2)


def cut(corners: FloatArray, *, faces: tuple[IntArray, IntArray], weights: FloatArray, wanted: int) -> Cells:
    """Cut faces into about so many cells of like weight, which is their probability.

    Parameters
    ----------
    corners : (n_t, 3, 3) float, m
    faces : triangle (f,) and side (f,), +1 or -1
    weights : (f,) float, positive
    wanted : int; there is at least one cell a face
    """
    triangle, side = faces
    segments = np.sqrt(wanted * weights / weights.sum())
    segments = np.clip(np.rint(segments), 1, MOST_SEGMENTS).astype(np.int64)
    face_of = np.full((len(corners), 2), -1, dtype=np.int64)
    face_of[triangle, np.where(side > 0, 0, 1)] = np.arange(len(triangle))
    each = np.repeat(weights / segments**2, segments**2)
    first = np.concatenate([[0], np.cumsum(segments**2)])
    return Cells(corners, triangle, side, segments, first, face_of, each / each.sum())


def _position(number: IntArray, segments: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Row, column and whether inverted (k,) of cells by their numbers in their faces."""
    left = np.ceil(np.sqrt((segments**2 - number).astype(np.float64))).astype(np.int64)
    row = segments - left
    within = number - row * (2 * segments - row)
    return row, within // 2, within % 2


@njit(**COMPILED)
def _find(
    corners: FloatArray,
    triangle: IntArray,
    face: IntArray,
    first: IntArray,
    segments: IntArray,
    points: FloatArray,
    cell: IntArray,
) -> None:
    """Write the cell of each point (k, 3) on a triangle (k,) into ``cell`` (k,), -1 where its face is -1."""
    for k in range(len(points)):
        if face[k] < 0:
            cell[k] = -1
            continue
        t, n = triangle[k], segments[face[k]]
        if n == 1:
            cell[k] = first[face[k]]
            continue
        one_one, one_two, two_two, to_one, to_two = 0.0, 0.0, 0.0, 0.0, 0.0
        for axis in range(3):
            start = corners[t, 0, axis]
            one, two, to = corners[t, 1, axis] - start, corners[t, 2, axis] - start, points[k, axis] - start
            one_one += one * one
            one_two += one * two
            two_two += two * two
            to_one += to * one
            to_two += to * two
        square = one_one * two_two - one_two * one_two
        v = (two_two * to_one - one_two * to_two) / square * n
        w = (one_one * to_two - one_two * to_one) / square * n
        row = min(max(int(v), 0), n - 1)
        column = min(max(int(w), 0), n - 1 - row)
        inverted = v + w - row - column > 1.0 and row + column < n - 1
        cell[k] = first[face[k]] + row * (2 * n - row) + 2 * column + inverted
