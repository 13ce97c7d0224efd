"""Local estimation averaged over a neighbourhood (Kalos 1963): each receiver is spread over a disc in its plane.

The spike of a near vertex is spread with it, so its variance is finite; beside an edge part of the disc lies
behind the next wall, so the mean is wrong there. For comparison only.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from lelight.estimate.local import Arrivals, LocalEstimate, local_estimate
from lelight.estimate.paths import hashed_numbers
from lelight.mesh.nodes import frames_x
from lelight.receivers import MOMENTS, Receivers
from lelight.scene import FloatArray
from lelight.tracing.chains import ChainVertices, hash_of
from lelight.tracing.world import World

#: Places on the disc, each of which takes an equal part of the vertices.
PLACES = 16
#: Radius of the disc, in mean distances between vertices.
SPACINGS = 4.0


def averaged_estimate(
    world: World, receivers: Receivers, *, vertices: ChainVertices, seed: tuple[int, ...]
) -> LocalEstimate:
    """Let the vertices light places around the receivers; see `lelight.estimate.local.local_estimate`."""
    moments = np.zeros((len(receivers), MOMENTS, world.channels))
    arrivals: tuple[Arrivals, ...] = ()
    rays = 0
    radius = SPACINGS * math.sqrt(world.area / max(len(vertices), 1))
    for place in range(PLACES):
        moved = replace(receivers, points=_moved(receivers, radius, (*seed, place)))
        own = vertices[np.arange(place, len(vertices), PLACES)]
        found = local_estimate(world, moved, vertices=own, bound=math.inf)
        moments += found.moments
        arrivals += found.arrivals
        rays += found.rays
    return LocalEstimate(moments, arrivals, rays)


def _moved(receivers: Receivers, radius: float, seed: tuple[int, ...]) -> FloatArray:
    """Points (r, 3) m drawn by area from discs in the planes of the receivers."""
    numbers = hashed_numbers(hash_of(seed), receivers.identity, 0)
    reach, angle = radius * np.sqrt(numbers[:, 0]), 2.0 * math.pi * numbers[:, 1]
    x = frames_x(receivers.normals)
    y = np.cross(receivers.normals, x)
    shift = np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y
    return np.asarray(receivers.points + reach[:, None] * shift)
