"""The split of the kernel: what of a surface's reflection lies above the bound, and so belongs to the near field.

The Lambertian lobe is bounded by G <= b, the Phong lobe by pi lobe G <= b; the chains carry what is below
(`local`), paths from the receiver what is above (`paths`).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.reflection import Reflectances


@njit(**LEAF)
def above(bound: float, kernel: float) -> float:
    """Share of a kernel that lies above the bound."""
    if bound <= 0.0:
        return 1.0
    return max(0.0, 1.0 - bound / kernel) if kernel > 0.0 else 0.0


@njit(**LEAF)
def lobe_shares(
    reflectances: Reflectances, material: int, bound: float, geometry: float
) -> tuple[float, float]:
    """Shares of kd and ks above the bound; for the Phong lobe an upper limit, reached at its peak."""
    n = reflectances.exponent[material]
    return above(bound, geometry), above(bound, 0.5 * (n + 2.0) * geometry)


@njit(**LEAF)
def lobe_probability(
    reflectances: Reflectances, material: int, share_diffuse: float, share_specular: float
) -> float:
    """Probability of going on with the Lambertian lobe; negative where neither lobe has anything to give."""
    diffuse = reflectances.diffuse_share[material] * share_diffuse
    specular = reflectances.specular_share[material] * share_specular
    if diffuse + specular <= 0.0:
        return -1.0
    return float(diffuse / (diffuse + specular))


@njit(**COMPILED)
def list_near(
    reflectances: Reflectances, materials: IntArray, geometry: FloatArray, bound: float
) -> BoolArray:
    """Mark the first surfaces of which anything lies above the bound."""
    near = np.zeros(len(materials), dtype=np.bool_)
    for k in range(len(materials)):
        share_d, share_s = lobe_shares(reflectances, materials[k], bound, geometry[k])
        near[k] = lobe_probability(reflectances, materials[k], share_d, share_s) >= 0.0
    return near
