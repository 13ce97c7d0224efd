"""The angular distribution of luminance at an eye, and contrast measures taken from it. Research, no standard.

The question is that of the method's paper: quality from the spatial-angular distribution of luminance. A
published formula of that school for one number of quality could not be established, so the distribution
itself is given, with measures that are plain to define: the solid angle brighter than each luminance, the
contrast in root mean square, and how steeply the logarithm of luminance changes from direction to direction.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lelight.metrics.zones import weighted_percentile
from lelight.scene import FloatArray

LABEL = "research, not a standard"
#: Steps of a decade of luminance.
STEPS = 10
#: Luminances from and to which the distribution is tabulated, cd/m².
RANGE = (1e-2, 1e6)


def luminance_distribution(luminance: FloatArray, solid_angles: FloatArray) -> dict[str, Any]:
    """Tabulate and sum up a picture.

    Parameters
    ----------
    luminance : (h, w) float, cd/m²
    solid_angles : (h, w) float, sr, 0 outside the view

    Returns
    -------
    ``luminance`` (k + 1,) edges in cd/m², ``solid_angle`` (k,) sr in each step, ``solid_angle_above`` (k + 1,)
    sr, ``rms_contrast``, ``log_gradient_mean`` and ``log_gradient_p95`` in 1/rad; lists and numbers for JSON
    """
    inside = solid_angles > 0
    edges = _edges(luminance[inside])
    counted, _ = np.histogram(
        np.clip(luminance[inside], edges[0], edges[-1]), edges, weights=solid_angles[inside]
    )
    above = np.concatenate([np.cumsum(counted[::-1])[::-1], [0.0]])
    gradient, weights = log_gradient(luminance, solid_angles)
    return {
        "label": LABEL,
        "luminance": edges.tolist(),
        "solid_angle": counted.tolist(),
        "solid_angle_above": above.tolist(),
        "rms_contrast": rms_contrast(luminance[inside], solid_angles[inside]),
        "log_gradient_mean": float(np.average(gradient, weights=weights)) if len(gradient) else 0.0,
        "log_gradient_p95": weighted_percentile(gradient, weights, 95) if len(gradient) else 0.0,
    }


def rms_contrast(luminance: FloatArray, solid_angles: FloatArray) -> float:
    """Divide the standard deviation of luminances (n,) by their mean, by solid angle; 0 for a uniform or dark view."""
    mean = float(np.average(luminance, weights=solid_angles))
    if mean <= 0:
        return 0.0
    return math.sqrt(float(np.average((luminance - mean) ** 2, weights=solid_angles))) / mean


def log_gradient(luminance: FloatArray, solid_angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Find |grad ln L| (k,) in 1/rad of an equi-angular fisheye of 180 degrees, and the solid angles (k,).

    The rows of such a picture are π rad across. Near the rim sideways steps are shorter than they look there,
    by at most π/2; this is corrected by the pixel's solid angle. Pixels next to dark or outer ones are left out.
    """
    step = math.pi / luminance.shape[0]
    lit = (solid_angles > 0) & (luminance > 0)
    logarithm = np.log(np.where(lit, luminance, 1.0))
    rows, columns = np.gradient(logarithm, step)
    whole = lit.copy()
    for axis in (0, 1):
        for shift in (-1, 1):
            whole &= np.roll(lit, shift, axis=axis)
    y, x = np.mgrid[: luminance.shape[0], : luminance.shape[1]]
    centred = [2 * (each + 0.5) / luminance.shape[0] - 1 for each in (x, y)]
    radius = np.maximum(np.hypot(*centred), 1e-9)
    radial = (columns * centred[0] + rows * centred[1]) / radius
    around = (columns * centred[1] - rows * centred[0]) / radius
    angle = radius * math.pi / 2
    gradient = np.hypot(radial, around * angle / np.maximum(np.sin(angle), 1e-9))
    return np.asarray(gradient[whole]), np.asarray(solid_angles[whole])


def _edges(luminance: FloatArray) -> FloatArray:
    """List ends of steps of a tenth of a decade around all luminances within the range."""
    clipped = np.clip(luminance, *RANGE)
    first = math.floor(math.log10(float(clipped.min())) * STEPS)
    last = max(math.ceil(math.log10(float(clipped.max())) * STEPS), first + 1)
    return np.asarray(10.0 ** (np.arange(first, last + 1) / STEPS))
