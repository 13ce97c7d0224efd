"""Which coefficient stands where: degree l and order m of the flat index l² + l + m."""

from __future__ import annotations

from math import isqrt

import numpy as np

from lelight.scene import IntArray


def terms(degree: int) -> int:
    """Count the coefficients of an expansion up to and including ``degree``."""
    if degree < 0:
        raise ValueError(f"degree must not be negative, got {degree}")
    return (degree + 1) ** 2


def index(degree: int, order: int) -> int:
    """Place l² + l + m of the coefficient of degree l and order m, -l <= m <= l."""
    if abs(order) > degree:
        raise ValueError(f"order must lie between -{degree} and {degree}, got {order}")
    return degree * degree + degree + order


def degree_of(term_count: int) -> int:
    """Degree of an expansion that has ``term_count`` coefficients, which must be a perfect square."""
    degree = isqrt(max(term_count, 0)) - 1
    if degree < 0 or (degree + 1) ** 2 != term_count:
        raise ValueError(f"an expansion has 1, 4, 9, ... coefficients, got {term_count}")
    return degree


def degrees(degree: int) -> IntArray:
    """Degree l of each coefficient, (terms,) int."""
    l_values = np.arange(degree + 1)
    return np.repeat(l_values, 2 * l_values + 1)


def orders(degree: int) -> IntArray:
    """Order m of each coefficient, (terms,) int."""
    l_of_term = degrees(degree)
    return np.arange(terms(degree)) - l_of_term * (l_of_term + 1)


def names(degree: int) -> tuple[str, ...]:
    """Component names in files, ``Y_0_0, Y_1_-1, Y_1_0, Y_1_1, ...``."""
    pairs = zip(degrees(degree), orders(degree), strict=True)
    return tuple(f"Y_{degree_l}_{order_m}" for degree_l, order_m in pairs)
