"""Two rectangles, parallel or perpendicular with a common edge: mean illuminance against their form factor.

The mean is taken over Gauss points. What that rule errs is the difference between its sum over exact
configuration factors and the form factor.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.analytic.case import Case, sums_of_probes
from lelight.analytic.configuration import (
    parallel_rectangles,
    perpendicular_rectangles,
    polygon_illuminance,
)
from lelight.analytic.solids import Solid, Vector, gauss_rectangle, matt, parallelogram, probe, scene

#: cd/m²; an exitance of 1000 lm/m².
LUMINANCE = 1000.0 / math.pi
COUNT = 8


def parallel_case() -> Case:
    """Rectangles of 3 m x 2 m, 1.5 m apart."""
    lit = parallelogram((0, 0, 0), (3, 0, 0), (0, 2, 0), matt("source", 0.0, luminance=LUMINANCE))
    factor = parallel_rectangles(3.0, 2.0, 1.5)
    return _case("parallel", "3 m x 2 m, 1.5 m apart", lit, ((0, 0, 1.5), (0, 2, 0), (3, 0, 0)), factor)


def perpendicular_case() -> Case:
    """Light a floor of 2 m x 3 m by a wall 1.5 m high on its longer edge."""
    lit = parallelogram((0, 0, 0), (0, 3, 0), (0, 0, 1.5), matt("source", 0.0, luminance=LUMINANCE))
    factor = perpendicular_rectangles(2.0, 1.5, 3.0)
    what = "floor 2 m deep, wall 1.5 m high, common edge 3 m"
    return _case("perpendicular", what, lit, ((0, 0, 0), (2, 0, 0), (0, 3, 0)), factor)


def _case(kind: str, what: str, lit: Solid, face: tuple[Vector, Vector, Vector], factor: float) -> Case:
    """Build the case of a source and a black face (corner, u, v); ``factor`` from face to source."""
    points, weights = gauss_rectangle(COUNT, *face)
    normal = np.cross(face[1], face[2])
    normal = normal / np.linalg.norm(normal)
    normals = np.broadcast_to(normal, points.shape)
    exact = math.pi * LUMINANCE * factor
    by_rule = float(weights @ polygon_illuminance(points, normals, lit.vertices, luminance=LUMINANCE))
    made = scene(
        f"{kind} rectangles",
        lit,
        parallelogram(*face, matt("face", 0.0)),
        planes=[probe(f"point {k}", point, normal) for k, point in enumerate(points, start=1)],
    )
    return Case(
        name=f"rectangles-{kind}",
        group="Form factors",
        title=f"{kind} rectangles, {what}",
        basis="form factor in closed form; the Gauss rule's own error is allowed for",
        scene=made,
        edge=1.0,
        target=0.02,
        tolerance=0.005,
        precision=0.002,
        read=sums_of_probes(
            ["mean of the face"], weights[None], np.array([exact]), allowance=abs(by_rule - exact)
        ),
    )
