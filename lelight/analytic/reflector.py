"""CIE 171:2006, 5.6 and 5.7: light that a diffuse surface S2 sends to the points of a room, free or past a screen.

The report gives 100 E / (E_S2 rho), which is the configuration factor in per cent. A surface of 100 lm/m² gives
just that as illuminance. In one case S2 really reflects, under a lamp that no measuring point faces.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.analytic.case import Case, at_probes
from lelight.analytic.configuration import polygon_illuminance
from lelight.analytic.room import HEIGHT, SIDE, row_points, wall_points
from lelight.analytic.solids import (
    Solid,
    box,
    gauss_rectangle,
    lamp,
    matt,
    parallelogram,
    place_of,
    scene,
)
from lelight.scene import FloatArray, MeasuringPlane, PointLuminaire

#: Luminance in cd/m² of 100 lm/m².
LUMINANCE = 100.0 / math.pi
#: Where the lamp of the reflecting case stands: behind wall and ceiling points, in the plane of the wall x = 4 m.
LAMP, INTENSITY = np.array([SIDE, -6.0, 12.0]), 10_000.0
REFLECTANCE = 0.5
#: Screen of 5.7: black, as wide as the room, from y = 2.5 m to 2.7 m and 1 m high.
SCREEN = ((0.0, 2.5, 0.0), (SIDE, 2.7, 1.0))


def floor_square(side: float, reflectance: float = 0.0, *, luminance: float = LUMINANCE) -> Solid:
    """S2 of 5.6: a square in the plane of the floor, in its middle, facing up."""
    corner = (0.5 * (SIDE - side), 0.5 * (SIDE - side), 0.0)
    return parallelogram(corner, (side, 0, 0), (0, side, 0), matt("S2", reflectance, luminance=luminance))


def horizontal_case(side: float) -> Case:
    """5.6: a luminous S2 of 0.5 m, 4 m or 500 m."""
    surface = floor_square(side)
    planes = [*wall_points(upwards=True), *row_points(HEIGHT)]
    return _case(
        f"cie171-5.6-{side:g}",
        f"5.6 horizontal surface of {side:g} m x {side:g} m",
        "Lambert's formula",
        [surface],
        planes,
        seen_whole(planes, surface.vertices),
        edge=max(1.0, side / 5.0),
    )


def reflecting_case() -> Case:
    """5.6 with an S2 of 4 m that reflects the light of a lamp."""
    surface = floor_square(SIDE, REFLECTANCE, luminance=0.0)
    planes = [*wall_points(upwards=True), *row_points(HEIGHT)]
    return _case(
        "cie171-5.6-lamp",
        "5.6 horizontal surface of 4 m x 4 m, reflecting the light of a lamp",
        "quadrature over the surface",
        [surface],
        planes,
        reflected(planes, surface.vertices),
        target=0.004,
        luminaires=[lamp(LAMP, INTENSITY)],
    )


def screen_case() -> Case:
    """5.7: S2 is the wall y = 4 m, and a screen stands in the way."""
    wall = parallelogram((0, SIDE, 0), (SIDE, 0, 0), (0, 0, HEIGHT), matt("S2", 0.0, luminance=LUMINANCE))
    screen = box(*SCREEN, matt("screen", 0.0), inward=False)
    # Points L to N lie beyond the screen or under it; the report has none there.
    planes = [*wall_points(upwards=True), *row_points(0.0)[:5]]
    return _case(
        "cie171-5.7",
        "5.7 vertical surface of 4 m x 3 m behind a screen",
        "Lambert's formula for what the screen leaves free",
        [wall, screen],
        planes,
        np.array([over_the_screen(plane) for plane in planes]),
        target=0.003,
    )


def seen_whole(planes: list[MeasuringPlane], polygon: FloatArray) -> FloatArray:
    """Exact illuminance (k,) in lx at points that see all of a polygon of 100 lm/m²."""
    points = np.array([place_of(plane) for plane in planes])
    normals = np.array([plane.normal for plane in planes])
    return polygon_illuminance(points, normals, polygon, luminance=LUMINANCE)


def over_the_screen(plane: MeasuringPlane) -> float:
    """Exact illuminance in lx that the wall y = 4 m gives over the screen's upper edges."""
    point = place_of(plane)
    lowest = max(_cut(point, SCREEN[0][1]), _cut(point, SCREEN[1][1]), 0.0)
    if lowest >= HEIGHT:
        return 0.0
    free = np.array([[0, SIDE, lowest], [SIDE, SIDE, lowest], [SIDE, SIDE, HEIGHT], [0, SIDE, HEIGHT]])
    return float(seen_whole([plane], free)[0])


def _cut(point: FloatArray, edge: float) -> float:
    """Height in m at which the wall is met by a ray from a point past the screen's upper edge at y."""
    top = SCREEN[1][2]
    return float(point[2] + (top - point[2]) * (SIDE - point[1]) / (edge - point[1]))


def reflected(planes: list[MeasuringPlane], corners: FloatArray, *, count: int = 120) -> FloatArray:
    """Exact illuminance (k,) in lx at points that see a square lit by the lamp: Gauss-Legendre over the square."""
    at, shares = gauss_rectangle(count, corners[0], corners[1] - corners[0], corners[3] - corners[0])
    area = float(np.prod(np.ptp(corners, axis=0)[:2]))
    toward = LAMP - at
    luminance = REFLECTANCE / math.pi * INTENSITY * toward[:, 2] / np.linalg.norm(toward, axis=1) ** 3
    found = []
    for plane in planes:
        way = at - (place_of(plane))
        kernel = np.maximum(way @ plane.normal, 0.0) * -way[:, 2] / np.sum(way**2, axis=1) ** 2
        found.append(float(area * shares @ (luminance * kernel)))
    return np.array(found)


def _case(
    name: str,
    title: str,
    basis: str,
    solids: list[Solid],
    planes: list[MeasuringPlane],
    exact: FloatArray,
    *,
    target: float = 0.02,
    edge: float = 1.0,
    luminaires: list[PointLuminaire] | None = None,
) -> Case:
    """Points of wall, floor or ceiling; of the black room only what hides nothing from any of them is there."""
    ceiling = parallelogram((0, 0, HEIGHT), (0, SIDE, 0), (SIDE, 0, 0), matt("ceiling", 0.0))
    wall = parallelogram((SIDE, 0, 0), (0, 0, HEIGHT), (0, SIDE, 0), matt("wall", 0.0))
    black = wall if luminaires else ceiling
    made = scene(name, *solids, black, luminaires=luminaires or [], planes=planes)
    return Case(
        name=name,
        group="CIE 171:2006",
        title=title,
        basis=basis,
        scene=made,
        edge=edge,
        target=target,
        tolerance=0.01,
        precision=0.003,
        read=at_probes([plane.name for plane in planes], exact),
    )
