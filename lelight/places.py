"""Places in space beside grid points and eyes at which a scene's figures ask for light.

An eye is also asked what it would get if it turned, 15 degrees at a time; a plane what falls on vertical
faces over it, and what falls on the bands around it where the scene asks for them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lelight.metrics.areas import Area, surrounding_areas
from lelight.receivers import Receivers, space_receivers
from lelight.scene import FloatArray, Scene
from lelight.tracing.rays import RayCaster

Kind = Literal["turned", "vertical", "surrounding", "background"]

#: Steps of a full turn of an eye: 15 degrees.
TURNS = 24
#: Bearings of the vertical faces over a plane: +x, +y, -x, -y of the scene.
BEARINGS: FloatArray = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
#: How far a ray that looks for a band's end goes, as share of the way to the point.
BEYOND = 1.01
#: Doublings of the samples of a node, by kind; figures are means or maxima over many of these places.
DOUBLINGS: dict[Kind, int] = {"turned": 3, "vertical": 0, "surrounding": 1, "background": 1}


@dataclass(frozen=True)
class Places:
    """Receivers of one kind that belong to one plane or eye.

    Attributes
    ----------
    owner : int, number of the plane or the eye in the scene
    points, normals : (k, 3) float
    """

    kind: Kind
    owner: int
    points: FloatArray
    normals: FloatArray

    def receivers(self) -> Receivers:
        """Receivers in space that sample as their kind needs."""
        return space_receivers(self.points, self.normals, doublings=DOUBLINGS[self.kind])


def turned(direction: FloatArray) -> FloatArray:
    """Line of sight (3,) turned about the vertical in steps of 15 degrees, (24, 3), itself first."""
    angles = 2 * math.pi * np.arange(TURNS) / TURNS
    x, y, z = direction
    cos, sin = np.cos(angles), np.sin(angles)
    return np.stack([cos * x - sin * y, sin * x + cos * y, np.full(TURNS, z)], axis=1)


def further_places(
    scene: Scene, grids: tuple[tuple[FloatArray, tuple[int, int]], ...], caster: RayCaster
) -> tuple[Places, ...]:
    """List all places beside grid points and eyes, eyes first; their order is part of a run's numbers."""
    return (*_turned_eyes(scene), *_over_planes(scene, grids, caster))


def _turned_eyes(scene: Scene) -> Iterator[Places]:
    for number, eye in enumerate(scene.observers):
        directions = turned(eye.direction)[1:]
        yield Places("turned", number, np.tile(eye.position, (TURNS - 1, 1)), directions)


def _over_planes(
    scene: Scene, grids: tuple[tuple[FloatArray, tuple[int, int]], ...], caster: RayCaster
) -> Iterator[Places]:
    for number, (plane, (points, _)) in enumerate(zip(scene.planes, grids, strict=True)):
        # Point by point, all bearings of one point together.
        yield Places(
            "vertical", number, np.repeat(points, len(BEARINGS), axis=0), np.tile(BEARINGS, (len(points), 1))
        )
        for area in surrounding_areas(plane):
            # A little beyond each point, so that one in the plane of a wall is outside.
            beyond = area.anchors + BEYOND * (area.points - area.anchors)
            seen = caster.visible(area.anchors, beyond)
            yield _band(area, number, plane.normal, seen=np.asarray(seen))


def _band(area: Area, number: int, normal: FloatArray, *, seen: FloatArray) -> Places:
    """Keep the points of a band that its task area sees: a band ends at walls and leaves out furniture."""
    points = area.points[seen.astype(np.bool_)]
    return Places(area.kind, number, points, np.tile(normal, (len(points), 1)))
