"""Angular detail in harmonics: in closed form, and by one drawn direction an arrival as the paper has it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.channels import luminance_weighted
from lelight.compilation import COMPILED
from lelight.estimate.arriving import arriving
from lelight.estimate.lobes import stored_lobe
from lelight.estimate.local import Arrivals
from lelight.harmonics.indices import terms
from lelight.harmonics.projection import project_columns
from lelight.harmonics.truncation import truncation_error
from lelight.harmonics.zonal import lobe_coefficients, reflected
from lelight.receivers import Receivers
from lelight.scene import FloatArray, IntArray
from lelight.tracing.chains import hash_of
from lelight.tracing.reflection import Reflectances
from lelight.tracing.sampling import lobe_direction, mix, to_axis, uniform


@dataclass(frozen=True)
class HarmonicDetail:
    """Closed form of equation (20): every arrival is deposited at its mirrored direction, in harmonics.

    Attributes
    ----------
    degree : int, the largest of any node
    channels : int
    lobes : (n_materials,) int, degree to which the material's lobe is stored
    """

    degree: int
    channels: int
    lobes: IntArray

    @property
    def width(self) -> int:
        """(degree + 1)² coefficients."""
        return terms(self.degree)

    def collect(
        self, receivers: Receivers, arrivals: tuple[Arrivals, ...], *, seed: tuple[int, ...] = ()
    ) -> FloatArray:
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
            specular, degree = stored_lobe(reflectances, self.lobes, material)
            width = terms(degree)
            radiance[own, :width] = reflected(
                kept[own, :width],
                illuminance[own],
                diffuse=reflectances.diffuse[material],
                specular=specular,
                exponent=float(reflectances.exponent[material]),
            )
        return radiance

    def stored_degrees(self, degrees: IntArray) -> IntArray:
        """Degrees as the materials ask for; see `AngularDetail`."""
        return degrees

    def truncation(self, kept: FloatArray, *, receivers: Receivers, reflectances: Reflectances) -> FloatArray:
        """Extend the spectrum of the light over the degrees that are left out; see `AngularDetail`."""
        return harmonic_truncation(kept, receivers.materials, reflectances, self.lobes)


@dataclass(frozen=True)
class SampledDetail:
    """Equation (20) as it stands: every arrival leaves in one direction drawn from the lobe of its node.

    Its mean is `HarmonicDetail`'s; what it scatters more is for comparison (`tests/bench_angular.py`).

    Attributes
    ----------
    degree : int, the largest of any node
    reflectances : materials, from whose lobes directions are drawn
    lobes : (n_materials,) int, degree to which the material's lobe is stored
    """

    degree: int
    reflectances: Reflectances
    lobes: IntArray

    @property
    def width(self) -> int:
        """(degree + 1)² coefficients."""
        return terms(self.degree)

    def collect(
        self, receivers: Receivers, arrivals: tuple[Arrivals, ...], *, seed: tuple[int, ...] = ()
    ) -> FloatArray:
        """Project what each arrival sends into its drawn direction, for ks = 1; see `AngularDetail`."""
        kept = np.zeros((len(receivers), self.width, self.reflectances.diffuse.shape[1]))
        if not arrivals:
            return kept
        light = arriving(receivers, arrivals)
        exponents = self.reflectances.exponent[receivers.materials]
        _reflect_once(hash_of(seed), light.offsets, light.mirrored, receivers.identity, exponents)
        degree = int(receivers.degrees.max())
        kept[:, : terms(degree)] = project_columns(degree, light.offsets, light.mirrored, light.irradiance)
        # What is reflected over the density of the direction, (n + 2) / (n + 1) everywhere.
        return np.asarray(kept * ((exponents + 2.0) / (exponents + 1.0))[:, None, None])

    def coefficients(
        self, kept: FloatArray, *, receivers: Receivers, illuminance: FloatArray, reflectances: Reflectances
    ) -> FloatArray:
        """Multiply by ks, add the Lambertian constant; see `AngularDetail`."""
        radiance = np.zeros_like(kept)
        for material in np.unique(receivers.materials):
            own = receivers.materials == material
            specular, degree = stored_lobe(reflectances, self.lobes, material)
            width = terms(degree)
            radiance[own, :width] = specular * kept[own, :width]
        constant = reflectances.diffuse[receivers.materials] * illuminance / np.pi
        radiance[:, 0] += constant * np.sqrt(4.0 * np.pi)
        return radiance

    def stored_degrees(self, degrees: IntArray) -> IntArray:
        """Degrees as the materials ask for; see `AngularDetail`."""
        return degrees

    def truncation(self, kept: FloatArray, *, receivers: Receivers, reflectances: Reflectances) -> FloatArray:
        """Extend the spectrum, noise included, over the degrees that are left out; see `AngularDetail`."""
        return harmonic_truncation(kept, receivers.materials, reflectances, self.lobes, applied=True)


def harmonic_truncation(
    kept: FloatArray,
    materials: IntArray,
    reflectances: Reflectances,
    lobes: IntArray,
    *,
    applied: bool = False,
) -> FloatArray:
    """State truncation errors (r,) in cd/m² of light (r, T, C) that is kept at nodes of materials (r,).

    Parameters
    ----------
    lobes : (n_materials,) int, degree to which the material's lobe is stored
    applied : whether lobes have been multiplied to what was kept
    """
    errors = np.zeros(len(kept))
    for material in np.unique(materials):
        own = materials == material
        specular, degree = stored_lobe(reflectances, lobes, material)
        if degree == 0:
            continue
        exponent = float(reflectances.exponent[material])
        lobe = (exponent + 2.0) / (exponent + 1.0) * lobe_coefficients(exponent, 4 * degree + 4)
        seen = luminance_weighted(specular * kept[own, : terms(degree)])
        errors[own] = truncation_error(seen, lobe, applied=applied)
    return errors


@njit(**COMPILED)
def _reflect_once(
    key: np.uint64,
    offsets: IntArray,
    directions: tuple[FloatArray, FloatArray, FloatArray],
    identity: IntArray,
    exponents: FloatArray,
) -> None:
    """Replace each mirrored direction by one drawn from the lobe around it."""
    x, y, z = directions
    for r in range(len(identity)):
        own = mix(key, np.uint64(identity[r]))
        for k in range(offsets[r], offsets[r + 1]):
            drawn = mix(own, np.uint64(k - offsets[r]))
            u, v = uniform(drawn, np.uint64(0)), uniform(drawn, np.uint64(1))
            a, b, c = lobe_direction(u, v, exponents[r])
            x[k], y[k], z[k] = to_axis(a, b, c, x[k], y[k], z[k])
