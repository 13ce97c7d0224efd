"""From scattered contributions to coefficients; `synthesis` is the way back.

A contribution is a weight (C channels) that arrives from one direction: a delta on the sphere. The
coefficients of many of them are sums of products, g_t = sum_k w_k Y_t(d_k), which is the adjoint of
evaluating an expansion at the points d_k. Two ways lead there and agree to the transform's accuracy: a
loop whose cost grows with the number of coefficients, and a fast transform whose cost hardly depends on it
but which has a fixed price for each call.
"""

from __future__ import annotations

import numpy as np

from lelight.harmonics.basis import check_degree, terms
from lelight.harmonics.deposit import deposit
from lelight.harmonics.transform import transform
from lelight.scene import FloatArray, IntArray

# Times in ns on one thread of a shared two-core x86-64 machine (numba 0.68, ducc0 0.42), 1 and 3 channels, 430
# contributions a call:
#   degree                                 6      11      24      48      59
#   loop, a contribution, 1                8      18      61     210     310
#   loop, a contribution, 3               21      49     165     600     890
#   transform, a call, 1              49 000  53 000  70 000 122 000 150 000
#   transform, a call, 3             126 000 137 000 185 000 340 000 400 000
#   transform, a contribution, 1          51      56      62      73      76
#   transform, a contribution, 3         115     130     142     156     160
#   break-even by these rows, 1        never   never   never     890     640
#   break-even by these rows, 3        never   never    8000     770     550
# The constants are lines through these figures.
LOOP_NS_PER_CONTRIBUTION = 7.0
LOOP_NS_PER_TERM = 0.008
LOOP_NS_PER_TERM_AND_CHANNEL = 0.08
TRANSFORM_NS_PER_CALL_AND_CHANNEL = 30_000.0
TRANSFORM_NS_PER_CALL_AND_CHANNEL_AND_DEGREE = 1_800.0
TRANSFORM_NS_PER_CONTRIBUTION = 15.0
TRANSFORM_NS_PER_CONTRIBUTION_AND_CHANNEL = 48.0


def break_even(degree: int, channels: int) -> float:
    """Count of contributions above which the transform is faster than the loop; inf where it never is."""
    a_term = LOOP_NS_PER_TERM + LOOP_NS_PER_TERM_AND_CHANNEL * channels
    loop = LOOP_NS_PER_CONTRIBUTION + terms(degree) * a_term
    saved = loop - TRANSFORM_NS_PER_CONTRIBUTION - TRANSFORM_NS_PER_CONTRIBUTION_AND_CHANNEL * channels
    call = TRANSFORM_NS_PER_CALL_AND_CHANNEL + TRANSFORM_NS_PER_CALL_AND_CHANNEL_AND_DEGREE * degree
    return call * channels / saved if saved > 0 else np.inf


def project(degree: int, directions: FloatArray, weights: FloatArray) -> FloatArray:
    """Coefficients of a sum of weighted deltas, sum_k w_k Y_lm(d_k).

    Releases the global interpreter lock while it works; the same input gives the same bits.

    Parameters
    ----------
    degree : int
    directions : (k, 3) float, unit length
    weights : (k, C) float

    Returns
    -------
    (T, C) float, T = (degree + 1)²
    """
    offsets = np.array([0, len(directions)])
    return np.asarray(project_groups(degree, offsets, directions, weights)[0])


def project_groups(degree: int, offsets: IntArray, directions: FloatArray, weights: FloatArray) -> FloatArray:
    """Coefficients for many nodes at once: group g owns the contributions ``offsets[g]:offsets[g + 1]``.

    Parameters
    ----------
    degree : int
    offsets : (g + 1,) int, rising from 0 to k
    directions : (k, 3) float, unit length
    weights : (k, C) float

    Returns
    -------
    (g, T, C) float, T = (degree + 1)²; a group's result does not depend on the other groups
    """
    columns, flux = _contributions(directions, weights)
    return project_columns(degree, offsets, columns, flux)


def project_columns(
    degree: int,
    offsets: IntArray,
    columns: tuple[FloatArray, FloatArray, FloatArray],
    weights: FloatArray,
) -> FloatArray:
    """`project_groups` of contributions that lie in memory quantity by quantity.

    Parameters
    ----------
    columns : x, y and z (k,) of the unit directions, contiguous
    weights : (C, k) float, contiguous
    """
    check_degree(degree)
    counts = _counts(offsets, weights.shape[1])
    channels = len(weights)
    out = np.zeros((len(counts), terms(degree), channels))
    crowded = counts > break_even(degree, channels)
    deposit(degree, offsets, np.flatnonzero(~crowded), columns, weights, out)
    for g in np.flatnonzero(crowded):
        own = slice(offsets[g], offsets[g + 1])
        out[g] = transform(degree, np.column_stack([each[own] for each in columns]), weights[:, own].T)
    return out


def _contributions(
    directions: FloatArray, weights: FloatArray
) -> tuple[tuple[FloatArray, FloatArray, FloatArray], FloatArray]:
    """Contiguous float64 columns, after a check of the shapes."""
    unit, flux = np.asarray(directions, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    if unit.ndim != 2 or unit.shape[1] != 3:
        raise ValueError(f"directions must have shape (k, 3), got {unit.shape}")
    if flux.ndim != 2 or len(flux) != len(unit):
        raise ValueError(f"weights must have shape ({len(unit)}, C), got {flux.shape}")
    x, y, z = (np.ascontiguousarray(column) for column in unit.T)
    return (x, y, z), np.ascontiguousarray(flux.T)


def _counts(offsets: IntArray, total: int) -> IntArray:
    """Members of each group, after a check that the groups tile the contributions."""
    counts = np.diff(offsets)
    if offsets[0] != 0 or offsets[-1] != total or np.any(counts < 0):
        raise ValueError(f"offsets must rise from 0 to {total}")
    return counts
