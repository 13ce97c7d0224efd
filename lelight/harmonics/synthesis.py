"""From coefficients to values: mixes of the expansions of nodes, each along its own direction.

The sum over a direction's harmonics runs degree by degree, all orders of one side by side; see `basis` for the
recurrence. Corners that have the same frame, as on a flat surface, are mixed first and evaluated once.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.harmonics.basis import AHEAD, BEHIND, SECTORAL
from lelight.scene import BoolArray, FloatArray, IntArray

#: Factors a_lm and b_lm at [l, m].
_AHEAD, _BEHIND = np.ascontiguousarray(AHEAD.T), np.ascontiguousarray(BEHIND.T)


@njit(**COMPILED)
def synthesise_at(
    coefficients: FloatArray, degree: int, nodes: IntArray, weights: FloatArray, directions: FloatArray
) -> FloatArray:
    """Weighted mixes of the fields of nodes, each evaluated along a direction in that node's own frame.

    Parameters
    ----------
    coefficients : (n, T, C) float32 or float64
    degree : int, at most that of the coefficients; terms above it are left out; unchecked
    nodes : (k, j) int, the j corners whose fields are mixed (3 in a triangle)
    weights : (k, j) float, barycentric coordinates
    directions : (k, j, 3) float, unit, in the local frame of each corner

    Returns
    -------
    (k, C) float
    """
    channels = coefficients.shape[2]
    values = np.zeros((len(nodes), channels))
    mixed = np.empty((channels, (degree + 1) ** 2))
    work = np.empty((4 + channels, degree + 1))
    waiting = np.empty(nodes.shape[1], dtype=np.bool_)
    for k in range(len(nodes)):
        for j in range(nodes.shape[1]):
            waiting[j] = weights[k, j] != 0.0
        for j in range(nodes.shape[1]):
            if waiting[j]:
                _mix_alike(coefficients, nodes[k], weights[k], directions[k], j, waiting, mixed)
                _add_value(degree, mixed, directions[k, j], work, values[k])
    return values


@njit(**COMPILED)
def _mix_alike(
    coefficients: FloatArray,
    nodes: IntArray,
    weights: FloatArray,
    directions: FloatArray,
    first: int,
    waiting: BoolArray,
    mixed: FloatArray,
) -> None:
    """Write the mix (C, T) of the waiting corners (j,) that look along the first one's direction."""
    mixed[:] = 0.0
    d = directions[first]
    for j in range(first, len(nodes)):
        along = directions[j]
        if not waiting[j] or along[0] != d[0] or along[1] != d[1] or along[2] != d[2]:
            continue
        waiting[j] = False
        field, weight = coefficients[nodes[j]], weights[j]
        for c in range(len(mixed)):
            for t in range(mixed.shape[1]):
                mixed[c, t] += weight * field[t, c]


@njit(**COMPILED)
def _add_value(
    degree: int, coefficients: FloatArray, direction: FloatArray, work: FloatArray, value: FloatArray
) -> None:
    """Add what coefficients (C, T) give along a direction to ``value`` (C,); ``work`` is (4 + C, degree + 1)."""
    cosine, sine, here, behind, sums = work[0], work[1], work[2], work[3], work[4:]
    x, y, z = direction[0], direction[1], direction[2]
    sums[:], here[:], behind[:] = 0.0, 0.0, 0.0
    cosine[0], sine[0] = 1.0, 0.0
    for m in range(degree):
        cosine[m + 1], sine[m + 1] = x * cosine[m] - y * sine[m], x * sine[m] + y * cosine[m]
    for ell in range(degree + 1):
        here[ell] = SECTORAL[ell]
        centre = ell * ell + ell
        for c in range(len(value)):
            field, own = coefficients[c], sums[c]
            for m in range(ell + 1):
                own[m] += here[m] * (cosine[m] * field[centre + m] + sine[m] * field[centre - m])
        ahead, back = _AHEAD[ell], _BEHIND[ell]
        for m in range(ell + 1):
            further = ahead[m] * z * here[m] - back[m] * behind[m]
            behind[m], here[m] = here[m], further
    for c in range(len(value)):
        for m in range(degree + 1):
            value[c] += sums[c, m]
