"""CIE 171:2006, 5.2: a point source 3 m over a floor of 4 m x 4 m, isotropic or diffuse (I = 1000 cos theta cd).

The diffuse source is a luminous square of 5 cm: its exact illuminance is Lambert's formula, within 1e-4 of the
point's.
"""

from __future__ import annotations

import numpy as np

from lelight.analytic.case import Case, at_probes
from lelight.analytic.configuration import polygon_illuminance
from lelight.analytic.solids import Solid, lamp, matt, parallelogram, probe, scene
from lelight.scene import FloatArray, PointLuminaire

HEIGHT, INTENSITY, SIZE = 3.0, 1000.0, 0.05
#: x and y in m of points A to J, seen from the source's foot.
POINTS = np.array(
    [[0, 0], [0.5, 0], [1, 0], [1.5, 0], [0.5, 0.5], [1, 0.5], [1.5, 0.5], [1, 1], [1.5, 1], [1.5, 1.5]]
)


def isotropic(points: FloatArray) -> FloatArray:
    """Exact illuminance (n,) in lx of floor points (n, 2): I h / r³."""
    return np.asarray(INTENSITY * HEIGHT / (HEIGHT**2 + np.sum(points**2, axis=1)) ** 1.5)


def square() -> Solid:
    """Make the small luminous square, facing down, whose axial intensity is 1000 cd."""
    half = 0.5 * SIZE
    shining = matt("lamp", 0.0, luminance=INTENSITY / SIZE**2)
    return parallelogram((-half, -half, HEIGHT), (0, SIZE, 0), (SIZE, 0, 0), shining)


def diffuse(points: FloatArray) -> FloatArray:
    """Exact illuminance (n,) in lx of floor points (n, 2) under the luminous square."""
    places = np.column_stack([points, np.zeros(len(points))])
    upward = np.broadcast_to([0.0, 0.0, 1.0], places.shape)
    return polygon_illuminance(places, upward, square().vertices, luminance=INTENSITY / SIZE**2)


def isotropic_case() -> Case:
    """Light the floor by an isotropic point luminaire of 1000 cd."""
    return _case("isotropic", "I h / r³", isotropic(POINTS), luminaires=[lamp((0, 0, HEIGHT), INTENSITY)])


def diffuse_case() -> Case:
    """Light the floor by a small Lambertian square."""
    return _case("diffuse", "Lambert's formula for the square of 5 cm", diffuse(POINTS), solids=[square()])


def _case(
    kind: str,
    basis: str,
    exact: FloatArray,
    *,
    solids: list[Solid] | None = None,
    luminaires: list[PointLuminaire] | None = None,
) -> Case:
    labels = [f"{name} ({x:g}; {y:g})" for name, (x, y) in zip("ABCDEFGHIJ", POINTS, strict=True)]
    floor = parallelogram((-2, -2, 0), (4, 0, 0), (0, 4, 0), matt("floor", 0.0))
    planes = [probe(label, (x, y, 0), (0, 0, 1)) for label, (x, y) in zip(labels, POINTS, strict=True)]
    return Case(
        name=f"cie171-5.2-{kind}",
        group="CIE 171:2006",
        title=f"5.2 {kind} point source, 1000 cd",
        basis=basis,
        scene=scene(
            f"CIE 171 5.2 {kind}", floor, *(solids or []), luminaires=luminaires or [], planes=planes
        ),
        edge=1.0,
        target=0.02,
        tolerance=0.001,
        precision=0.0005,
        read=at_probes(labels, exact),
    )
