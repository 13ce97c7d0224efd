"""CIE 171:2006, 5.4: all the flux of a lamp arrives on the surfaces of a closed black room."""

from __future__ import annotations

import math

import numpy as np

from lelight.analytic.case import Case, sums_of_probes
from lelight.analytic.room import HEIGHT, SIDE
from lelight.analytic.solids import Vector, box, gauss_rectangle, lamp, matt, probe, scene
from lelight.scene import FloatArray

#: lm
FLUX = 10_000.0
POSITION = (2.0, 2.0, 2.0)
#: Gauss points along each edge of a face.
COUNT = 10

_X, _Y, _Z = (SIDE, 0.0, 0.0), (0.0, SIDE, 0.0), (0.0, 0.0, HEIGHT)
#: Name, corner and edges of each face; u x v points into the room.
FACES: tuple[tuple[str, Vector, Vector, Vector], ...] = (
    ("floor", (0, 0, 0), _X, _Y),
    ("ceiling", (0, 0, HEIGHT), _Y, _X),
    ("wall x = 0", (0, 0, 0), _Y, _Z),
    ("wall x = 4 m", (SIDE, 0, 0), _Z, _Y),
    ("wall y = 0", (0, 0, 0), _Z, _X),
    ("wall y = 4 m", (0, SIDE, 0), _X, _Z),
)


def rectangle_solid_angle(a: float, b: float, distance: float) -> float:
    """Solid angle in sr of a rectangle a x b seen from straight above one of its corners."""
    return math.atan(a * b / (distance * math.sqrt(a * a + b * b + distance * distance)))


def face_flux(corner: Vector, u: Vector, v: Vector) -> float:
    """Luminous flux in lm from the lamp on a face: intensity times the solid angle of its four quarters."""
    to_corner = np.subtract(corner, POSITION)
    lengths = np.linalg.norm(u), np.linalg.norm(v)
    s, t = (float(-to_corner @ np.asarray(e) / length) for e, length in zip((u, v), lengths, strict=True))
    normal = np.cross(u, v) / (lengths[0] * lengths[1])
    distance = abs(float(to_corner @ normal))
    quarters = [(a, b) for a in (s, float(lengths[0]) - s) for b in (t, float(lengths[1]) - t)]
    return FLUX / (4.0 * math.pi) * sum(rectangle_solid_angle(a, b, distance) for a, b in quarters)


def case() -> Case:
    """Flux on each face, and on all, summed from Gauss points."""
    planes, weights = [], np.zeros((len(FACES) + 1, len(FACES) * COUNT**2))
    allowance = np.zeros(len(FACES) + 1)
    for k, (name, corner, u, v) in enumerate(FACES):
        points, shares = gauss_rectangle(COUNT, corner, u, v)
        normal = np.cross(u, v)
        area = float(np.linalg.norm(normal))
        planes += [probe(name, point, normal / area) for point in points]
        own = slice(k * COUNT**2, (k + 1) * COUNT**2)
        weights[[k, -1], own] = shares * area
        allowance[k] = abs(shares @ _direct(points, normal / area) * area - face_flux(corner, u, v))
    allowance[-1] = allowance[:-1].sum()
    exact = [face_flux(corner, u, v) for _, corner, u, v in FACES]
    room = box((0, 0, 0), (SIDE, SIDE, HEIGHT), matt("walls", 0.0), inward=True)
    lamps = [lamp(POSITION, FLUX / (4.0 * math.pi))]
    labels = [*(name for name, *_ in FACES), "all faces"]
    return Case(
        name="cie171-5.4",
        group="CIE 171:2006",
        title="5.4 flux conservation in a black room, 10 klm",
        basis="solid angles; the Gauss rule's own error is allowed for",
        scene=scene("CIE 171 5.4", room, luminaires=lamps, planes=planes),
        edge=1.0,
        target=0.02,
        tolerance=0.001,
        precision=0.0005,
        read=sums_of_probes(labels, weights, np.array([*exact, FLUX]), allowance=allowance),
        quantity="luminous flux",
        unit="lm",
    )


def _direct(points: FloatArray, normal: FloatArray) -> FloatArray:
    toward = np.asarray(POSITION) - points
    return np.asarray(FLUX / (4.0 * math.pi) * (toward @ normal) / np.linalg.norm(toward, axis=1) ** 3)
