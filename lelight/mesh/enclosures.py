"""Closed solids: pieces of the surface with an inside that light cannot enter.

Books, boards and legs of furniture are closed, and half of a furnished scene's surface looks into them. Nobody has to
walk in there to find that it is dark.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from lelight.mesh.patches import components, edge_pairs, weld
from lelight.scene import BoolArray, FloatArray, IntArray, Scene

#: Least volume of a solid, over the cube of its diagonal: what encloses less is a sheet.
FLAT = 1e-9
#: A point so near to the face of a box is on it, over the extent of the scene.
ON_FACE = 1e-7
#: Emitting triangles that are looked at one by one; of more, those of a piece are taken together.
MOST_EMITTING = 1024
#: Boxes with so many points around are taken to hold one; boxes that are asked at once.
CROWDED, AT_ONCE = 1024, 1024


@dataclass(frozen=True)
class Enclosures:
    """Closed solids that hold nothing.

    Attributes
    ----------
    solid : (n_t,) int, piece of the surface that each triangle is part of
    inner : (n_t, 2) bool; whether the triangle's front, back looks into a solid
    """

    solid: IntArray
    inner: BoolArray


def enclosures(scene: Scene) -> Enclosures:
    """Find the pieces that are closed, hold no other piece and no lamp, do not emit and touch nothing that does.

    Pieces hang together by edges that two of their triangles share, as corners are numbered in the file: boxes that
    stand exactly on one another are boxes.
    """
    written = _closed(scene, scene.triangles)
    numbers = weld(scene.vertices)
    if len(np.unique(numbers)) == len(numbers):
        return written
    welded = _closed(scene, numbers[scene.triangles])
    return welded if welded.inner.sum() > written.inner.sum() else written


def _closed(scene: Scene, triangles: IntArray) -> Enclosures:
    """Find them among triangles (n_t, 3) whose corners are numbered so."""
    corners, count = scene.corners, len(triangles)
    pairs = edge_pairs(triangles)
    piece = components(count, pairs.first, pairs.second)
    pieces = int(piece.max(initial=-1)) + 1
    shared = np.bincount(pairs.first, minlength=count) + np.bincount(pairs.second, minlength=count)
    closed = np.bincount(piece, shared != 3, pieces) == 0
    low, high = np.full((pieces, 3), np.inf), np.full((pieces, 3), -np.inf)
    np.minimum.at(low, piece, corners.min(axis=1))
    np.maximum.at(high, piece, corners.max(axis=1))
    local = corners - low[piece][:, None]
    volumes = np.bincount(piece, np.linalg.det(local) / 6.0, pieces)
    solid = closed & (np.abs(volumes) > FLAT * np.linalg.norm(high - low, axis=1) ** 3)
    firsts = np.unique(piece, return_index=True)[1]
    own = np.flatnonzero(solid)
    solid[own] = ~_touched(low[own], high[own], *_emitting_boxes(scene, piece))
    own = np.flatnonzero(solid)
    solid[own] = ~_holding(
        low[own], high[own], own, np.concatenate([corners[firsts, 0], scene.lamp_positions])
    )
    inner = np.stack([volumes < 0.0, volumes > 0.0], axis=1) & solid[:, None]
    return Enclosures(piece, inner[piece])


def _emitting_boxes(scene: Scene, piece: IntArray) -> tuple[FloatArray, FloatArray]:
    """Lower and upper corners (e, 3) of boxes around all triangles that emit."""
    own = np.flatnonzero(scene.emitting)
    corners = scene.vertices[scene.triangles[own]]
    if len(own) <= MOST_EMITTING:
        return corners.min(axis=1), corners.max(axis=1)
    order = np.argsort(piece[own], kind="stable")
    first = np.unique(piece[own[order]], return_index=True)[1]
    corners = corners[order]
    return np.minimum.reduceat(corners.min(axis=1), first), np.maximum.reduceat(corners.max(axis=1), first)


def _touched(low: FloatArray, high: FloatArray, least: FloatArray, most: FloatArray) -> BoolArray:
    """Mark boxes (k,) that touch one of others (e,)."""
    touched = np.zeros(len(low), dtype=np.bool_)
    for lower, upper in zip(least, most, strict=True):
        touched |= ((low <= upper) & (high >= lower)).all(axis=1)
    return touched


def _holding(low: FloatArray, high: FloatArray, own: IntArray, points: FloatArray) -> BoolArray:
    """Say which boxes (k,) hold a point (p, 3) other than their own, not on their faces only."""
    margin = ON_FACE * float(np.linalg.norm(np.ptp(points, axis=0)))
    middle, reach = 0.5 * (low + high), 0.5 * (high - low).max(axis=1, initial=0.0)
    tree = cKDTree(points)
    holding = np.asarray(tree.query_ball_point(middle, reach, p=np.inf, return_length=True) > CROWDED)
    few = np.flatnonzero(~holding)
    for chunk in np.array_split(few, range(AT_ONCE, len(few), AT_ONCE)):
        around = tree.query_ball_point(middle[chunk], reach[chunk], p=np.inf)
        box = np.repeat(chunk, [len(near) for near in around])
        point = np.array([number for near in around for number in near], dtype=np.int64)
        held = ((points[point] > low[box] + margin) & (points[point] < high[box] - margin)).all(axis=1)
        holding[box[held & (point != own[box])]] = True
    return holding
