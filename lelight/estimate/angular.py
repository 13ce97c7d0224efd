"""How a glossy node keeps the angular distribution of what it reflects: in harmonics or on a grid.

Both collect arriving light, contribution by contribution, and end as coefficients of the reflected radiance
in spherical harmonics of the node's local frame; emitters are left out, their highlights are added when a
direction is evaluated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numba import njit

from lelight.estimate.arriving import arriving
from lelight.estimate.local import Arrivals
from lelight.harmonics.hemigrid import HemisphereGrid
from lelight.harmonics.indices import terms
from lelight.harmonics.projection import project_columns
from lelight.harmonics.zonal import reflected
from lelight.plan import Plan, lobe_degree
from lelight.receivers import Receivers
from lelight.scene import FloatArray, IntArray
from lelight.tracing.reflection import Reflectances


class AngularDetail(Protocol):
    """What an estimator needs of a way to keep angular distributions."""

    @property
    def width(self) -> int:
        """Numbers kept for each node and channel."""

    def collect(self, receivers: Receivers, arrivals: tuple[Arrivals, ...]) -> FloatArray:
        """Sum arrivals at r receivers into (r, width, C)."""

    def coefficients(
        self, kept: FloatArray, *, receivers: Receivers, illuminance: FloatArray, reflectances: Reflectances
    ) -> FloatArray:
        """Turn what was kept (r, width, C), and illuminance (r, C), into reflected radiance (r, T, C)."""


def angular_detail(
    plan: Plan, reflectances: Reflectances, *, directions: int | None = None
) -> AngularDetail | None:
    """Choose the way that the plan asks for; None where no node keeps angular detail.

    Parameters
    ----------
    directions : about how many a grid has over the hemisphere; default as many as the degree needs
    """
    if plan.degree == 0:
        return None
    if plan.method == "sh":
        return HarmonicDetail(plan.degree, plan.channels)
    degree = plan.degree if directions is None else max(1, math.isqrt(directions // 4) - 1)
    grid = HemisphereGrid(zenith_count=2 * degree + 2, azimuth_count=2 * degree + 1)
    return GridDetail(grid, min(plan.degree, grid.degree), reflectances)


@dataclass(frozen=True)
class HarmonicDetail:
    """Closed form of equation (20): every arrival is deposited at its mirrored direction, in harmonics.

    Attributes
    ----------
    degree : int, the largest of any node
    channels : int
    """

    degree: int
    channels: int

    @property
    def width(self) -> int:
        """(degree + 1)² coefficients."""
        return terms(self.degree)

    def collect(self, receivers: Receivers, arrivals: tuple[Arrivals, ...]) -> FloatArray:
        """Project the mirrored arrivals of each receiver; see `AngularDetail`."""
        if not arrivals:
            return np.zeros((len(receivers), self.width, self.channels))
        light = arriving(receivers, arrivals)
        degree = int(receivers.degrees.max())
        found = project_columns(degree, light.offsets, light.mirrored, light.irradiance)
        if degree == self.degree:
            return found
        kept = np.zeros((len(receivers), self.width, self.channels))
        kept[:, : terms(degree)] = found
        return kept

    def coefficients(
        self, kept: FloatArray, *, receivers: Receivers, illuminance: FloatArray, reflectances: Reflectances
    ) -> FloatArray:
        """Multiply by the lobe, degree by degree (Funk-Hecke); see `AngularDetail`."""
        radiance = np.zeros((len(receivers), self.width, self.channels))
        for material in np.unique(receivers.materials):
            own = receivers.materials == material
            specular, degree = stored_lobe(reflectances, material)
            width = terms(degree)
            radiance[own, :width] = reflected(
                kept[own, :width],
                illuminance[own],
                diffuse=reflectances.diffuse[material],
                specular=specular,
                exponent=float(reflectances.exponent[material]),
            )
        return radiance


@dataclass(frozen=True)
class GridDetail:
    """The paper's section 4: reflected radiance in fixed directions, afterwards fitted by harmonics.

    Attributes
    ----------
    grid : directions over the hemisphere
    degree : int of the fit, at most the grid's
    reflectances : materials, whose lobes are evaluated in every direction of the grid
    """

    grid: HemisphereGrid
    degree: int
    reflectances: Reflectances

    @property
    def width(self) -> int:
        """One number a direction."""
        return self.grid.zenith_count * self.grid.azimuth_count

    def collect(self, receivers: Receivers, arrivals: tuple[Arrivals, ...]) -> FloatArray:
        """Evaluate the lobe of every arrival in every direction; see `AngularDetail`."""
        channels = self.reflectances.diffuse.shape[1]
        kept = np.zeros((len(receivers), self.width, channels))
        if arrivals:
            light = arriving(receivers, arrivals)
            exponents = self.reflectances.exponent[receivers.materials]
            x, y, z = (np.ascontiguousarray(axis) for axis in self.grid.directions.reshape(-1, 3).T)
            _reflect_to_grid(kept, light.offsets, light.mirrored, light.irradiance, exponents, (x, y, z))
        return kept

    def coefficients(
        self, kept: FloatArray, *, receivers: Receivers, illuminance: FloatArray, reflectances: Reflectances
    ) -> FloatArray:
        """Fit the grid by harmonics, add the Lambertian constant; see `AngularDetail`."""
        channels = kept.shape[2]
        specular = np.zeros((len(receivers), channels))
        for material in np.unique(receivers.materials):
            specular[receivers.materials == material], _ = stored_lobe(reflectances, material)
        shape = (len(receivers), self.grid.zenith_count, self.grid.azimuth_count, channels)
        glossy = kept.reshape(shape) * specular[:, None, None, :]
        radiance = self.grid.fit(glossy, self.degree)
        constant = reflectances.diffuse[receivers.materials] * illuminance / math.pi
        radiance[:, 0] += constant * math.sqrt(4.0 * math.pi)
        return radiance


def stored_lobe(reflectances: Reflectances, material: int) -> tuple[FloatArray, int]:
    """Ks (C,) of a material as far as it is stored, and the degree; none where it is too sharp, or not there."""
    specular = reflectances.specular[material]
    degree = lobe_degree(float(reflectances.exponent[material])) if specular.any() else 0
    return np.asarray(specular * float(degree > 0)), degree


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})
def _reflect_to_grid(
    kept: FloatArray,
    offsets: IntArray,
    axes: tuple[FloatArray, FloatArray, FloatArray],
    irradiance: FloatArray,
    exponents: FloatArray,
    directions: tuple[FloatArray, FloatArray, FloatArray],
) -> None:
    """Add (n + 2) / (2 pi) cos^n of the arrivals of every receiver to all directions (d,)."""
    x, y, z = directions
    lobe = np.empty(len(x))
    for r in range(len(kept)):
        n = exponents[r]
        peak = (n + 2.0) / (2.0 * math.pi)
        for k in range(offsets[r], offsets[r + 1]):
            ax, ay, az = axes[0][k], axes[1][k], axes[2][k]
            for d in range(len(x)):
                lobe[d] = max(ax * x[d] + ay * y[d] + az * z[d], 0.0)
            _raise(lobe, n)
            for c in range(kept.shape[2]):
                light = irradiance[c, k] * peak
                for d in range(len(x)):
                    kept[r, d, c] += light * lobe[d]


@njit(cache=True, nogil=True, error_model="numpy")
def _raise(lobe: FloatArray, exponent: float) -> None:
    """Raise numbers (d,) to a power, whole ones by squaring."""
    whole = int(exponent)
    if whole != exponent:
        for d in range(len(lobe)):
            lobe[d] = lobe[d] ** exponent
        return
    square = lobe.copy()
    lobe[:] = 1.0
    while whole > 0:
        if whole & 1:
            for d in range(len(lobe)):
                lobe[d] *= square[d]
        whole >>= 1
        for d in range(len(lobe)):
            square[d] *= square[d]
