"""Point luminaires, isotropic or by a table: what they give at a place, and where on them a ray goes.

A luminaire farther away than five times the size of its opening is a point: its intensity is exact, one ray tells
whether it is seen. A nearer one is spread evenly over its opening; every part sends its share of the same
distribution, so that the flux stays what it is.
"""

from __future__ import annotations

import math

from numba import njit

from lelight.compilation import LEAF
from lelight.tracing.distributions import table_direction, table_intensity
from lelight.tracing.emitters import Emitters
from lelight.tracing.sampling import Vector, sphere_direction

#: Distance in sizes of the opening beyond which a luminaire is a point: the five-times rule of photometry.
NEAR_SIZES = 5.0
#: Least cosine, and least share of the largest intensity, that the choice of a near luminaire assumes, since
#: other parts of it may be seen better than its middle.
LOW, DIM = 0.1, 0.05
#: Nodes and weights of Gauss and Legendre's rule on [0, 1].
NODES = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)
WEIGHTS = (0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692)
#: Most parts that each edge of an opening is cut into for its closed form.
MOST_PARTS = 8
#: Even directions of a quadrature around a round opening, in a part.
AROUND = 8
#: Distance in sizes below which an opening has no closed form here.
TOO_NEAR = 0.75
#: Steps of a table that one part of an opening may span.
STEPS_IN_PART = 2.0


@njit(**LEAF)
def lamp_intensity(emitters: Emitters, p: int, dx: float, dy: float, dz: float) -> float:
    """Relative intensity of point ``p`` along a unit direction in scene axes; see `source_strength`."""
    t = emitters.tables[p]
    if t < 0:
        return 1.0
    a = emitters.axes[p]
    return float(
        table_intensity(
            emitters.distributions,
            t,
            dx * a[0, 0] + dy * a[0, 1] + dz * a[0, 2],
            dx * a[1, 0] + dy * a[1, 1] + dz * a[1, 2],
            dx * a[2, 0] + dy * a[2, 1] + dz * a[2, 2],
        )
    )


@njit(**LEAF)
def lamp_importance(
    emitters: Emitters,
    p: int,
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    on_surface: bool,
) -> float:
    """Illuminance times pi that point ``p`` gives were nothing in between, roughly so where it is near."""
    dx, dy, dz = emitters.positions[p, 0] - x, emitters.positions[p, 1] - y, emitters.positions[p, 2] - z
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    t = emitters.tables[p]
    flux = 4.0 * math.pi if t < 0 else emitters.distributions.flux[t]
    peak = 1.0 if t < 0 else emitters.distributions.peak[t]
    if not (distance > 0.0 or emitters.sizes[p] > 0.0) or not flux > 0.0:
        return 0.0
    far = max(distance, 1e-12)
    return float(
        seen_importance(
            far,
            (dx * nx + dy * ny + dz * nz) if on_surface else far,
            emitters.sizes[p],
            lamp_intensity(emitters, p, -dx / far, -dy / far, -dz / far),
            peak,
        )
        * (emitters.power[len(emitters.areas) + p] / flux)
    )


@njit(**LEAF)
def seen_importance(distance: float, rise: float, size: float, intensity: float, peak: float) -> float:
    """`lamp_importance` for a factor of 1, from how a luminaire is seen: distance and rise over the surface in m."""
    near = distance < NEAR_SIZES * size
    if rise + (size if near else 0.0) <= 0.0:
        return 0.0
    cosine, spread = rise / distance, distance * distance
    if near:
        cosine, spread = max(cosine, LOW), spread + size * size / math.pi
        intensity = max(intensity, DIM * peak)
    return math.pi * intensity * cosine / spread


@njit(**LEAF)
def on_figure(emitters: Emitters, p: int, u: float, v: float) -> Vector:
    """Place in m on the opening of point ``p``, even over its area for even ``u`` and ``v``."""
    if emitters.round[p]:
        radius, turn = 0.5 * math.sqrt(u), 2.0 * math.pi * v
        a, b = radius * math.cos(turn), radius * math.sin(turn)
    else:
        a, b = u - 0.5, v - 0.5
    e, q = emitters.edges[p], emitters.positions[p]
    return (
        q[0] + a * e[0, 0] + b * e[1, 0],
        q[1] + a * e[0, 1] + b * e[1, 1],
        q[2] + a * e[0, 2] + b * e[1, 2],
    )


@njit(**LEAF)
def toward_lamp(
    emitters: Emitters, p: int, x: float, y: float, z: float, u: float, v: float, offset: float
) -> tuple[Vector, Vector, float, float]:
    """Draw a direction to point ``p``; returns what `drawing.toward_face` does."""
    q = (emitters.positions[p, 0], emitters.positions[p, 1], emitters.positions[p, 2])
    if distance_to(q, x, y, z) < NEAR_SIZES * emitters.sizes[p]:
        q = on_figure(emitters, p, u, v)
    distance = distance_to(q, x, y, z)
    if distance <= 4.0 * offset:
        return (1.0, 0.0, 0.0), (x, y, z), 0.0, 0.0
    d = ((q[0] - x) / distance, (q[1] - y) / distance, (q[2] - z) / distance)
    intensity = lamp_intensity(emitters, p, -d[0], -d[1], -d[2])
    back = 2.0 * offset
    end = (q[0] - back * d[0], q[1] - back * d[1], q[2] - back * d[2])
    if emitters.tables[p] >= 0:
        # Openings lie flush in ceilings: the ray ends on the receiver's side of them however flat it comes.
        up = emitters.axes[p, 2]
        side = math.copysign(offset, d[0] * up[0] + d[1] * up[1] + d[2] * up[2])
        end = (end[0] - side * up[0], end[1] - side * up[1], end[2] - side * up[2])
    return d, end, intensity / (distance * distance), 0.0


@njit(**LEAF)
def distance_to(q: Vector, x: float, y: float, z: float) -> float:
    """Distance in m of two places."""
    return math.sqrt((q[0] - x) ** 2 + (q[1] - y) ** 2 + (q[2] - z) ** 2)


@njit(**LEAF)
def _seen_from(
    emitters: Emitters, p: int, q: Vector, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> float:
    """Relative illuminance that a place ``q`` of the opening of point ``p`` gives."""
    dx, dy, dz = q[0] - x, q[1] - y, q[2] - z
    square = dx * dx + dy * dy + dz * dz
    rise = dx * nx + dy * ny + dz * nz
    # A place where a lamp hangs has no direction to it, and is given none of its light.
    if rise <= 0.0 or square <= 0.0:
        return 0.0
    distance = math.sqrt(square)
    return float(
        lamp_intensity(emitters, p, -dx / distance, -dy / distance, -dz / distance)
        * rise
        / (square * distance)
    )


@njit(**LEAF)
def parts_of_opening(emitters: Emitters, p: int, x: float, y: float, z: float) -> int:
    """Count the parts an edge is cut into for a closed form: 0 where the luminaire is far and needs none."""
    size = emitters.sizes[p]
    q = (emitters.positions[p, 0], emitters.positions[p, 1], emitters.positions[p, 2])
    distance = distance_to(q, x, y, z)
    if distance >= NEAR_SIZES * size:
        return 0
    step = emitters.distributions.step[emitters.tables[p]]
    return int(max(1, math.ceil(size / max(distance, 1e-9 * size) / (STEPS_IN_PART * step))))


@njit(**LEAF)
def has_closed_form(
    emitters: Emitters, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> bool:
    """Say whether `unshadowed_lamp` holds at a place for all points.

    It does not right beside an opening, where the table is too fine for the opening's angular size, and where
    the receiver's horizon cuts the opening.
    """
    for p in range(len(emitters.positions)):
        parts = parts_of_opening(emitters, p, x, y, z)
        if parts == 0:
            continue
        size = emitters.sizes[p]
        dx, dy, dz = emitters.positions[p, 0] - x, emitters.positions[p, 1] - y, emitters.positions[p, 2] - z
        if parts > MOST_PARTS or dx * dx + dy * dy + dz * dz < (TOO_NEAR * size) ** 2:
            return False
        if abs(dx * nx + dy * ny + dz * nz) < size:
            return False
    return True


@njit(**LEAF)
def _gauss(k: int, parts: int) -> tuple[float, float]:
    """Place and weight of point ``k`` of the rule on [0, 1], cut into parts."""
    return (k // 4 + NODES[k % 4]) / parts, WEIGHTS[k % 4] / parts


@njit(**LEAF)
def unshadowed_lamp(
    emitters: Emitters, p: int, x: float, y: float, z: float, nx: float, ny: float, nz: float
) -> float:
    """Relative illuminance of point ``p`` with nothing in between: exact when far, by quadrature when near."""
    parts = parts_of_opening(emitters, p, x, y, z)
    if parts == 0:
        q = (emitters.positions[p, 0], emitters.positions[p, 1], emitters.positions[p, 2])
        return float(_seen_from(emitters, p, q, x, y, z, nx, ny, nz))
    parts = min(parts, MOST_PARTS)
    steps = AROUND * parts if emitters.round[p] else 4 * parts
    total = 0.0
    for i in range(4 * parts):
        u, weight_u = _gauss(i, parts)
        for j in range(steps):
            v, weight_v = ((j + 0.5) / steps, 1.0 / steps) if emitters.round[p] else _gauss(j, parts)
            q = on_figure(emitters, p, u, v)
            total += weight_u * weight_v * _seen_from(emitters, p, q, x, y, z, nx, ny, nz)
    return total


@njit(**LEAF)
def emitted_ray(
    emitters: Emitters, p: int, u: float, v: float, w1: float, w2: float, offset: float
) -> tuple[Vector, Vector]:
    """Origin and direction of light that leaves point ``p``, with density intensity over flux."""
    t = emitters.tables[p]
    if t < 0:
        q = emitters.positions[p]
        return (q[0], q[1], q[2]), sphere_direction(w1, w2)
    a = emitters.axes[p]
    lx, ly, lz = table_direction(emitters.distributions, t, w1, w2)
    d = (
        lx * a[0, 0] + ly * a[1, 0] + lz * a[2, 0],
        lx * a[0, 1] + ly * a[1, 1] + lz * a[2, 1],
        lx * a[0, 2] + ly * a[1, 2] + lz * a[2, 2],
    )
    o = on_figure(emitters, p, u, v)
    lift = math.copysign(offset, lz)
    return (
        o[0] + offset * d[0] + lift * a[2, 0],
        o[1] + offset * d[1] + lift * a[2, 1],
        o[2] + offset * d[2] + lift * a[2, 2],
    ), d
