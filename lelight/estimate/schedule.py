"""What a run does next: double all sequences, add a replicate, or stop.

Doubling costs as much as all that was done so far; a replicate costs one share of it. So a run doubles while it
is far from its end and adds single replicates for the last part, which stops close to target and budget.
"""

from __future__ import annotations

from typing import Literal

from lelight.estimate.replicates import LEAST_REPLICATES, Growth

Step = Growth | Literal["stop"]

#: Doublings that an effort leaves room for.
WANTED_DOUBLINGS = 2
#: Batches that an effort is shared out over: eight replicates that double twice.
WANTED_BATCHES = LEAST_REPLICATES * 2**WANTED_DOUBLINGS


def next_step(
    replicates: int,
    *,
    exactly: int | None = None,
    missing: float = float("inf"),
    room: float = float("inf"),
) -> Step:
    """Decide how a run goes on.

    Parameters
    ----------
    replicates : int, how many there are
    exactly : int, how many there shall be, where that was asked for
    missing : float, work that the target still needs, as a multiple of all that was done; inf without a target
    room : float, time that is left, as a multiple of all that was spent; inf without a clock
    """
    least = LEAST_REPLICATES if exactly is None else exactly
    if replicates < least:
        return "append"
    if exactly is not None or missing <= 0.0:
        return "stop"
    if missing >= 1.0 and room >= 1.0:
        return "double"
    return "append" if room >= 1.0 / replicates else "stop"
