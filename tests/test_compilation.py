"""Leaves count no references, so they must not make arrays: Numba refuses those that do."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from numba.core.errors import NumbaError

from lelight.compilation import COMPILED, LEAF

#: Compiled for this test only.
_LEAF, _COMPILED = {**LEAF, "cache": False}, {**COMPILED, "cache": False}


def test_a_leaf_reads_arrays_and_writes_into_them():
    @njit(**_LEAF)
    def moved(numbers, out):
        for k in range(len(numbers)):
            out[k] = numbers[k] + 1.0

    out = np.zeros(3)
    moved(np.arange(3.0), out)
    assert out.tolist() == [1.0, 2.0, 3.0]


def test_a_leaf_that_makes_an_array_is_refused():
    @njit(**_LEAF)
    def made(count):
        return np.empty(count)

    with pytest.raises(NumbaError, match=r"NRT required|Only accept returning of array passed"):
        made(3)


def test_a_leaf_called_by_others_leaves_their_arrays_alone():
    """Reference counts of the caller's arrays are what they were, or they would be freed under it."""

    @njit(**_LEAF)
    def first(numbers):
        return numbers[0]

    @njit(**_COMPILED)
    def summed(count):
        numbers = np.ones(count)
        total = 0.0
        for _ in range(1000):
            total += first(numbers)
        return numbers, total

    numbers, total = summed(5)
    assert total == 1000.0 and numbers.sum() == 5.0
