"""The local estimate: every chain vertex lights every receiver it sees (equation (16) of the method's paper).

A vertex y with flux W gives the receiver x the irradiance W f(y) G(x, y), G = cos cos' / r² (without the
receiver's cosine in space). G has no bound, so it is split: here min(G, b) for the Lambertian lobe and
min(pi lobe G, b) for the Phong lobe; what is cut off comes from the receiver's own side (`nearfield`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.compilation import LEAF
from lelight.estimate.lighttree import LightTree
from lelight.estimate.moments import add_arrival
from lelight.estimate.pairs import Pairs, drawn_pairs, off_surfaces, scanned_pairs
from lelight.estimate.thinning import Thinning
from lelight.receivers import MOMENTS, Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import ChainVertices
from lelight.tracing.reflection import Reflectances
from lelight.tracing.world import World

#: Vertices handled at once for one block of receivers; bounds memory, does not change results.
VERTEX_CHUNK = 32
#: Key of draws where nothing is drawn.
NO_KEY = np.uint64(0)


@dataclass(frozen=True)
class Arrivals:
    """Light that arrives at receivers, one row a ray.

    Attributes
    ----------
    receiver : (k,) int
    directions : (k, 3) float, unit, toward the light
    radiance_solid_angle : (k, C) float, cd/m² sr
    """

    receiver: IntArray
    directions: FloatArray
    radiance_solid_angle: FloatArray


@dataclass(frozen=True)
class LocalEstimate:
    """What the chains give a block of receivers.

    Attributes
    ----------
    moments : (r, 6, C) float
    arrivals : the single rays, only where receivers keep angular detail
    rays : int, shadow rays traced
    """

    moments: FloatArray
    arrivals: tuple[Arrivals, ...]
    rays: int


def local_estimate(
    world: World,
    receivers: Receivers,
    *,
    vertices: ChainVertices,
    bound: float,
    asked: float = math.inf,
    key: np.uint64 = NO_KEY,
    tree: LightTree | None = None,
) -> LocalEstimate:
    """Let vertices light receivers through shadow rays.

    Parameters
    ----------
    bound : float, 1/m², b of the kernel
    asked : float, about so many vertices a receiver asks; all by default
    key : which those are depends on
    tree : of the vertices; without it receivers look at all of them to choose whom to ask
    """
    moments = np.zeros((len(receivers), MOMENTS, world.channels))
    kept: list[Arrivals] = []
    rays = 0
    angular = bool(np.any(receivers.degrees > 0))
    thinning = Thinning.of(world, receivers, vertices, bound=bound, asked=asked, key=key)
    if tree is None:
        chosen: Iterable[Pairs] = _scanned(world, receivers, vertices, bound, thinning)
    else:
        drawn = tree.draw(receivers, bound=bound, thinning=thinning)
        chosen = [drawn_pairs(world, receivers, vertices, drawn=drawn, bound=bound)]
    for pairs in chosen:
        rays += len(pairs.vertex)
        clear = world.caster.unblocked(pairs.origins, pairs.segments)
        _gather(moments, receivers, vertices, pairs, clear, world)
        if angular:
            kept.append(_arrivals(receivers, vertices, pairs, np.flatnonzero(clear), world))
    return LocalEstimate(moments, tuple(kept), rays)


def _scanned(
    world: World, receivers: Receivers, vertices: ChainVertices, bound: float, thinning: Thinning
) -> Iterator[Pairs]:
    """Go through all vertices, some at a time; the pairs hold until the next are asked for."""
    ends = off_surfaces(world, vertices, receivers)
    room = Pairs.room_for(min(VERTEX_CHUNK, len(vertices)) * len(receivers))
    for first in range(0, len(vertices), VERTEX_CHUNK):
        chunk = slice(first, first + VERTEX_CHUNK)
        yield scanned_pairs(
            world, receivers, vertices, chunk, bound=bound, thinning=thinning, off_surfaces=ends, room=room
        )


def _gather(
    moments: FloatArray,
    receivers: Receivers,
    vertices: ChainVertices,
    pairs: Pairs,
    clear: BoolArray,
    world: World,
) -> None:
    _add_pairs(
        moments,
        clear,
        pairs.vertex,
        pairs.receiver,
        pairs.diffuse,
        pairs.specular,
        vertices.points,
        vertices.flux,
        vertices.materials,
        world.reflectances,
        receivers.points,
        receivers.normals,
    )


@njit(**LEAF)
def _add_pairs(
    moments: FloatArray,
    clear: BoolArray,
    vertex: IntArray,
    receiver: IntArray,
    diffuse: FloatArray,
    specular: FloatArray,
    points: FloatArray,
    flux: FloatArray,
    materials: IntArray,
    reflectances: Reflectances,
    at: FloatArray,
    at_normals: FloatArray,
) -> None:
    """Sum the unblocked pairs into the moments (r, 6, C), in order of vertices."""
    for k in range(len(clear)):
        if not clear[k]:
            continue
        i, r = vertex[k], receiver[k]
        m = materials[i]
        wx, wy, wz = points[i, 0] - at[r, 0], points[i, 1] - at[r, 1], points[i, 2] - at[r, 2]
        shorten = 1.0 / math.sqrt(wx * wx + wy * wy + wz * wz)
        wx, wy, wz = wx * shorten, wy * shorten, wz * shorten
        cos_theta = wx * at_normals[r, 0] + wy * at_normals[r, 1] + wz * at_normals[r, 2]
        for c in range(moments.shape[2]):
            reflected = reflectances.diffuse[m, c] * diffuse[k] + reflectances.specular[m, c] * specular[k]
            add_arrival(moments[r], c, wx, wy, wz, cos_theta, flux[i, c] * reflected)


def _arrivals(
    receivers: Receivers, vertices: ChainVertices, pairs: Pairs, clear: IntArray, world: World
) -> Arrivals:
    """List the unblocked pairs at receivers that keep angular detail."""
    wanted = clear[receivers.degrees[pairs.receiver[clear]] > 0]
    found = Arrivals(
        pairs.receiver[wanted], np.empty((len(wanted), 3)), np.empty((len(wanted), world.channels))
    )
    _list_arrivals(
        wanted,
        pairs.vertex,
        pairs.receiver,
        pairs.diffuse,
        pairs.specular,
        vertices.points,
        vertices.flux,
        vertices.materials,
        world.reflectances,
        receivers.points,
        found.directions,
        found.radiance_solid_angle,
    )
    return found


@njit(**LEAF)
def _list_arrivals(
    wanted: IntArray,
    vertex: IntArray,
    receiver: IntArray,
    diffuse: FloatArray,
    specular: FloatArray,
    points: FloatArray,
    flux: FloatArray,
    materials: IntArray,
    reflectances: Reflectances,
    at: FloatArray,
    out_directions: FloatArray,
    out_light: FloatArray,
) -> None:
    """Write direction and radiance times solid angle of each wanted pair."""
    for k, pair in enumerate(wanted):
        i, r = vertex[pair], receiver[pair]
        m = materials[i]
        wx, wy, wz = points[i, 0] - at[r, 0], points[i, 1] - at[r, 1], points[i, 2] - at[r, 2]
        shorten = 1.0 / math.sqrt(wx * wx + wy * wy + wz * wz)
        out_directions[k, 0], out_directions[k, 1], out_directions[k, 2] = (
            wx * shorten,
            wy * shorten,
            wz * shorten,
        )
        for c in range(out_light.shape[1]):
            reflected = (
                reflectances.diffuse[m, c] * diffuse[pair] + reflectances.specular[m, c] * specular[pair]
            )
            out_light[k, c] = flux[i, c] * reflected
