"""Lobes of materials as far as nodes store them."""

from __future__ import annotations

import numpy as np

from lelight.plan import lobe_degree
from lelight.scene import FloatArray
from lelight.tracing.reflection import Reflectances


def stored_lobe(reflectances: Reflectances, material: int) -> tuple[FloatArray, int]:
    """Ks (C,) of a material as far as it is stored, and the degree; none where it is too sharp, or not there."""
    specular = reflectances.specular[material]
    degree = lobe_degree(float(reflectances.exponent[material])) if specular.any() else 0
    return np.asarray(specular * float(degree > 0)), degree
