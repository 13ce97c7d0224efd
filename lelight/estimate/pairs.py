"""Pairs of a chain vertex and a receiver that may exchange light: their bounded kernel and their shadow ray."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.compilation import LEAF
from lelight.estimate.thinning import Thinning
from lelight.receivers import Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import DIFFUSE_LOBE, SPECULAR_LOBE, ChainVertices
from lelight.tracing.rays import Float32Array
from lelight.tracing.reflection import Reflectances, lobe
from lelight.tracing.sampling import mirrored
from lelight.tracing.world import World

#: Least cosine at a receiver that the chance of a pair goes by.
LEAST_COSINE = 0.2


@dataclass(frozen=True)
class Pairs:
    """Some pairs.

    Attributes
    ----------
    vertex, receiver : (k,) int
    diffuse, specular : (k,) float, 1/(m² sr); bounded kernel of either lobe over pi and over the receiver's cosine, and
        over the chance that the pair was kept
    origins, segments : (k, 3) float32, of the shadow ray in embree's coordinates
    """

    vertex: IntArray
    receiver: IntArray
    diffuse: FloatArray
    specular: FloatArray
    origins: Float32Array
    segments: Float32Array

    @classmethod
    def room_for(cls, count: int) -> Pairs:
        """Make room for so many."""
        return cls(
            vertex=np.empty(count, dtype=np.int64),
            receiver=np.empty(count, dtype=np.int64),
            diffuse=np.empty(count),
            specular=np.empty(count),
            origins=np.empty((count, 3), dtype=np.float32),
            segments=np.empty((count, 3), dtype=np.float32),
        )

    def first(self, count: int) -> Pairs:
        """Keep the first of them."""
        return Pairs(**{name: column[:count] for name, column in vars(self).items()})


def scanned_pairs(
    world: World,
    receivers: Receivers,
    vertices: ChainVertices,
    chunk: slice,
    *,
    bound: float,
    thinning: Thinning,
) -> Pairs:
    """Look at all pairs of the receivers and a chunk of the vertices, and keep those that can exchange light.

    Weak ones are thinned out, see `Thinning`.
    """
    number = np.arange(len(vertices))[chunk]
    pairs = Pairs.room_for(len(number) * len(receivers))
    caster = world.caster
    count = _scan(
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
    return pairs.first(count)


def drawn_pairs(
    world: World,
    receivers: Receivers,
    vertices: ChainVertices,
    *,
    drawn: tuple[IntArray, IntArray, FloatArray],
    bound: float,
) -> Pairs:
    """Take pairs that were drawn, vertex and receiver (k,) with their chances (k,), and keep those that exchange light.

    Only Lambertian lobes are looked at.
    """
    vertex, receiver, chances = drawn
    pairs = Pairs.room_for(len(vertex))
    caster = world.caster
    count = _take(
        vertex,
        receiver,
        chances,
        vertices.points,
        vertices.normals,
        receivers.points,
        receivers.normals,
        receivers.on_surface,
        bound,
        caster.centre,
        caster.scale,
        caster.offset,
        pairs.vertex,
        pairs.receiver,
        pairs.diffuse,
        pairs.specular,
        pairs.origins,
        pairs.segments,
    )
    return pairs.first(count)


@njit(**LEAF)
def _scan(
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
        for r in range(len(at)):
            dx, dy, dz = at[r, 0] - px, at[r, 1] - py, at[r, 2] - pz
            cos_vertex = dx * nx + dy * ny + dz * nz
            if cos_vertex <= 0.0:
                continue
            square = dx * dx + dy * dy + dz * dz
            distance = math.sqrt(square)
            cos_receiver = 1.0
            if on_surface[r]:
                along = dx * at_normals[r, 0] + dy * at_normals[r, 1] + dz * at_normals[r, 2]
                cos_receiver = -along / distance
                if cos_receiver <= 0.0:
                    continue
            kernel = cos_vertex * cos_receiver / (distance * square)
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
            _write_ray(
                count, points, normals, i, at, at_normals, r, centre, scale, offset, out_origins, out_segments
            )
            count += 1
    return count


@njit(**LEAF)
def _chance(light: float, cos_receiver: float, threshold: float) -> float:
    """Chance that a pair is kept whose light, times pi, is given; see `Thinning`.

    Grazing light counts for more than its illuminance: for the light vector, and where gloss reflects it.
    """
    raised = light * max(cos_receiver, LEAST_COSINE) / cos_receiver
    return min(1.0, raised / (math.pi * threshold)) if threshold > 0.0 else 1.0


@njit(**LEAF)
def _take(
    vertex: IntArray,
    receiver: IntArray,
    chances: FloatArray,
    points: FloatArray,
    normals: FloatArray,
    at: FloatArray,
    at_normals: FloatArray,
    on_surface: BoolArray,
    bound: float,
    centre: FloatArray,
    scale: float,
    offset: float,
    out_vertex: IntArray,
    out_receiver: IntArray,
    out_diffuse: FloatArray,
    out_specular: FloatArray,
    out_origins: Float32Array,
    out_segments: Float32Array,
) -> int:
    count = 0
    for k in range(len(vertex)):
        i, r = vertex[k], receiver[k]
        dx, dy, dz = at[r, 0] - points[i, 0], at[r, 1] - points[i, 1], at[r, 2] - points[i, 2]
        square = dx * dx + dy * dy + dz * dz
        distance = math.sqrt(square)
        cos_vertex = (dx * normals[i, 0] + dy * normals[i, 1] + dz * normals[i, 2]) / distance
        cos_receiver = 1.0
        if on_surface[r]:
            along = dx * at_normals[r, 0] + dy * at_normals[r, 1] + dz * at_normals[r, 2]
            cos_receiver = -along / distance
        if not (cos_vertex > 0.0 and cos_receiver > 0.0):
            continue
        out_vertex[count] = i
        out_receiver[count] = r
        kernel = min(cos_vertex * cos_receiver / square, bound)
        out_diffuse[count] = kernel / (math.pi * cos_receiver * chances[k])
        out_specular[count] = 0.0
        _write_ray(
            count, points, normals, i, at, at_normals, r, centre, scale, offset, out_origins, out_segments
        )
        count += 1
    return count


@njit(**LEAF)
def _write_ray(
    row: int,
    points: FloatArray,
    normals: FloatArray,
    i: int,
    at: FloatArray,
    at_normals: FloatArray,
    r: int,
    centre: FloatArray,
    scale: float,
    offset: float,
    origins: Float32Array,
    segments: Float32Array,
) -> None:
    """Write the shadow ray from vertex ``i`` to receiver ``r``, both off their surfaces."""
    for axis in range(3):
        start = (points[i, axis] + offset * normals[i, axis] - centre[axis]) * scale
        end = (at[r, axis] + offset * at_normals[r, axis] - centre[axis]) * scale
        origins[row, axis] = start
        segments[row, axis] = end - start
