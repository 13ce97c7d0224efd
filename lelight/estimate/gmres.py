"""GMRES without BLAS, whose threaded sums would make the bits of a result depend on how many cores there are.

Saad & Schultz, "GMRES: a generalized minimal residual algorithm", SIAM J. Sci. Stat. Comput. 7 (1986).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lelight.scene import FloatArray

Operator = Callable[[FloatArray], FloatArray]

#: A new direction shorter than this share of what it was made from is rounding: the space is exhausted.
EXHAUSTED = 1e-14


def gmres(operator: Operator, wanted: FloatArray, *, settled: float, restart: int, most: int) -> FloatArray:
    """Solve operator(x) = wanted for x (n,), from x = 0.

    Parameters
    ----------
    operator : linear map of (n,) to (n,)
    settled : residual to stop at, as share of ``wanted``
    restart : steps after which the space is built anew
    most : how often it is at the most

    Returns
    -------
    (n,) float; the best that was found where it did not settle
    """
    found = np.zeros_like(wanted)
    goal = settled * _norm(wanted)
    for _ in range(most):
        residual = wanted - operator(found)
        if _norm(residual) <= goal:
            break
        found = found + _correction(operator, residual, goal, restart)
    return found


def _correction(operator: Operator, residual: FloatArray, goal: float, steps: int) -> FloatArray:
    """Build the Krylov space of a residual (n,) and take from it what leaves the least of it."""
    length = _norm(residual)
    basis = [residual / length]
    triangle = np.zeros((steps, steps))
    turns: list[tuple[float, float]] = []
    remaining = [length]
    for k in range(steps):
        direction = operator(basis[k])
        before = _norm(direction)
        column = np.zeros(k + 1)
        for j, other in enumerate(basis):
            column[j] = _dot(other, direction)
            direction = direction - column[j] * other
        over = _norm(direction)
        for j, (cosine, sine) in enumerate(turns):
            column[j : j + 2] = (
                cosine * column[j] + sine * column[j + 1],
                cosine * column[j + 1] - sine * column[j],
            )
        radius = math.hypot(column[k], over)
        if radius == 0.0:
            break
        turns.append((column[k] / radius, over / radius))
        column[k] = radius
        triangle[: k + 1, k] = column
        remaining += [-turns[k][1] * remaining[k]]
        remaining[k] *= turns[k][0]
        if abs(remaining[-1]) <= goal or over <= EXHAUSTED * before:
            break
        basis.append(direction / over)
    return _combined(basis, triangle, remaining, len(turns))


def _combined(
    basis: list[FloatArray], triangle: FloatArray, remaining: list[float], steps: int
) -> FloatArray:
    """Solve the triangle backwards and sum the basis by the solution."""
    shares = np.zeros(steps)
    for k in reversed(range(steps)):
        shares[k] = (remaining[k] - float(np.sum(triangle[k, k + 1 : steps] * shares[k + 1 :]))) / triangle[
            k, k
        ]
    found = np.zeros_like(basis[0])
    for share, vector in zip(shares, basis, strict=False):
        found += share * vector
    return found


def _dot(one: FloatArray, other: FloatArray) -> float:
    return float(np.sum(one * other))


def _norm(vector: FloatArray) -> float:
    return math.sqrt(_dot(vector, vector))
