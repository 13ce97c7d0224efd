"""Cells: the sides of the traced triangles cut small, so that places can be drawn more often where it pays.

A triangle with n segments to an edge has n² cells of equal shape. Its rows run parallel to the edge between its
first and its third corner; row i holds 2 (n - i) - 1 cells, upright and inverted ones in turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

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

    def density(self, triangle: IntArray, side: IntArray, points: FloatArray) -> FloatArray:
        """Density (k,) in 1/m² with which places on sides of triangles are drawn; 0 where none are."""
        face = self.face_of[triangle, np.where(side > 0, 0, 1)]
        known = np.flatnonzero(face >= 0)
        density = np.zeros(len(points))
        own = face[known]
        v, w = _barycentric(self.corners[triangle[known]], points[known])
        cell = self.first[own] + _number(v, w, self.segments[own])
        density[known] = self.probability[cell] / self._areas(own)
        return density

    def _areas(self, face: IntArray) -> FloatArray:
        """Area (k,) in m² of a cell of each face."""
        return np.asarray(triangle_areas(self.corners[self.triangle[face]]) / self.segments[face] ** 2)


def cut(corners: FloatArray, *, faces: tuple[IntArray, IntArray], weights: FloatArray, wanted: int) -> Cells:
    """Cut faces into about so many cells of like area, with probabilities by the faces' weights.

    Parameters
    ----------
    corners : (n_t, 3, 3) float, m
    faces : triangle (f,) and side (f,), +1 or -1
    weights : (f,) float, positive
    wanted : int; there is at least one cell a face
    """
    triangle, side = faces
    areas = triangle_areas(corners[triangle])
    segments = np.sqrt(wanted * areas / areas.sum())
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


def _number(v: FloatArray, w: FloatArray, segments: IntArray) -> IntArray:
    """Find the number (k,) in its face of the cell around each place, given by its second and third weight."""
    row = np.clip(np.floor(v * segments).astype(np.int64), 0, segments - 1)
    column = np.clip(np.floor(w * segments).astype(np.int64), 0, segments - 1 - row)
    inverted = (v + w) * segments - row - column > 1.0
    inverted &= row + column < segments - 1
    return np.asarray(row * (2 * segments - row) + 2 * column + inverted)


def _barycentric(corners: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights (k,) of the second and the third corner at points (k, 3) of triangles (k, 3, 3)."""
    one, two, to = (
        corners[:, 1] - corners[:, 0],
        corners[:, 2] - corners[:, 0],
        points - corners[:, 0],
    )
    normal = np.cross(one, two)
    square = np.maximum(np.einsum("kx,kx->k", normal, normal), np.finfo(float).tiny)
    v = np.einsum("kx,kx->k", np.cross(to, two), normal) / square
    w = np.einsum("kx,kx->k", np.cross(one, to), normal) / square
    return v, w
