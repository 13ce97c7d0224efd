"""Which sources are in sight at receivers, by what the base's own shadow rays met: others are drawn rarely.

The share of each source's light that comes through is kept at every node of the base. Receivers draw sources by it,
more often where it is in doubt, and where light is known in closed form they take that share from there. Surfaces that
paths meet do not: most lie near others, where sight changes from one hand's breadth to the next, and being wrong costs
more there than being right saves (the office's near field scatters as much with it as without, a library hall's 8 %
less).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lelight.compilation import LEAF
from lelight.scene import FloatArray, IntArray

#: Share of its light that comes through, in steps of one in so many.
WHOLE = 255
#: Least that a source counts of what it would give with nothing between, however dark it was found.
LEAST = 0.1
#: Rays that what places around found stands for beside a place's own, and their mean over all sources beside theirs.
OF_AROUND, OF_ALL = 2.0, 1.0
#: Places whose shares are found at once.
PLACES_AT_ONCE = 8192

Shares = NDArray[np.uint8]


def shares(
    asked: NDArray[np.unsignedinteger], clear: NDArray[np.unsignedinteger], around: IntArray
) -> Shares:
    """Share (n, S) of each source's light that comes through at places, in steps of 1/`WHOLE`.

    Parameters
    ----------
    asked, clear : (n, S) int, rays that went to each source, and those of them that nothing blocked
    around : (n, k) int, places that share what they found
    """
    found = np.empty(asked.shape, dtype=np.uint8)
    for first in range(0, len(around), PLACES_AT_ONCE):
        own = slice(first, first + PLACES_AT_ONCE)
        sent, through = _pooled(asked, around[own]), _pooled(clear, around[own])
        of_all = through.sum(axis=1, keepdims=True) / np.maximum(sent.sum(axis=1, keepdims=True), 1.0)
        around_here = (through + OF_ALL * of_all) / (sent + OF_ALL)
        share = (clear[own] + OF_AROUND * around_here) / (asked[own] + OF_AROUND)
        found[own] = np.rint(WHOLE * share)
    return found


def _pooled(counts: NDArray[np.unsignedinteger], around: IntArray) -> FloatArray:
    """Add counts (n, S) up over places around (k, j)."""
    pooled = np.zeros((len(around), counts.shape[1]))
    for column in around.T:
        pooled += counts[column]
    return pooled


def unseen() -> Shares:
    """Shares of no place."""
    return np.zeros((0, 0), dtype=np.uint8)


@njit(**LEAF)
def row_of_sight(sight: Shares, row: int) -> int:
    """Row of a place, -1 where nothing is known of any."""
    return row if sight.shape[1] > 0 else -1


@njit(**LEAF)
def known_share(sight: Shares, row: int, source: int, clear_share: float) -> float:
    """Share of a source's light that is taken as known: what comes through by sight, or of all, and none of none."""
    if row < 0 or clear_share <= 0.0:
        return clear_share
    return float(sight[row, source] / WHOLE)


#: Factors by which sight changes the importance of a source, by the share that comes through: that or, if it is more,
#: twice its deviation. A share that is known leaves what deviates from it to be drawn; drawn rarely, that would be
#: missed by most runs.
_SHARE = np.arange(WHOLE + 1) / WHOLE
_IN_SIGHT = LEAST + (1.0 - LEAST) * np.maximum(_SHARE, 2.0 * np.sqrt(_SHARE * (1.0 - _SHARE)))


@njit(**LEAF)
def importance_in_sight(sight: Shares, row: int, source: int) -> float:
    """Factor by which sight changes the importance of a source; no row changes nothing."""
    return float(_IN_SIGHT[sight[row, source]]) if row >= 0 else 1.0
