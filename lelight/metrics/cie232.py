"""Discomfort glare of luminaires with a non-uniform source luminance, CIE 232:2019.

``UGR' = 8 log10(0.25 / L_b · sum k² L² ω / p²)``, ``k² = L_eff² ω_eff / (L² ω)``: of the luminance image of a
luminaire only what is brighter than 500 cd/m² after blurring counts. The width of the blur (12 mm at half
height, on the luminaire) is from memory and not verified.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.scene import FloatArray

#: cd/m²; darker parts do not glare.
EFFECTIVE_LUMINANCE = 500.0
#: m, full width at half maximum of the blur on the luminaire.
BLUR_WIDTH = 0.012


def blurred(luminance: FloatArray, *, pixel: float, width: float = BLUR_WIDTH) -> FloatArray:
    """Blur an image (h, w) of a luminaire by a Gaussian of the eye's resolution.

    Parameters
    ----------
    pixel : float, m, width of a pixel on the luminaire
    width : float, m, full width at half maximum
    """
    from scipy.ndimage import gaussian_filter

    sigma = width / (2 * math.sqrt(2 * math.log(2))) / pixel
    return np.asarray(gaussian_filter(luminance, sigma, mode="constant"))


def effective(luminance: FloatArray, solid_angles: FloatArray) -> tuple[float, float]:
    """Effective luminance (cd/m²) and solid angle (sr) of blurred pixels (...): those above 500 cd/m²."""
    bright = luminance > EFFECTIVE_LUMINANCE
    solid_angle = float(solid_angles[bright].sum())
    if solid_angle == 0:
        return 0.0, 0.0
    return float(luminance[bright] @ solid_angles[bright]) / solid_angle, solid_angle


def uniformity_factor(luminance: FloatArray, solid_angles: FloatArray) -> float:
    """Factor ``k²`` of a luminaire from its blurred pixels (...), all of its luminous area; 1 if uniform."""
    mean = float(np.average(luminance, weights=solid_angles))
    if mean <= 0:
        return 0.0
    effective_luminance, effective_solid_angle = effective(luminance, solid_angles)
    return effective_luminance**2 * effective_solid_angle / (mean**2 * float(solid_angles.sum()))
