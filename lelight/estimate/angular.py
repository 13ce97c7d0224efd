"""How a glossy node keeps the angular distribution of what it reflects: in harmonics or on a grid.

All collect arriving light, contribution by contribution, and end as coefficients of the reflected radiance
in spherical harmonics of the node's local frame; emitters are left out, their highlights are added when a
direction is evaluated.
"""

from __future__ import annotations

import math
from typing import Protocol

from lelight.estimate.angulargrid import GridDetail
from lelight.estimate.angularharmonics import HarmonicDetail, SampledDetail
from lelight.estimate.local import Arrivals
from lelight.harmonics.hemigrid import Extension, HemisphereGrid, Rule
from lelight.plan import Plan
from lelight.receivers import Receivers
from lelight.scene import FloatArray, IntArray
from lelight.tracing.reflection import Reflectances

__all__ = ["AngularDetail", "Collecting", "GridDetail", "HarmonicDetail", "SampledDetail", "angular_detail"]


class Collecting(Protocol):
    """What an estimator needs of somebody who wants arrivals one by one."""

    @property
    def width(self) -> int:
        """Numbers kept for each node and channel."""

    def collect(
        self, receivers: Receivers, arrivals: tuple[Arrivals, ...], *, seed: tuple[int, ...] = ()
    ) -> FloatArray:
        """Sum arrivals at r receivers into (r, width, C); what is drawn is drawn by the seed."""


class AngularDetail(Collecting, Protocol):
    """A way to keep angular distributions at nodes."""

    def coefficients(
        self, kept: FloatArray, *, receivers: Receivers, illuminance: FloatArray, reflectances: Reflectances
    ) -> FloatArray:
        """Turn what was kept (r, width, C), and illuminance (r, C), into reflected radiance (r, T, C)."""

    def stored_degrees(self, degrees: IntArray) -> IntArray:
        """Degrees of the coefficients at nodes whose materials ask for ``degrees`` (n,)."""

    def truncation(self, kept: FloatArray, *, receivers: Receivers, reflectances: Reflectances) -> FloatArray:
        """State what the finite degree leaves out of the lobes (r,), root mean square over directions in cd/m²."""


def angular_detail(
    plan: Plan,
    reflectances: Reflectances,
    *,
    directions: int | None = None,
    extension: Extension = "least_squares",
) -> AngularDetail | None:
    """Choose the way that the plan asks for; None where no node keeps angular detail.

    Parameters
    ----------
    directions : about how many a grid has over the hemisphere; default as many as the degree needs
    extension : of the fit to a grid; ``zero`` samples at the zeros of Legendre polynomials, as the paper does
    """
    if plan.degree == 0:
        return None
    if plan.method == "sh":
        return HarmonicDetail(plan.degree, plan.channels, plan.lobes)
    if plan.method == "sampled":
        return SampledDetail(plan.degree, reflectances, plan.lobes)
    degree = plan.degree if directions is None else max(1, math.isqrt(directions // 4) - 1)
    rule: Rule = "legendre" if extension == "zero" else "gauss"
    grid = HemisphereGrid(zenith_count=2 * degree + 2, azimuth_count=2 * degree + 1, rule=rule)
    return GridDetail(grid, min(plan.degree, grid.degree), reflectances, plan.lobes, extension)
