"""Lobes of materials as far as nodes store them."""

from __future__ import annotations

import numpy as np

from lelight.scene import FloatArray, IntArray
from lelight.tracing.reflection import Reflectances


def stored_lobe(reflectances: Reflectances, lobes: IntArray, material: int) -> tuple[FloatArray, int]:
    """Ks (C,) of a material as far as it is stored, and the degree; none where it is too sharp, or not there.

    Parameters
    ----------
    lobes : (n_materials,) int, degree to which the material's lobe is stored
    """
    specular = reflectances.specular[material]
    degree = int(lobes[material])
    return np.asarray(specular * float(degree > 0)), degree
