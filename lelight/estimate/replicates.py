"""Replicates: independent scrambles of the same sequences, whose spread is the error of everything.

Each replicate goes on with its own sequence by doubling, so it keeps what quasi-random points gain, and its mean
has equal weight with those of the others: Student's t with one degree of freedom less than there are
replicates (Owen 1997; L'Ecuyer & Lemieux 2002).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from lelight.channels import is_spectral, luminance_weighted
from lelight.estimate.blocks import Batch
from lelight.mesh.neighbours import half_pooled
from lelight.receivers import ILLUMINANCE
from lelight.scene import FloatArray, IntArray

#: How replicates grow: by one more, or each by as many points as it has.
Growth = Literal["append", "double"]
#: Fewer replicates than this give no error worth the name.
LEAST_REPLICATES = 8
#: Nodes darker than this share of the mean are measured against it, not against themselves.
DARK_SHARE = 0.05
#: The error of a run is within its target when the root mean square is, and the worst 5 % and 1 % of the area
#: are within so many targets.
P95_TARGETS, P99_TARGETS = 3.0, 5.0


@dataclass(frozen=True)
class ErrorReached:
    """Relative standard error of the illuminance, std_error / max(E, 5 % of its mean), over visible nodes.

    Attributes
    ----------
    rms : float, area-weighted root mean square
    p95, p99 : float, area-weighted percentiles
    """

    rms: float
    p95: float
    p99: float

    def in_targets(self, target: float) -> float:
        """Tell the largest of the three as a multiple of what it may be: 1 or less meets the target."""
        return max(self.rms, self.p95 / P95_TARGETS, self.p99 / P99_TARGETS) / target


@dataclass
class Replicates:
    """Totals of a run; owns them and grows by steps, batch after batch: `start` and then `take` what is `due`.

    Attributes
    ----------
    doublings : int, how often every replicate has doubled its sequences; the same for all
    step : what is being done: a replicate appended, or all doubled; None between two steps
    done : int, batches of that step that have been taken
    halfway : mean of the stretches of the replicate that is being appended
    units : int, batches taken in all
    direct, indirect : (r, 6, C) float, sums of the replicates' means
    angular : (g, width, C) float, likewise
    illuminance : one (r,) float a replicate, lx, luminance-weighted
    in_space, indirect_in_space : one (r - first_in_space, 6) float a replicate, luminance-weighted moments
    bands_in_space : one (r - first_in_space, C) float a replicate, lx; empty where there are no spectral bands
    """

    first_in_space: int
    doublings: int = 0
    direct: FloatArray = field(default_factory=lambda: np.zeros(0))
    indirect: FloatArray = field(default_factory=lambda: np.zeros(0))
    angular: FloatArray = field(default_factory=lambda: np.zeros(0))
    illuminance: list[FloatArray] = field(default_factory=list)
    in_space: list[FloatArray] = field(default_factory=list)
    indirect_in_space: list[FloatArray] = field(default_factory=list)
    bands_in_space: list[FloatArray] = field(default_factory=list)
    vertices: int = 0
    rays: int = 0
    seconds: dict[str, float] = field(default_factory=dict)
    step: Growth | None = None
    done: int = 0
    halfway: Batch | None = None
    units: int = 0

    def start(self, step: Growth) -> None:
        """Begin to append a replicate, or to double all."""
        self.step, self.done, self.halfway = step, 0, None

    @property
    def due(self) -> tuple[int, int]:
        """Replicate and doubling of the batch to be taken next."""
        return (self.count, self.done) if self.step == "append" else (self.done, self.doublings + 1)

    def take(self, batch: Batch) -> None:
        """Take the batch that is `due`; with the last one of a step the step ends."""
        self._count(batch)
        if self.step == "append":
            self.halfway = batch if self.halfway is None else self.halfway.halfway_to(batch)
            if self.done == self.doublings:
                self._add(self.halfway)
                self.step, self.halfway = None, None
        else:
            self._add_half(self.done, batch)
            if self.done + 1 == self.count:
                self._halve()
                self.step = None
        self.done += 1

    def _add(self, mean: Batch) -> None:
        """Add a replicate by its mean."""
        if not self.illuminance:
            self.direct, self.indirect = np.zeros_like(mean.direct), np.zeros_like(mean.indirect)
            self.angular = np.zeros_like(mean.angular)
        self.direct += mean.direct
        self.indirect += mean.indirect
        self.angular += mean.angular
        self.illuminance.append(self._seen(mean))
        self.in_space.append(self._moments_in_space(mean.direct, mean.indirect))
        self.indirect_in_space.append(self._moments_in_space(mean.indirect))
        if is_spectral(mean.direct.shape[-1]):
            self.bands_in_space.append(self._bands_in_space(mean))

    def _add_half(self, k: int, batch: Batch) -> None:
        """Add what replicate k found in a doubling; the totals are halved when all have."""
        self.direct += batch.direct
        self.indirect += batch.indirect
        self.angular += batch.angular
        self.illuminance[k] = 0.5 * (self.illuminance[k] + self._seen(batch))
        total = self._moments_in_space(batch.direct, batch.indirect)
        self.in_space[k] = 0.5 * (self.in_space[k] + total)
        indirect = self._moments_in_space(batch.indirect)
        self.indirect_in_space[k] = 0.5 * (self.indirect_in_space[k] + indirect)
        if self.bands_in_space:
            self.bands_in_space[k] = 0.5 * (self.bands_in_space[k] + self._bands_in_space(batch))

    def _halve(self) -> None:
        self.direct *= 0.5
        self.indirect *= 0.5
        self.angular *= 0.5
        self.doublings += 1

    @property
    def count(self) -> int:
        """Number R of replicates."""
        return len(self.illuminance)

    @property
    def mean(self) -> FloatArray:
        """(r,) float, lx: illuminance, luminance-weighted."""
        return np.asarray(np.mean(self.illuminance, axis=0))

    @property
    def std_error(self) -> FloatArray:
        """(r,) float, lx: standard error of the mean illuminance, R - 1 degrees of freedom."""
        if self.count < 2:
            return np.full(len(self.direct), np.inf)
        return np.asarray(np.std(self.illuminance, axis=0, ddof=1) / np.sqrt(self.count))

    @property
    def at_nodes(self) -> FloatArray:
        """(R, first_in_space) float, lx: illuminance of the nodes by each replicate."""
        return np.array(self.illuminance)[:, : self.first_in_space]

    def _seen(self, batch: Batch) -> FloatArray:
        return luminance_weighted(batch.direct[:, ILLUMINANCE] + batch.indirect[:, ILLUMINANCE])

    def _moments_in_space(self, *parts: FloatArray) -> FloatArray:
        """Moments (k, 6) in space of what the parts add up to."""
        return luminance_weighted(np.sum([part[self.first_in_space :] for part in parts], axis=0))

    def _bands_in_space(self, batch: Batch) -> FloatArray:
        own = slice(self.first_in_space, None)
        return np.asarray(batch.direct[own, ILLUMINANCE] + batch.indirect[own, ILLUMINANCE])

    def _count(self, batch: Batch) -> None:
        """Count what a batch took."""
        self.units += 1
        self.vertices += batch.vertices
        self.rays += batch.rays
        for stage, spent in batch.seconds.items():
            self.seconds[stage] = self.seconds.get(stage, 0.0) + spent


def error_reached(illuminance: FloatArray, std_error: FloatArray, *, areas: FloatArray) -> ErrorReached:
    """Relative error of visible nodes (n,), weighted by their areas (n,) m²."""
    mean = float(np.average(illuminance, weights=areas))
    relative = std_error / np.maximum(np.maximum(illuminance, DARK_SHARE * mean), np.finfo(float).tiny)
    order = np.argsort(relative)
    share = np.cumsum(areas[order]) / areas.sum()

    def percentile(level: float) -> float:
        return float(relative[order[min(int(np.searchsorted(share, level)), len(order) - 1)]])

    rms = float(np.sqrt(np.average(relative**2, weights=areas)))
    return ErrorReached(rms, percentile(0.95), percentile(0.99))


def pooled_error(
    illuminance: FloatArray, std_error: FloatArray, neighbours: IntArray, *, areas: FloatArray
) -> FloatArray:
    """Average the square of the nodes' standard error (n,) half and half with those around them (n, 7).

    The spread of about ten replicates is itself uncertain by a quarter, and where a rare path is missing both value and
    spread come out low. In a stairwell at 10 % nominal 95 % intervals held 91 % by each node's own spread, 96 % so.
    Squares go with the illuminance (n,), as those of counts do, lest a dark node beside bright ones be given theirs: as
    they are, they state an error of 4.9 % where it is 3.3 % (office), so 3.4 %, and hold as much. What is all but dark
    goes by a share of the mean over the areas (n,) that are seen.
    """
    scale = np.maximum(illuminance, DARK_SHARE * float(np.average(illuminance, weights=areas)))
    scale = np.maximum(scale, np.finfo(float).tiny)
    return np.asarray(np.sqrt(scale * half_pooled(std_error**2 / scale, neighbours)))
