"""A light tree: receivers draw the vertices they ask without looking at all of them.

Vertices are halved again and again by place and normal. A receiver shares the number it asks out between the halves,
in proportion to what each could give it, and goes into a half only where its share reaches the next vertex to be
asked. So the work grows with the depth of the tree, not with the number of vertices. Any share that is not zero where
there is light makes the draw unbiased; ours come from a sphere and a cone of normals around each half (Walter et al.
2005, Lightcuts; drawn instead of bounded as in Yuksel 2019, Stochastic Lightcuts).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.estimate.pairs import LEAST_COSINE
from lelight.estimate.thinning import Thinning, lobe_strengths
from lelight.receivers import Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import ChainVertices
from lelight.tracing.world import World

#: From so many vertices on a tree chooses faster than a look at each (corridor: as fast at 5000, 1.4 times at 20 000).
TREE_FROM = 5000
#: What a turn of the normal by a right angle weighs against distance, in extents of all vertices.
TURN = 0.5
#: Levels that a tree may have; halves differ by one vertex at most.
DEEPEST = 64
#: Vertices give about alike, each by its flux, where their sphere is seen under less than this sine, their normals lie
#: in a cone of at least this cosine, and receiver and vertices face each other with at least that.
FAR, ALIKE, ALL_ABOVE = 0.3, 0.8, 0.3
#: Vertices are faint together where they give less than this share of the threshold.
FAINT = 0.5
#: Number of draws that stands for certainty.
SURELY = 1e9


@dataclass(frozen=True)
class LightTree:
    """Lambertian vertices by halves; node k of 2 v - 1 has its halves at ``left[k]`` and ``left[k] + 1``.

    Attributes
    ----------
    left : (m,) int; for a leaf -1 minus its vertex
    nodes : (m, 9) float; flux in lm that the vertices below reflect (see `lobe_strengths`), middle (3) and radius in m
        of a sphere around them, mean normal (3), and cosine of the greatest angle from it
    """

    left: IntArray
    nodes: FloatArray

    @classmethod
    def of(cls, world: World, vertices: ChainVertices) -> LightTree | None:
        """Build the tree; None where no vertex reflects by a Lambertian lobe, or any by a Phong lobe.

        What a Phong lobe gives cannot be told from a sphere and a cone: in a room that is all gloss, with those lobes
        asked beside the tree, the variance was five times that without a tree.
        """
        flux, by_phong = lobe_strengths(world, vertices)
        members = np.flatnonzero(flux > 0.0)
        if not len(members) or by_phong.any():
            return None
        points, normals = vertices.points[members], vertices.normals[members]
        extent = max(float(np.max(np.ptp(points, axis=0))), np.finfo(float).tiny)
        left, first, last, order = _halved(np.column_stack([points / extent, TURN * normals]))
        nodes = np.zeros((len(left), 9))
        _enclose(first, last, order, points, normals, flux[members], nodes)
        leaves = left < 0
        left[leaves] = -1 - members[-1 - left[leaves]]
        return cls(left, nodes)

    def draw(
        self, receivers: Receivers, *, bound: float, thinning: Thinning
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Draw vertices for each receiver.

        Returns
        -------
        vertex, receiver : (k,) int
        chances : (k,) float, of being drawn
        """
        room, count = len(receivers) * room_for(thinning.asked), -1
        while count < 0:
            vertex, receiver = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
            chances = np.empty(room)
            count = _draw(
                self.left,
                self.nodes,
                receivers.points,
                receivers.normals,
                receivers.on_surface,
                bound,
                thinning.threshold,
                thinning.passed.copy(),
                vertex,
                receiver,
                chances,
            )
            room *= 2
        return vertex[:count], receiver[:count], chances[:count]


def room_for(asked: float) -> int:
    """Say for how many vertices there is room at each receiver that is to ask so many, to begin with."""
    return int(2.0 * asked) + 64


@njit(**COMPILED)
def _halved(places: FloatArray) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Halve points (v, d) along their widest coordinate: halves, first and last + 1 of each node in the order (v,)."""
    count = len(places)
    order = np.arange(count)
    left = np.empty(2 * count - 1, dtype=np.int64)
    first, last = np.empty_like(left), np.empty_like(left)
    first[0], last[0] = 0, count
    used = 1
    for node in range(2 * count - 1):
        own = order[first[node] : last[node]]
        if len(own) == 1:
            left[node] = -1 - own[0]
            continue
        widest, span = 0, -1.0
        for axis in range(places.shape[1]):
            low, high = np.inf, -np.inf
            for i in own:
                low, high = min(low, places[i, axis]), max(high, places[i, axis])
            if high - low > span:
                widest, span = axis, high - low
        own = own[np.argsort(places[own, widest], kind="mergesort")]
        order[first[node] : last[node]] = own
        middle = first[node] + len(own) // 2
        left[node] = used
        first[used], last[used] = first[node], middle
        first[used + 1], last[used + 1] = middle, last[node]
        used += 2
    return left, first, last, order


@njit(**LEAF)
def _enclose(
    first: IntArray,
    last: IntArray,
    order: IntArray,
    points: FloatArray,
    normals: FloatArray,
    flux: FloatArray,
    nodes: FloatArray,
) -> None:
    """Find flux, sphere and cone of every node."""
    for node in range(len(first)):
        count = last[node] - first[node]
        for k in range(first[node], last[node]):
            i = order[k]
            nodes[node, 0] += flux[i]
            for x in range(3):
                nodes[node, 1 + x] += points[i, x] / count
                nodes[node, 5 + x] += normals[i, x]
        length = math.sqrt(nodes[node, 5] ** 2 + nodes[node, 6] ** 2 + nodes[node, 7] ** 2)
        nodes[node, 8] = 1.0 if length > 0.0 else -1.0
        for x in range(3):
            nodes[node, 5 + x] /= max(length, 1e-300)
        for k in range(first[node], last[node]):
            square, cosine = 0.0, 0.0
            for x in range(3):
                square += (points[order[k], x] - nodes[node, 1 + x]) ** 2
                cosine += normals[order[k], x] * nodes[node, 5 + x]
            nodes[node, 4] = max(nodes[node, 4], math.sqrt(square))
            nodes[node, 8] = min(nodes[node, 8], cosine)


@njit(**LEAF)
def _cosine_less(cos_a: float, cos_b: float) -> float:
    """Cosine of the angle a less the angle b, 1 where b is greater."""
    if cos_a >= cos_b:
        return 1.0
    return cos_a * cos_b + math.sqrt(max(0.0, 1.0 - cos_a * cos_a) * max(0.0, 1.0 - cos_b * cos_b))


@njit(**LEAF)
def _gives(
    nodes: FloatArray,
    k: int,
    at: FloatArray,
    normals: FloatArray,
    r: int,
    on_surface: bool,
    bound: float,
    faint: float,
) -> float:
    """Light in lx that the vertices below node ``k`` give receiver ``r`` in the open.

    If even the most that they could give is less than ``faint`` it is that most; if they give alike, it is what their
    middle would give. It is zero only where none of them gives anything, and negative where none of this holds.
    """
    dx, dy, dz = nodes[k, 1] - at[r, 0], nodes[k, 2] - at[r, 1], nodes[k, 3] - at[r, 2]
    flux, radius, cone = nodes[k, 0] / math.pi, nodes[k, 4], nodes[k, 8]
    square = dx * dx + dy * dy + dz * dz
    if square <= radius * radius:
        return float(flux * bound) if flux * bound < faint else -1.0
    distance = math.sqrt(square)
    above = 1.0
    if on_surface:
        above = (dx * normals[r, 0] + dy * normals[r, 1] + dz * normals[r, 2]) / distance
    facing = -(dx * nodes[k, 5] + dy * nodes[k, 6] + dz * nodes[k, 7]) / distance
    if radius > 0.0:
        seen = math.sqrt(1.0 - radius * radius / square)
        cos_receiver = _cosine_less(above, seen)
        cos_vertex = _cosine_less(_cosine_less(facing, seen), cone)
        if cos_receiver <= 0.0 or cos_vertex <= 0.0:
            return 0.0
        nearest = distance - radius
        most = flux * min(max(cos_receiver, LEAST_COSINE) * cos_vertex / (nearest * nearest), bound)
        if most < faint:
            return float(most)
        if radius > FAR * distance or cone < ALIKE or min(above, facing) < ALL_ABOVE:
            return -1.0
    elif above <= 0.0 or facing <= 0.0:
        return 0.0
    return float(flux * min(max(above, LEAST_COSINE) * facing / square, bound))


@njit(**COMPILED)
def _draw(
    left: IntArray,
    nodes: FloatArray,
    at: FloatArray,
    at_normals: FloatArray,
    on_surface: BoolArray,
    bound: float,
    threshold: FloatArray,
    passed: FloatArray,
    out_vertex: IntArray,
    out_receiver: IntArray,
    out_chance: FloatArray,
) -> int:
    """Write the vertices drawn; returns how many, or -1 where there is not room for all."""
    waiting, numbers = np.empty(DEEPEST, dtype=np.int64), np.empty(DEEPEST)
    count = 0
    for r in range(len(at)):
        faint = FAINT * threshold[r]
        waiting[0], numbers[0], depth = 0, -1.0, 1
        while depth > 0:
            depth -= 1
            node, number = waiting[depth], numbers[depth]
            a = left[node]
            # Below a node whose vertices are taken together, the number drawn is shared out by flux.
            if number < 0.0:
                found = _gives(nodes, node, at, at_normals, r, on_surface[r], bound, faint)
                number = min(found / threshold[r], SURELY) if found >= 0.0 else -1.0
            if number < 0.0:
                waiting[depth], numbers[depth] = a + 1, -1.0
                waiting[depth + 1], numbers[depth + 1] = a, -1.0
                depth += 2
                continue
            if passed[r] + number < 1.0:
                passed[r] += number
                continue
            if a < 0:
                if number < 1.0:
                    passed[r] += number - 1.0
                if count == len(out_vertex):
                    return -1
                out_vertex[count], out_receiver[count], out_chance[count] = -1 - a, r, min(number, 1.0)
                count += 1
                continue
            share = nodes[a, 0] / (nodes[a, 0] + nodes[a + 1, 0])
            waiting[depth], numbers[depth] = a + 1, number * (1.0 - share)
            waiting[depth + 1], numbers[depth + 1] = a, number * share
            depth += 2
    return count
