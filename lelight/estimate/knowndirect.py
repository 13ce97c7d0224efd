"""What is known of direct light: shares of what sources would give with nothing between, in closed form.

It costs as much as hundreds of rays where sources are many, and is the same in every batch, so it is found once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.receivers import Receivers
from lelight.scene import FloatArray, IntArray
from lelight.tracing.drawing import add_unblocked
from lelight.tracing.emitters import Emitters
from lelight.tracing.sight import Shares, known_share, row_of_sight
from lelight.tracing.world import World


def with_known_direct(world: World, receivers: Receivers, sight: Shares) -> Receivers:
    """Find once for all what closed forms give receivers that know how much of the emitters they see."""
    known = np.zeros((len(receivers), world.channels))
    _fill_known(
        world.emitters,
        receivers.points,
        receivers.normals,
        receivers.clear_share,
        receivers.rows,
        sight,
        known,
    )
    return replace(receivers, known_direct=known)


@njit(**COMPILED)
def _fill_known(
    emitters: Emitters,
    points: FloatArray,
    normals: FloatArray,
    clear_share: FloatArray,
    rows: IntArray,
    sight: Shares,
    known: FloatArray,
) -> None:
    scratch = np.empty(len(emitters.power))
    for r in range(len(points)):
        row = row_of_sight(sight, rows[r])
        if clear_share[r] > 0.0:
            add_known(emitters, points[r], normals[r], row, sight, clear_share[r], scratch, known[r])


@njit(**LEAF)
def add_known(
    emitters: Emitters,
    point: FloatArray,
    normal: FloatArray,
    row: int,
    sight: Shares,
    clear_share: float,
    scratch: FloatArray,
    known: FloatArray,
) -> None:
    """Add the known share of each source's light at a place (C,), lx; ``scratch`` (S,) is overwritten."""
    x, y, z = point
    nx, ny, nz = normal
    for source in range(len(scratch)):
        scratch[source] = known_share(sight, row, source, clear_share)
    add_unblocked(emitters, x, y, z, nx, ny, nz, scratch, known)
