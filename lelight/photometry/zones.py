"""Flux by integration over the distribution, and the figures that catalogues derive from it.

Between table entries the intensity is bilinear in C and γ; everything here is the exact integral of that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lelight.photometry.photometry import Photometry
from lelight.scene import FloatArray

#: Degrees from nadir of the cones of the CIE flux code: solid angles π/2, π, 3π/2 and 2π (CIE 52:1982).
CODE_CONES = tuple(math.degrees(math.acos(1 - k / 4)) for k in (1, 2, 3, 4))


def mean_over_c(photometry: Photometry) -> FloatArray:
    """Intensity (n_g,) in cd, mean over a whole turn of C."""
    c, candela = photometry.closed()
    return np.asarray(np.trapezoid(candela, c, axis=0) / 360.0)


def cumulative_flux(gamma: FloatArray, mean: FloatArray) -> FloatArray:
    """Flux (n_g,) in lm from the first γ up to each, of a piecewise linear mean intensity.

    ``∫ (a + b γ) sin γ dγ = -(a + b γ) cos γ + b sin γ``, times 2 π.
    """
    angle = np.radians(gamma)
    steps = np.diff(angle)
    slope = np.divide(np.diff(mean), steps, out=np.zeros_like(steps), where=steps > 0)
    sine, cosine = np.sin(angle), np.cos(angle)
    parts = mean[:-1] * cosine[:-1] - mean[1:] * cosine[1:] + slope * np.diff(sine)
    return np.concatenate([[0.0], np.cumsum(2.0 * math.pi * np.maximum(parts, 0.0))])


def luminous_flux(photometry: Photometry) -> float:
    """Flux in lm that leaves the luminaire, by integration."""
    return float(cumulative_flux(photometry.gamma, mean_over_c(photometry))[-1])


def flux_below(photometry: Photometry, gamma: float) -> float:
    """Flux in lm within the cone of half angle ``gamma`` in degrees around nadir."""
    mean = mean_over_c(photometry)
    inner = photometry.gamma < gamma
    nodes = photometry.gamma[inner]
    if not len(nodes):
        return 0.0
    end = min(gamma, float(photometry.gamma[-1]))
    at_end = float(np.interp(end, photometry.gamma, mean))
    return float(cumulative_flux(np.append(nodes, end), np.append(mean[inner], at_end))[-1])


def light_output_ratio(photometry: Photometry) -> float | None:
    """Luminaire flux over lamp flux; None where lamps are not told apart from the luminaire."""
    if photometry.absolute or not photometry.lamp_flux > 0:
        return None
    return luminous_flux(photometry) / photometry.lamp_flux


def downward_fraction(photometry: Photometry) -> float:
    """Share of the flux that goes below the horizontal."""
    flux = luminous_flux(photometry)
    return flux_below(photometry, 90.0) / flux if flux > 0 else 0.0


def flux_code(photometry: Photometry) -> tuple[int, ...]:
    """CIE flux code N1 ... N5 in percent (CIE 52:1982; EN 13032-2).

    N1 to N3: flux in cones of π/2, π and 3π/2 sr over the downward flux; N4: downward share; N5: light output
    ratio, 100 for absolute photometry.
    """
    flux = luminous_flux(photometry)
    cones = [flux_below(photometry, cone) for cone in CODE_CONES]
    shares = [cone / cones[3] if cones[3] > 0 else 0.0 for cone in cones[:3]]
    ratio = light_output_ratio(photometry)
    last = [cones[3] / flux if flux > 0 else 0.0, 1.0 if ratio is None else ratio]
    return tuple(round(100 * share) for share in (*shares, *last))


@dataclass(frozen=True)
class Spread:
    """Full angles in degrees of the light in one vertical plane; None where it does not fall off that far.

    Attributes
    ----------
    beam : between the directions of half the largest intensity (CIE 17.4)
    field : between those of a tenth
    """

    c: float
    beam: float | None
    field: float | None


def spread(photometry: Photometry, c: float) -> Spread:
    """Beam and field angle in the plane through ``c`` and ``c + 180`` degrees, around its own peak."""
    gamma = photometry.gamma
    here, there = photometry.intensity(c, gamma), photometry.intensity(c + 180.0, gamma)
    angle = np.concatenate([-gamma[::-1], gamma])
    profile = np.concatenate([there[::-1], here])
    if gamma[-1] == 180.0 and gamma[np.argmax(np.maximum(here, there))] > 90.0:
        # Light that goes up is spread around the zenith.
        angle = np.concatenate([gamma, 360.0 - gamma[::-1]])
        profile = np.concatenate([here, there[::-1]])
    return Spread(c, _width(angle, profile, 0.5), _width(angle, profile, 0.1))


def _width(angle: FloatArray, profile: FloatArray, share: float) -> float | None:
    """Distance between the outermost places where the profile falls through a share of its peak."""
    peak = float(profile.max())
    if not peak > 0:
        return None
    above = np.flatnonzero(profile >= share * peak)
    left = _crossing(angle, profile, int(above[0]), -1, share * peak)
    right = _crossing(angle, profile, int(above[-1]), 1, share * peak)
    return None if left is None or right is None else right - left


def _crossing(angle: FloatArray, profile: FloatArray, inner: int, step: int, level: float) -> float | None:
    outer = inner + step
    if not 0 <= outer < len(angle):
        # The table ends here, and with it the light; a whole turn has no end.
        return None if np.ptp(angle) >= 360.0 - 1e-9 else float(angle[inner])
    fall = profile[inner] - profile[outer]
    share = (profile[inner] - level) / fall if fall > 0 else 0.0
    return float(angle[inner] + share * (angle[outer] - angle[inner]))


def zonal_flux(photometry: Photometry, *, middles: FloatArray) -> FloatArray:
    """Flux (n,) in lm of zones 10 degrees wide: mean intensity at each middle times its solid angle.

    The rule of CIE 190:2010, clause on zonal fluxes; ``middles`` in degrees.
    """
    mean = np.interp(middles, photometry.gamma, mean_over_c(photometry), left=0.0, right=0.0)
    half = math.radians(5.0)
    middle = np.radians(middles)
    return np.asarray(mean * 2.0 * math.pi * (np.cos(middle - half) - np.cos(middle + half)))
