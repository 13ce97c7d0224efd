"""Which of many runs are worth their time, how error falls with time, and what to turn first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lelight.scene import BoolArray, FloatArray

#: The longest run takes at least so many times the shortest where a slope is told from them.
LEAST_SPAN = 1.5


def pareto_front(seconds: FloatArray, errors: FloatArray) -> BoolArray:
    """Mark the runs (k,) that no other beats in both time and error."""
    order = np.lexsort((errors, seconds))
    best = np.minimum.accumulate(errors[order])
    front = np.zeros(len(seconds), dtype=np.bool_)
    front[order] = errors[order] < np.concatenate([[np.inf], best[:-1]])
    return front


def slope(seconds: FloatArray, errors: FloatArray) -> float | None:
    """Least-squares slope of log error over log time; -1/2 for plain Monte Carlo, None for few or like runs."""
    if len(seconds) < 2 or np.ptp(np.log(seconds)) < np.log(LEAST_SPAN):
        return None
    return float(np.polyfit(np.log(seconds), np.log(errors), 1)[0])


def front_error(seconds: Sequence[float], errors: Sequence[float], at: float) -> float:
    """Error that the front of runs reaches in a time, log-linear between its runs, level beyond its ends."""
    found, reached = np.asarray(seconds, dtype=float), np.asarray(errors, dtype=float)
    front = pareto_front(found, reached)
    order = np.argsort(found[front])
    return float(np.exp(np.interp(np.log(at), np.log(found[front][order]), np.log(reached[front][order]))))
