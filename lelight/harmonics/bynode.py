"""Many values of few fields: each node's expansion in all the directions that are asked of it, at once.

Where many are, ducc0's fast transform takes the same time for any degree, but has a fixed price for each node.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lelight.harmonics.indices import terms
from lelight.harmonics.synthesis import synthesise_at
from lelight.harmonics.transform import evaluated
from lelight.scene import FloatArray, IntArray

# Times in ns on one thread of a shared two-core x86-64 machine (numba 0.68, ducc0 0.42), one and three channels, three
# corners of one frame:
#   degree                               6      11      15      24      30      48      60
#   loop, a corner, 1                   54      97     138     282     386     834    1263
#   loop, a corner, 3                  128     296     481    1061    1686    3919    5950
#   transform, a node, 1            38 000  39 000  37 000  71 000  79 000 120 000 162 000
#   transform, a node, 3            86 000 106 000 112 000 184 000 232 000 313 000 454 000
#   transform, a corner, 1; 3       54; 94  54; 96  54; 97 55; 102 55; 103 55; 104 56; 104
# The constants are lines through these figures.
LOOP_NS = 45.0
LOOP_NS_PER_TERM, LOOP_NS_PER_TERM_AND_FURTHER_CHANNEL = 0.33, 0.63
TRANSFORM_NS_PER_NODE_AND_CHANNEL = 20_000.0
TRANSFORM_NS_PER_NODE_AND_CHANNEL_AND_DEGREE = 2_200.0
TRANSFORM_NS, TRANSFORM_NS_PER_CHANNEL = 31.0, 24.0


def break_even(degree: int, channels: int) -> float:
    """Count of directions asked of a node above which the transform is faster than the loop; inf where it never is."""
    a_term = LOOP_NS_PER_TERM + LOOP_NS_PER_TERM_AND_FURTHER_CHANNEL * (channels - 1)
    loop = LOOP_NS + terms(degree) * a_term
    saved = loop - TRANSFORM_NS - TRANSFORM_NS_PER_CHANNEL * channels
    node = TRANSFORM_NS_PER_NODE_AND_CHANNEL + TRANSFORM_NS_PER_NODE_AND_CHANNEL_AND_DEGREE * degree
    return node * channels / saved if saved > 0 else np.inf


def synthesise_by_node(
    coefficients: NDArray[np.floating],
    degree: int,
    nodes: IntArray,
    weights: FloatArray,
    directions: FloatArray,
) -> FloatArray:
    """Do as `synthesise_at`, faster where nodes are asked for many directions, to the transform's accuracy.

    Parameters
    ----------
    coefficients : (n, T, C) float32 or float64
    degree : int, at most that of the coefficients; terms above it are left out
    nodes : (k, j) int, the corners whose fields are mixed
    weights : (k, j) float, barycentric coordinates
    directions : (k, j, 3) float, unit, in the local frame of each corner

    Returns
    -------
    (k, C) float
    """
    asked = weights != 0.0
    counts = np.bincount(nodes[asked], minlength=len(coefficients))
    crowded = counts > break_even(degree, coefficients.shape[2])
    by_transform = asked & crowded[nodes]
    values = synthesise_at(coefficients, degree, nodes, np.where(by_transform, 0.0, weights), directions)
    row, _ = np.nonzero(by_transform)
    owner, weight, along = nodes[by_transform], weights[by_transform], directions[by_transform]
    order = np.argsort(owner, kind="stable")
    first = np.flatnonzero(np.diff(owner[order], prepend=-1))
    for own in np.split(order, first[1:]) if len(order) else []:
        field = coefficients[owner[own[0]], : terms(degree)]
        # A row asks a node once only for each of its corners, which are different nodes.
        values[row[own]] += weight[own, None] * evaluated(field, degree, along[own])
    return np.asarray(values)
