"""What receivers on surfaces reflect toward one direction each: all that a picture asks of the angular distribution."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.estimate.local import Arrivals
from lelight.receivers import Receivers
from lelight.scene import FloatArray, IntArray
from lelight.tracing.reflection import Reflectances, lobe
from lelight.tracing.sampling import mirrored


@dataclass(frozen=True)
class TowardEye:
    """Kernel (17) with the receiver's own Phong lobe: every arrival is reflected toward the eye at once.

    Attributes
    ----------
    outgoing : (n, 3) float, unit; where each receiver is looked at from
    first : int, identity of the receiver that the first of them belongs to
    reflectances : materials
    """

    outgoing: FloatArray
    first: int
    reflectances: Reflectances

    @property
    def width(self) -> int:
        """One number a receiver."""
        return 1

    def collect(
        self, receivers: Receivers, arrivals: tuple[Arrivals, ...], *, seed: tuple[int, ...] = ()
    ) -> FloatArray:
        """Sum what the lobes of r receivers make of arrivals, (r, 1, C) in cd/m²; see `Collecting`."""
        kept = np.zeros((len(receivers), 1, self.reflectances.diffuse.shape[1]))
        outgoing = self.outgoing[receivers.identity - self.first]
        for part in arrivals:
            _reflect(
                kept,
                part.receiver,
                part.directions,
                part.radiance_solid_angle,
                outgoing,
                receivers.normals,
                receivers.materials,
                self.reflectances,
            )
        return kept

    def coefficients(
        self, kept: FloatArray, *, receivers: Receivers, illuminance: FloatArray, reflectances: Reflectances
    ) -> FloatArray:
        """Add what the Lambertian lobe reflects, (r, 1, C) in cd/m²."""
        lambertian = reflectances.diffuse[receivers.materials] * illuminance / math.pi
        return np.asarray(kept + lambertian[:, None])


@njit(**COMPILED)
def _reflect(
    kept: FloatArray,
    owner: IntArray,
    directions: FloatArray,
    light: FloatArray,
    outgoing: FloatArray,
    normals: FloatArray,
    materials: IntArray,
    reflectances: Reflectances,
) -> None:
    for k in range(len(owner)):
        r = owner[k]
        nx, ny, nz = normals[r, 0], normals[r, 1], normals[r, 2]
        ax, ay, az = mirrored(outgoing[r, 0], outgoing[r, 1], outgoing[r, 2], nx, ny, nz)
        wx, wy, wz = directions[k, 0], directions[k, 1], directions[k, 2]
        cos_theta = wx * nx + wy * ny + wz * nz
        m = materials[r]
        peak = lobe(reflectances.exponent[m], wx * ax + wy * ay + wz * az)
        if cos_theta <= 0.0 or peak <= 0.0:
            continue
        for c in range(kept.shape[2]):
            kept[r, 0, c] += reflectances.specular[m, c] * peak * cos_theta * light[k, c]
