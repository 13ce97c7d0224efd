"""Reflection of surfaces: a Lambertian lobe and a modified Phong lobe.

f = kd / pi + ks (n + 2) / (2 pi) cos^n(alpha), alpha between the direction and the mirror direction
(Lafortune & Willems 1994). Both lobes act on either side of a face.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lelight.channels import luminance_weights
from lelight.compilation import LEAF
from lelight.scene import FloatArray, Scene
from lelight.spectral.bands import diffuse_in_channels


class Reflectances(NamedTuple):
    """Materials as arrays, M materials and C channels.

    Attributes
    ----------
    diffuse, specular : (M, C) float, kd and ks
    exponent : (M,) float
    diffuse_share, specular_share : (M,) float, luminance-weighted kd and ks
    """

    diffuse: FloatArray
    specular: FloatArray
    exponent: FloatArray
    diffuse_share: FloatArray
    specular_share: FloatArray


def collect_reflectances(scene: Scene, channels: FloatArray) -> Reflectances:
    """Gather the materials of a scene in the channels that ``channels`` (3, C) gives."""
    diffuse = diffuse_in_channels(scene.materials, channels)
    specular = np.array([m.specular for m in scene.materials]) @ channels
    weights = luminance_weights(channels.shape[1])
    exponent = np.array([m.exponent for m in scene.materials], dtype=np.float64)
    return Reflectances(diffuse, specular, exponent, diffuse @ weights, specular @ weights)


@njit(**LEAF)
def lobe(exponent: float, cos_alpha: float) -> float:
    """Phong lobe for ks = 1, 1/sr: (n + 2) / (2 pi) cos^n."""
    if cos_alpha <= 0.0:
        return 0.0
    return (exponent + 2.0) / (2.0 * math.pi) * math.pow(cos_alpha, exponent)


@njit(**LEAF)
def lobe_density(exponent: float, cos_alpha: float) -> float:
    """Density in 1/sr of drawing a direction from the lobe: (n + 1) / (2 pi) cos^n."""
    if cos_alpha <= 0.0:
        return 0.0
    return (exponent + 1.0) / (2.0 * math.pi) * math.pow(cos_alpha, exponent)


@njit(**LEAF)
def diffuse_probability(reflectances: Reflectances, material: int) -> float:
    """Probability with which a walk that reflects takes the Lambertian lobe."""
    total = reflectances.diffuse_share[material] + reflectances.specular_share[material]
    return reflectances.diffuse_share[material] / total if total > 0.0 else 1.0
