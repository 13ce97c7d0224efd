"""Many values of few fields: each node's expansion in all the directions that are asked of it, at once.

Where many are, ducc0's fast transform takes the same time for any degree; see `projection` for the break-even, which
is that of the adjoint.
"""

from __future__ import annotations

from functools import lru_cache

import ducc0
import numpy as np
from numpy.typing import NDArray

from lelight.harmonics.indices import degrees, orders, terms
from lelight.harmonics.projection import break_even, synthesise_at
from lelight.harmonics.transform import TRANSFORM_EPSILON, polar_angles
from lelight.scene import FloatArray, IntArray


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


def evaluated(coefficients: NDArray[np.floating], degree: int, directions: FloatArray) -> FloatArray:
    """Values (k, C) of one expansion (T, C) along unit directions (k, 3), by the fast transform.

    ducc0 keeps m >= 0 of complex harmonics with the Condon-Shortley phase: (-1)^m / sqrt 2 of cosine and negative
    sine coefficients are the real and imaginary parts of theirs.
    """
    angles = polar_angles(directions)
    columns = [
        ducc0.sht.synthesis_general(
            alm=complex_form(np.asarray(channel, dtype=np.float64), degree)[None],
            spin=0,
            lmax=degree,
            loc=angles,
            epsilon=TRANSFORM_EPSILON,
            nthreads=1,
        )[0]
        for channel in coefficients.T
    ]
    return np.stack(columns, axis=-1)


def complex_form(coefficients: FloatArray, degree: int) -> NDArray[np.complex128]:
    """Complex coefficients, m by m, of one channel's real ones (T,)."""
    cosine, sine, factors, places = _layout(degree)
    parts = np.zeros((degree + 1) * (degree + 2) // 2, dtype=np.complex128)
    scaled = factors * coefficients
    parts.real[places[cosine]] = scaled[cosine]
    parts.imag[places[sine]] = scaled[sine]
    return parts


@lru_cache(maxsize=64)
def _layout(degree: int) -> tuple[NDArray[np.intp], NDArray[np.intp], FloatArray, NDArray[np.intp]]:
    """Which real coefficients are of cosines and of sines, their factors, and their places among the complex ones."""
    order = orders(degree)
    size = np.abs(order)
    places = size * (2 * degree + 1 - size) // 2 + degrees(degree)
    signs = np.where(order < 0, -1.0, 1.0) * (-1.0) ** size
    factors = np.where(order == 0, 1.0, np.sqrt(0.5) * signs)
    return np.flatnonzero(order >= 0), np.flatnonzero(order < 0), factors, places
