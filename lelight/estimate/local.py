"""The local estimate: every chain vertex lights every receiver it sees (equation (16) of the method's paper).

A vertex y with flux W gives the receiver x the irradiance W f(y) G(x, y), G = cos cos' / r² (without the
receiver's cosine in space). G has no bound, so it is split: here min(G, b) for the Lambertian lobe and
min(pi lobe G, b) for the Phong lobe; what is cut off comes from the receiver's own side (`nearfield`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.compilation import LEAF
from lelight.estimate.moments import add_arrival
from lelight.estimate.thinning import Thinning
from lelight.receivers import MOMENTS, Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import DIFFUSE_LOBE, SPECULAR_LOBE, ChainVertices
from lelight.tracing.rays import Float32Array
from lelight.tracing.reflection import Reflectances, lobe
from lelight.tracing.sampling import Vector, mirrored
from lelight.tracing.world import World

#: Vertices handled at once for one block of receivers; bounds memory, does not change results.
VERTEX_CHUNK = 256
#: Least cosine at a receiver that the chance of a pair goes by.
LEAST_COSINE = 0.2
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
) -> LocalEstimate:
    """Let vertices light receivers through shadow rays.

    Parameters
    ----------
    bound : float, 1/m², b of the kernel
    asked : float, about so many vertices a receiver asks; all by default
    key : which those are depends on
    """
    moments = np.zeros((len(receivers), MOMENTS, world.channels))
    kept: list[Arrivals] = []
    rays = 0
    angular = bool(np.any(receivers.degrees > 0))
    thinning = Thinning.of(world, receivers, vertices, bound=bound, asked=asked, key=key)
    for first in range(0, len(vertices), VERTEX_CHUNK):
        chunk = slice(first, first + VERTEX_CHUNK)
        pairs = _pairs(world, receivers, vertices, chunk, bound, thinning)
        rays += len(pairs.vertex)
        clear = np.flatnonzero(world.caster.unblocked(pairs.origins, pairs.segments))
        _gather(moments, receivers, vertices, pairs, clear, world)
        if angular:
            kept.append(_arrivals(receivers, vertices, pairs, clear, world))
    return LocalEstimate(moments, tuple(kept), rays)


@dataclass(frozen=True)
class _Pairs:
    vertex: IntArray
    receiver: IntArray
    diffuse: FloatArray
    specular: FloatArray
    origins: Float32Array
    segments: Float32Array


def _pairs(
    world: World,
    receivers: Receivers,
    vertices: ChainVertices,
    chunk: slice,
    bound: float,
    thinning: Thinning,
) -> _Pairs:
    number = np.arange(len(vertices))[chunk]
    room = len(number) * len(receivers)
    pairs = _Pairs(
        vertex=np.empty(room, dtype=np.int64),
        receiver=np.empty(room, dtype=np.int64),
        diffuse=np.empty(room),
        specular=np.empty(room),
        origins=np.empty((room, 3), dtype=np.float32),
        segments=np.empty((room, 3), dtype=np.float32),
    )
    caster = world.caster
    count = _list_pairs(
        number,
        vertices.points,
        vertices.normals,
        vertices.incoming,
        vertices.materials,
        vertices.lobes,
        world.reflectances,
        receivers.points,
        receivers.normals,
        receivers.on_surface,
        bound,
        caster.centre,
        caster.scale,
        caster.offset,
        thinning.flux,
        thinning.threshold,
        thinning.passed,
        pairs.vertex,
        pairs.receiver,
        pairs.diffuse,
        pairs.specular,
        pairs.origins,
        pairs.segments,
    )
    return _Pairs(
        pairs.vertex[:count],
        pairs.receiver[:count],
        pairs.diffuse[:count],
        pairs.specular[:count],
        pairs.origins[:count],
        pairs.segments[:count],
    )


@njit(**LEAF)
def _list_pairs(
    number: IntArray,
    points: FloatArray,
    normals: FloatArray,
    incoming: FloatArray,
    materials: IntArray,
    lobes: IntArray,
    reflectances: Reflectances,
    at: FloatArray,
    at_normals: FloatArray,
    on_surface: BoolArray,
    bound: float,
    centre: FloatArray,
    scale: float,
    offset: float,
    flux: FloatArray,
    threshold: FloatArray,
    passed: FloatArray,
    out_vertex: IntArray,
    out_receiver: IntArray,
    out_diffuse: FloatArray,
    out_specular: FloatArray,
    out_origins: Float32Array,
    out_segments: Float32Array,
) -> int:
    """Write the pairs that can exchange light, with their kernel and their ray in embree's coordinates.

    Weak ones are thinned out, see `Thinning`; the kernel of those that are kept is raised for it.
    """
    count = 0
    for i in number:
        m = materials[i]
        kd = reflectances.diffuse_share[m] if lobes[i] & DIFFUSE_LOBE else 0.0
        ks = reflectances.specular_share[m] if lobes[i] & SPECULAR_LOBE else 0.0
        if kd + ks <= 0.0:
            continue
        px, py, pz = points[i]
        nx, ny, nz = normals[i]
        n = reflectances.exponent[m]
        mx, my, mz = mirrored(incoming[i, 0], incoming[i, 1], incoming[i, 2], nx, ny, nz)
        ox, oy, oz = _scaled(px, py, pz, nx, ny, nz, offset, centre, scale)
        for r in range(len(at)):
            dx, dy, dz = at[r, 0] - px, at[r, 1] - py, at[r, 2] - pz
            cos_vertex = dx * nx + dy * ny + dz * nz
            if cos_vertex <= 0.0:
                continue
            cos_receiver = 1.0
            square = dx * dx + dy * dy + dz * dz
            distance = math.sqrt(square)
            if on_surface[r]:
                cos_receiver = (
                    -(dx * at_normals[r, 0] + dy * at_normals[r, 1] + dz * at_normals[r, 2]) / distance
                )
                if cos_receiver <= 0.0:
                    continue
            cos_vertex /= distance
            kernel = cos_vertex * cos_receiver / square
            specular = 0.0
            if ks > 0.0:
                cos_alpha = (dx * mx + dy * my + dz * mz) / distance
                specular = min(math.pi * lobe(n, cos_alpha) * kernel, bound)
                if kd <= 0.0 and specular <= 0.0:
                    continue
            diffuse = min(kernel, bound) if kd > 0.0 else 0.0
            chance = _chance(flux[i] * (kd * diffuse + ks * specular), cos_receiver, threshold[r])
            if chance < 1.0:
                passed[r] += chance
                if passed[r] < 1.0:
                    continue
                passed[r] -= 1.0
            out_vertex[count] = i
            out_receiver[count] = r
            out_diffuse[count] = diffuse / (math.pi * cos_receiver * chance)
            out_specular[count] = specular / (math.pi * cos_receiver * chance)
            ex, ey, ez = _scaled(
                at[r, 0],
                at[r, 1],
                at[r, 2],
                at_normals[r, 0],
                at_normals[r, 1],
                at_normals[r, 2],
                offset,
                centre,
                scale,
            )
            out_origins[count, 0], out_origins[count, 1], out_origins[count, 2] = ox, oy, oz
            out_segments[count, 0], out_segments[count, 1], out_segments[count, 2] = ex - ox, ey - oy, ez - oz
            count += 1
    return count


@njit(**LEAF)
def _scaled(
    x: float,
    y: float,
    z: float,
    nx: float,
    ny: float,
    nz: float,
    offset: float,
    centre: FloatArray,
    scale: float,
) -> Vector:
    """Put a surface point, moved off its surface, in embree's coordinates."""
    return (
        (x + offset * nx - centre[0]) * scale,
        (y + offset * ny - centre[1]) * scale,
        (z + offset * nz - centre[2]) * scale,
    )


@njit(**LEAF)
def _chance(light: float, cos_receiver: float, threshold: float) -> float:
    """Chance that a pair is kept whose light, times pi, is given; see `Thinning`.

    Grazing light counts for more than its illuminance: for the light vector, and where gloss reflects it.
    """
    raised = light * max(cos_receiver, LEAST_COSINE) / cos_receiver
    return min(1.0, raised / (math.pi * threshold)) if threshold > 0.0 else 1.0


def _gather(
    moments: FloatArray,
    receivers: Receivers,
    vertices: ChainVertices,
    pairs: _Pairs,
    clear: IntArray,
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
    clear: IntArray,
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
    for k in clear:
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
    receivers: Receivers, vertices: ChainVertices, pairs: _Pairs, clear: IntArray, world: World
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
