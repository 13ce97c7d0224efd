"""How a run sampled, so that another run can do the same and the two differ by their scenes only.

Replicate r of both then uses the same points of the same sequences everywhere (common random numbers): what chance
does to one it mostly does to the other, and it falls out of their difference.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lelight.errors import SceneError
from lelight.estimate.base import BaseField
from lelight.estimate.blocks import Effort
from lelight.estimate.cells import Cells
from lelight.receivers import Receivers
from lelight.scene import FloatArray, IntArray


@dataclass(frozen=True)
class StartingCells:
    """Cells of f faces as `lelight.estimate.cells.Cells` has them, without the triangles that they are on.

    Attributes
    ----------
    triangle, side, segments : (f,) int
    probability : (c,) float, of sum 1
    """

    triangle: IntArray
    side: IntArray
    segments: IntArray
    probability: FloatArray

    @classmethod
    def of(cls, base: BaseField | None) -> StartingCells | None:
        """Cells of a base, None where it has none."""
        if base is None or base.starts is None:
            return None
        cells = base.starts
        return cls(cells.triangle, cells.side, cells.segments, cells.probability)

    def covering(self, own: Cells) -> Cells | None:
        """Put them on the triangles of ``own``; None where a face of those would get no start."""
        count = len(own.corners)
        if len(self.triangle) and int(self.triangle.max()) >= count:
            return None
        here, there = (
            set(zip(each.triangle.tolist(), each.side.tolist(), strict=True)) for each in (own, self)
        )
        if not here <= there:
            return None
        face_of = np.full((count, 2), -1, dtype=np.int64)
        face_of[self.triangle, np.where(self.side > 0, 0, 1)] = np.arange(len(self.triangle))
        first = np.concatenate([[0], np.cumsum(self.segments**2)])
        return Cells(own.corners, self.triangle, self.side, self.segments, first, face_of, self.probability)


@dataclass(frozen=True)
class SamplingPlan:
    """All that decides, beside seed and scene, which random numbers a run uses where.

    Attributes
    ----------
    effort : of one replicate before it doubles
    replicates, doublings : int, how many there were at the end, and how often each had doubled
    direct_doublings, near_doublings : (r,) int, of the receivers, see `lelight.receivers.Receivers`
    edge : float, m, of the node mesh
    starts : cells where chains start, with their probabilities; None where nothing reflects or there is no base
    """

    effort: Effort
    replicates: int
    doublings: int
    direct_doublings: IntArray
    near_doublings: IntArray
    edge: float
    starts: StartingCells | None

    def shared_out(self, receivers: Receivers) -> Receivers:
        """Give receivers the shares of the samples that they had there.

        Raises
        ------
        SceneError
            where there were more or fewer of them
        """
        there = len(self.direct_doublings)
        if there != len(receivers):
            raise SceneError(
                f"{len(receivers)} places to estimate light at, {there} in the run to be like: "
                "compute without --like, or with the same surfaces, planes and observers"
            )
        return replace(receivers, direct_doublings=self.direct_doublings, near_doublings=self.near_doublings)

    def started_alike(self, base: BaseField | None) -> BaseField | None:
        """Let chains start where they did there; where they did on some surfaces only, the base keeps its own starts.

        Any positive density of starts is unbiased; the one that was measured for the other scene is as good for one
        that hardly differs, and one that moves a little would move every start.
        """
        if base is None or base.starts is None or self.starts is None:
            return base
        return replace(base, starts=self.starts.covering(base.starts) or base.starts)
