"""Scrambled Sobol points.

Direction numbers are those of Joe & Kuo (2008), Constructing Sobol sequences with better two-dimensional projections,
their file new-joe-kuo-6.21201. They are scrambled by random lower triangular matrices and a digital shift (Matoušek
1998, On the L2-discrepancy for anchored boxes): each point is uniform, and the net stays one. Points come in the order
of Gray code, of which every stretch of a power of two that starts at a multiple of itself is balanced too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lelight.compilation import COMPILED, LEAF
from lelight.scene import FloatArray
from lelight.tracing.sampling import mix

#: Binary digits of a number, as many as there are between 0.5 and 1.
DIGITS = 53
#: Primitive polynomial of each dimension from the second on, its coefficients as binary digits, and the first odd
#: numbers m of its recurrence.
_JOE_KUO = (
    (3, (1,)),
    (7, (1, 3)),
    (11, (1, 3, 1)),
    (13, (1, 1, 1)),
    (19, (1, 1, 3, 3)),
    (25, (1, 3, 5, 13)),
    (37, (1, 1, 5, 5, 17)),
    (41, (1, 1, 5, 5, 5)),
    (47, (1, 1, 7, 11, 19)),
    (55, (1, 1, 5, 1, 1)),
    (59, (1, 1, 1, 3, 11)),
    (61, (1, 3, 5, 5, 31)),
    (67, (1, 3, 3, 9, 7, 49)),
    (91, (1, 1, 1, 15, 21, 21)),
    (97, (1, 3, 1, 13, 27, 49)),
    (103, (1, 1, 1, 15, 7, 5)),
    (109, (1, 3, 1, 15, 13, 25)),
    (115, (1, 1, 5, 5, 19, 61)),
    (131, (1, 3, 7, 11, 23, 15, 103)),
    (137, (1, 3, 7, 13, 13, 15, 69)),
    (143, (1, 1, 3, 13, 7, 35, 63)),
    (145, (1, 3, 5, 9, 1, 25, 53)),
    (157, (1, 3, 1, 13, 9, 35, 107)),
    (167, (1, 3, 1, 5, 27, 61, 31)),
    (171, (1, 1, 5, 11, 19, 41, 61)),
    (185, (1, 3, 5, 3, 3, 13, 69)),
    (191, (1, 1, 7, 13, 1, 19, 1)),
    (193, (1, 3, 7, 5, 13, 19, 59)),
    (203, (1, 1, 3, 9, 25, 29, 41)),
    (211, (1, 3, 5, 13, 23, 1, 55)),
    (213, (1, 3, 7, 3, 13, 59, 17)),
)
MOST_DIMENSIONS = 1 + len(_JOE_KUO)

_Words = NDArray[np.uint64]


@dataclass(frozen=True)
class Stretch:
    """Part of a quasi-random sequence: ``count`` points from number ``first`` on.

    A sequence starts with a power of two of points and goes on by doubling: balance holds for powers of two
    only.
    """

    first: int
    count: int

    @classmethod
    def of(cls, log2_count: int, doubling: int = 0) -> Stretch:
        """Take the 2**log2_count points that a sequence starts with, or those of its k-th doubling."""
        if doubling == 0:
            return cls(0, 2**log2_count)
        return cls(2 ** (log2_count + doubling - 1), 2 ** (log2_count + doubling - 1))

    def parts(self, most: int) -> Iterator[Stretch]:
        """Cut into pieces of at most ``most`` points, the same whatever the machine."""
        for first in range(self.first, self.first + self.count, most):
            yield Stretch(first, min(most, self.first + self.count - first))


@lru_cache(maxsize=256)
def sobol(dimensions: int, stretch: Stretch, *, seed: tuple[int, ...]) -> FloatArray:
    """Scrambled Sobol points, every one of them (dropping the first breaks the balance; Owen 2020).

    Parameters
    ----------
    dimensions : int, at most `MOST_DIMENSIONS`

    Returns
    -------
    (stretch.count, dimensions) float in [0, 1); shared between callers, not to be written to
    """
    if dimensions > MOST_DIMENSIONS:
        raise ValueError(f"dimensions must be at most {MOST_DIMENSIONS}, found {dimensions}")
    (key,) = np.random.SeedSequence(seed).generate_state(1, np.uint64)
    points = np.empty((stretch.count, dimensions))
    _fill(direction_numbers()[:dimensions], key, stretch.first, points)
    points.flags.writeable = False
    return points


@lru_cache(maxsize=1)
def direction_numbers() -> _Words:
    """Direction numbers (MOST_DIMENSIONS, DIGITS): the k-th stands for the k-th binary digit of a point's number."""
    rows = [[1] * DIGITS] + [_odd_numbers(polynomial, first) for polynomial, first in _JOE_KUO]
    shifted = [[odd << (DIGITS - 1 - k) for k, odd in enumerate(row)] for row in rows]
    return np.array(shifted, dtype=np.uint64)


def _odd_numbers(polynomial: int, first: tuple[int, ...]) -> list[int]:
    """Continue the numbers m of a dimension by the recurrence of its polynomial (equation (2) of Joe & Kuo 2008)."""
    degree = len(first)
    odd = list(first)
    for k in range(degree, DIGITS):
        number = odd[k - degree] ^ (odd[k - degree] << degree)
        for back in range(1, degree):
            if polynomial >> (degree - back) & 1:
                number ^= odd[k - back] << back
        odd.append(number)
    return odd


@njit(**COMPILED)
def _fill(directions: _Words, key: np.uint64, first: int, points: FloatArray) -> None:
    """Write points from number ``first`` on, each dimension scrambled by a matrix and a shift of its own."""
    count, dimensions = points.shape
    used = 1
    while used < DIGITS and (first + count - 1) >> used:
        used += 1
    scrambled = np.empty(used, dtype=np.uint64)
    rows = np.empty(DIGITS, dtype=np.uint64)
    for d in range(dimensions):
        own = mix(key, np.uint64(d))
        for row in range(DIGITS):
            # Digits above a number's own are of rows before; those below are left alone.
            above = ~np.uint64(0) << np.uint64(DIGITS - row)
            rows[row] = (mix(own, np.uint64(row)) & above) | np.uint64(1) << np.uint64(DIGITS - 1 - row)
        for k in range(used):
            scrambled[k] = _times(rows, directions[d, k])
        word = mix(own, np.uint64(DIGITS)) >> np.uint64(64 - DIGITS)
        gray = first ^ (first >> 1)
        for k in range(used):
            if gray >> k & 1:
                word ^= scrambled[k]
        for i in range(count):
            points[i, d] = float(word) / 2.0**DIGITS
            if i + 1 < count:
                number, k = first + i + 1, 0
                while not number >> k & 1:
                    k += 1
                word ^= scrambled[k]


@njit(**LEAF)
def _times(rows: _Words, word: np.uint64) -> np.uint64:
    """Multiply a word by a matrix of binary digits, its rows from the first digit on."""
    product = np.uint64(0)
    for row in range(DIGITS):
        x = rows[row] & word
        for half in (32, 16, 8, 4, 2, 1):
            x ^= x >> np.uint64(half)
        product = (product << np.uint64(1)) | (x & np.uint64(1))
    return product
