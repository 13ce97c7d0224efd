"""The furnace: every surface of a closed room sends out the same light, so E is the same everywhere.

With M = pi L emitted and reflectance rho, E = M / (1 - rho) at every point, in every concave edge and corner. The
room is a prism with an acute corner of 21.8 degrees, a right angle and an edge that juts in; a box hangs in mid-air.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lelight.analytic.case import Case, Readings, at_nodes, at_probes
from lelight.analytic.solids import box, matt, prism, probe, scene
from lelight.calculation import Calculation
from lelight.scene import FloatArray, MeasuringPlane, Scene

#: cd/m²
LUMINANCE = 100.0
HEIGHT = 2.6
OUTLINE = np.array([[0.0, 0.0], [6.5, 0.0], [4.0, 1.0], [4.0, 3.0], [2.0, 3.0], [2.0, 4.5], [0.0, 4.5]])
FLOOR = np.array([[0, 1, 2], [0, 2, 4], [2, 3, 4], [0, 4, 5], [0, 5, 6]])
PLACES = {
    "node next to the acute corner": (6.5, 0.0, 0.0),
    "node next to a right corner": (0.0, 4.5, HEIGHT),
    "node next to the edge that juts in": (2.0, 3.0, 1.3),
}
#: Points 1 cm and 1 mm off two and three surfaces that meet.
CLOSE = {
    "floor, 1 cm off a wall": ((1.0, 0.01, 0.0), (0, 0, 1)),
    "floor, 1 mm off a wall": ((1.0, 0.001, 0.0), (0, 0, 1)),
    "floor, 1 cm off a corner": ((0.01, 0.01, 0.0), (0, 0, 1)),
    "floor, 1 mm off a corner": ((0.001, 0.001, 0.0), (0, 0, 1)),
    "wall, 1 mm off the ceiling": ((0.0, 2.0, HEIGHT - 0.001), (1, 0, 0)),
    "floor, in the acute corner": ((6.4, 0.02, 0.0), (0, 0, 1)),
}


def illuminance(reflectance: float) -> float:
    """Exact illuminance in lx, at every point."""
    return math.pi * LUMINANCE / (1.0 - reflectance)


def nodes_case(reflectance: float, *, target: float) -> Case:
    """All nodes, those in the corners named."""

    def exact(positions: FloatArray, _normals: FloatArray) -> FloatArray:
        return np.full(len(positions), illuminance(reflectance))

    return _case(
        f"furnace-{reflectance:g}-nodes",
        f"reflectance {reflectance:g}, all nodes",
        _room(reflectance, []),
        lambda run: at_nodes(run, exact, places=PLACES),
        edge=2.0,
        target=target,
    )


def corners_case(reflectance: float, *, target: float) -> Case:
    """Points millimetres off concave edges and corners."""
    planes = [probe(label, point, normal) for label, (point, normal) in CLOSE.items()]
    exact = np.full(len(CLOSE), illuminance(reflectance))
    return _case(
        f"furnace-{reflectance:g}-corners",
        f"reflectance {reflectance:g}, points close to concave edges and corners",
        _room(reflectance, planes),
        at_probes(list(CLOSE), exact),
        edge=4.0,
        target=target,
    )


def _room(reflectance: float, planes: list[MeasuringPlane]) -> Scene:
    walls = matt("walls", reflectance, luminance=LUMINANCE)
    body = matt("body", reflectance, luminance=LUMINANCE)
    return scene(
        "furnace",
        prism(OUTLINE, FLOOR, HEIGHT, walls),
        box((2.6, 1.4, 0.9), (3.2, 2.2, 1.5), body, inward=False),
        planes=planes,
    )


def _case(
    name: str,
    title: str,
    made: Scene,
    read: Callable[[Calculation], Readings],
    *,
    edge: float,
    target: float,
) -> Case:
    return Case(
        name=name,
        group="Furnace",
        title=title,
        basis="balance of energy: E = pi L / (1 - rho)",
        scene=made,
        edge=edge,
        target=target,
        tolerance=0.01,
        precision=0.003,
        read=read,
    )
