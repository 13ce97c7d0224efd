"""CIE 171:2006, 5.8: a cube of 4 m, equal reflectance on all faces, an isotropic lamp of 10 klm in its middle.

The balance of energy makes the mean illuminance exactly Phi / (S (1 - rho)), S = 96 m², and by symmetry that of
each face is the same. The mean is taken over the Gauss points of the floor. What that rule errs is known for direct
light; for what the walls reflect it errs as on the configuration factor of a wall of uniform luminance, whose mean
is a form factor, and only for the part by which walls are not uniform.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.analytic.case import Case, sums_of_probes
from lelight.analytic.configuration import perpendicular_rectangles, polygon_illuminance
from lelight.analytic.solids import box, gauss_rectangle, lamp, matt, probe, scene
from lelight.scene import FloatArray

SIDE, FLUX = 4.0, 10_000.0
#: Gauss points along an edge of the floor.
COUNT = 5
_UP = np.array([0.0, 0.0, 1.0])


def mean_illuminance(reflectance: float) -> float:
    """Exact mean illuminance of all faces in lx."""
    return FLUX / (6.0 * SIDE**2 * (1.0 - reflectance))


def case(reflectance: float, *, target: float) -> Case:
    """Mean over the floor."""
    points, weights = gauss_rectangle(COUNT, (0, 0, 0), (SIDE, 0, 0), (0, SIDE, 0))
    walls = box((0, 0, 0), (SIDE, SIDE, SIDE), matt("walls", reflectance), inward=True)
    middle = (0.5 * SIDE,) * 3
    made = scene(
        f"CIE 171 5.8, reflectance {reflectance:g}",
        walls,
        luminaires=[lamp(middle, FLUX / (4.0 * math.pi))],
        planes=[probe(f"point {k}", point, _UP) for k, point in enumerate(points, start=1)],
    )
    exact = np.array([mean_illuminance(reflectance)])
    return Case(
        name=f"cie171-5.8-{reflectance:.2f}",
        group="CIE 171:2006",
        title=f"5.8 diffuse reflections in a cube, reflectance {reflectance:g}",
        basis="balance of energy: mean E = Phi / (S (1 - rho))",
        scene=made,
        edge=0.5,
        target=target,
        tolerance=0.005,
        precision=0.0025,
        read=sums_of_probes(
            ["mean of the floor"], weights[None], exact, allowance=allowance(points, weights, reflectance)
        ),
    )


def allowance(points: FloatArray, weights: FloatArray, reflectance: float) -> float:
    """Bound what the Gauss rule errs on the mean, in lx."""
    toward = np.full(3, 0.5 * SIDE) - points
    direct = FLUX / (4.0 * math.pi) * toward[:, 2] / np.linalg.norm(toward, axis=1) ** 3
    wall = np.array([[0, 0, 0], [0, SIDE, 0], [0, SIDE, SIDE], [0, 0, SIDE]], dtype=float)
    upward = np.broadcast_to(_UP, points.shape)
    factor = polygon_illuminance(points, upward, wall, luminance=1.0 / math.pi)
    off_direct = abs(float(weights @ direct) - mean_illuminance(0.0))
    off_factor = abs(float(weights @ factor) - perpendicular_rectangles(SIDE, SIDE, SIDE))
    # Four walls; what they reflect differs from its mean by less than direct light does from its own mean.
    uneven = reflectance * float(np.ptp(direct))
    return off_direct + 4.0 * off_factor * uneven
