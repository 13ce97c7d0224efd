"""Angular detail on a grid of directions, the way of the paper's section 4."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.channels import luminance_weighted
from lelight.compilation import COMPILED
from lelight.estimate.arriving import arriving
from lelight.estimate.lobes import stored_lobe
from lelight.estimate.local import Arrivals
from lelight.harmonics.hemigrid import Extension, HemisphereGrid
from lelight.receivers import Receivers
from lelight.scene import FloatArray, IntArray
from lelight.tracing.reflection import Reflectances


@dataclass(frozen=True)
class GridDetail:
    """The paper's section 4: reflected radiance in fixed directions, afterwards fitted by harmonics.

    Attributes
    ----------
    grid : directions over the hemisphere
    degree : int of the fit, at most the grid's
    reflectances : materials, whose lobes are evaluated in every direction of the grid
    lobes : (n_materials,) int, degree to which the material's lobe is stored
    extension : how the fit goes on below the horizon; the Lambertian part is kept apart and needs none
    """

    grid: HemisphereGrid
    degree: int
    reflectances: Reflectances
    lobes: IntArray
    extension: Extension = "least_squares"

    @property
    def width(self) -> int:
        """One number a direction."""
        return self.grid.zenith_count * self.grid.azimuth_count

    def collect(
        self, receivers: Receivers, arrivals: tuple[Arrivals, ...], *, seed: tuple[int, ...] = ()
    ) -> FloatArray:
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
        glossy = self._glossy(kept, receivers, reflectances)
        radiance = self.grid.fit(glossy, self.degree, extension=self.extension)
        constant = reflectances.diffuse[receivers.materials] * illuminance / math.pi
        radiance[:, 0] += constant * math.sqrt(4.0 * math.pi)
        return radiance

    def stored_degrees(self, degrees: IntArray) -> IntArray:
        """One degree for all that are fitted; see `AngularDetail`."""
        return np.where(degrees > 0, self.degree, 0)

    def truncation(self, kept: FloatArray, *, receivers: Receivers, reflectances: Reflectances) -> FloatArray:
        """Root mean square over the grid of what the fit leaves; see `AngularDetail`."""
        glossy = self._glossy(kept, receivers, reflectances)
        fitted = self.grid.evaluate(self.grid.fit(glossy, self.degree, extension=self.extension))
        off = luminance_weighted(fitted - glossy)
        weights = self.grid.zenith_weights[:, None] / self.grid.azimuth_count
        return np.asarray(np.sqrt(np.sum(weights * off**2, axis=(-2, -1))))

    def _glossy(self, kept: FloatArray, receivers: Receivers, reflectances: Reflectances) -> FloatArray:
        """Radiance (r, Z, A, C) of the lobes in the directions of the grid."""
        channels = kept.shape[2]
        specular = np.zeros((len(receivers), channels))
        for material in np.unique(receivers.materials):
            specular[receivers.materials == material], _ = stored_lobe(reflectances, self.lobes, material)
        shape = (len(receivers), self.grid.zenith_count, self.grid.azimuth_count, channels)
        return np.asarray(kept.reshape(shape) * specular[:, None, None, :])


@njit(**COMPILED, fastmath={"reassoc", "contract", "nsz"})
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


@njit(**COMPILED)
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
