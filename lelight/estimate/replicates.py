"""Batches become a mean and its standard error; the error reached decides when to stop."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lelight.channels import is_spectral, luminance_weighted
from lelight.estimate.batch import Batch
from lelight.receivers import ILLUMINANCE
from lelight.scene import BoolArray, FloatArray

#: Fewer batches than this give no error worth the name.
LEAST_BATCHES = 8
#: Nodes darker than this share of the mean are measured against it, not against themselves.
DARK_SHARE = 0.05


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


@dataclass
class Replicates:
    """Running totals of the batches; owns them and grows.

    Attributes
    ----------
    direct, indirect : (r, 6, C) float, sums over batches
    angular : (g, width, C) float, sum over batches
    mean, square : (r,) float, luminance-weighted illuminance: running mean, and sum of squared deviations
    at_nodes : one (first_in_space,) float a batch, lx
    in_space, indirect_in_space : one (r - first_in_space, 6) float a batch, luminance-weighted moments
    bands_in_space : one (r - first_in_space, C) float a batch, lx; empty where there are no spectral bands
    """

    first_in_space: int
    direct: FloatArray = field(default_factory=lambda: np.zeros(0))
    indirect: FloatArray = field(default_factory=lambda: np.zeros(0))
    angular: FloatArray = field(default_factory=lambda: np.zeros(0))
    square: FloatArray = field(default_factory=lambda: np.zeros(0))
    mean: FloatArray = field(default_factory=lambda: np.zeros(0))
    at_nodes: list[FloatArray] = field(default_factory=list)
    in_space: list[FloatArray] = field(default_factory=list)
    indirect_in_space: list[FloatArray] = field(default_factory=list)
    bands_in_space: list[FloatArray] = field(default_factory=list)
    count: int = 0
    vertices: int = 0
    rays: int = 0
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, batch: Batch) -> None:
        """Take in one batch, in order of their numbers."""
        if self.count == 0:
            self.direct, self.indirect = np.zeros_like(batch.direct), np.zeros_like(batch.indirect)
            self.angular = np.zeros_like(batch.angular)
            self.mean = np.zeros(len(batch.direct))
            self.square = np.zeros(len(batch.direct))
        self.count += 1
        self.direct += batch.direct
        self.indirect += batch.indirect
        self.angular += batch.angular
        illuminance = luminance_weighted(batch.direct[:, ILLUMINANCE] + batch.indirect[:, ILLUMINANCE])
        self._add_square(illuminance)
        self.at_nodes.append(illuminance[: self.first_in_space])
        space = slice(self.first_in_space, None)
        self.in_space.append(luminance_weighted(batch.direct[space] + batch.indirect[space]))
        self.indirect_in_space.append(luminance_weighted(batch.indirect[space]))
        if is_spectral(batch.direct.shape[-1]):
            self.bands_in_space.append(batch.direct[space, ILLUMINANCE] + batch.indirect[space, ILLUMINANCE])
        self.vertices += batch.vertices
        self.rays += batch.rays
        for stage, spent in batch.seconds.items():
            self.seconds[stage] = self.seconds.get(stage, 0.0) + spent

    def _add_square(self, illuminance: FloatArray) -> None:
        """Welford's update of mean and sum of squared deviations, which does not cancel."""
        step = illuminance - self.mean
        self.mean += step / self.count
        self.square += step * (illuminance - self.mean)

    @property
    def std_error(self) -> FloatArray:
        """(r,) float, lx: standard error of the mean illuminance, count - 1 degrees of freedom."""
        if self.count < 2:
            return np.full(len(self.mean), np.inf)
        return np.asarray(np.sqrt(self.square / (self.count * (self.count - 1))))


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


def visible_areas(areas: FloatArray, hidden: BoolArray) -> FloatArray:
    """Areas with those of hidden nodes set to zero."""
    return np.where(hidden, 0.0, areas)
