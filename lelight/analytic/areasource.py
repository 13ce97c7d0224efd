"""CIE 171:2006, 5.3: a Lambertian square of 1 m² and 1000 cd/m² in the middle of the ceiling of a black room."""

from __future__ import annotations

import numpy as np

from lelight.analytic.case import Case, at_probes
from lelight.analytic.configuration import polygon_illuminance
from lelight.analytic.room import HEIGHT, SIDE, row_points, wall_points
from lelight.analytic.solids import box, matt, parallelogram, place_of, scene

LUMINANCE = 1000.0


def case() -> Case:
    """Points on wall and floor against Lambert's formula."""
    shining = matt("lamp", 0.0, luminance=LUMINANCE)
    lamp = parallelogram((1.5, 1.5, HEIGHT), (0, 1, 0), (1, 0, 0), shining)
    planes = [*wall_points(), *row_points(0.0)]
    points = np.array([place_of(plane) for plane in planes])
    normals = np.array([plane.normal for plane in planes])
    exact = polygon_illuminance(points, normals, lamp.vertices, luminance=LUMINANCE)
    # Without its black ceiling, in which the lamp would lie.
    room = box((0, 0, 0), (SIDE, SIDE, HEIGHT), matt("walls", 0.0), inward=True, lid=False)
    return Case(
        name="cie171-5.3",
        group="CIE 171:2006",
        title="5.3 area source 1 m x 1 m, 1000 cd/m²",
        basis="Lambert's formula",
        scene=scene("CIE 171 5.3", room, lamp, planes=planes),
        edge=1.0,
        target=0.02,
        tolerance=0.005,
        precision=0.002,
        read=at_probes([plane.name for plane in planes], exact),
    )
