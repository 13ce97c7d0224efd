"""Pairs of a chain vertex and a receiver that may exchange light: their bounded kernel and their shadow ray."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
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
    off_surfaces: tuple[Float32Array, Float32Array],
    room: Pairs | None = None,
) -> Pairs:
    """Look at all pairs of the receivers and a chunk of the vertices, and keep those that can exchange light.

    Weak ones are thinned out, see `Thinning`.

    Parameters
    ----------
    off_surfaces : what `off_surfaces` gives
    room : written over, for as many pairs as there may be; memory that is new costs as much as what is done with it
    """
    number = np.arange(len(vertices))[chunk]
    pairs = room or Pairs.room_for(len(number) * len(receivers))
    starts, ends = off_surfaces
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
        starts,
        ends,
        thinning.strengths[0],
        thinning.strengths[1],
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
    starts, ends = off_surfaces(world, vertices, receivers)
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
        starts,
        ends,
        pairs.vertex,
        pairs.receiver,
        pairs.diffuse,
        pairs.specular,
        pairs.origins,
        pairs.segments,
    )
    return pairs.first(count)


def off_surfaces(
    world: World, vertices: ChainVertices, receivers: Receivers
) -> tuple[Float32Array, Float32Array]:
    """Put starts (v, 3) and ends (r, 3) of shadow rays in embree's coordinates."""
    caster = world.caster
    starts = caster.in_unit_cube(caster.leave(vertices.points, vertices.normals))
    return starts, caster.in_unit_cube(caster.leave(receivers.points, receivers.normals))


@njit(**COMPILED)
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
    starts: Float32Array,
    ends: Float32Array,
    by_diffuse: FloatArray,
    by_specular: FloatArray,
    threshold: FloatArray,
    passed: FloatArray,
    out_vertex: IntArray,
    out_receiver: IntArray,
    out_diffuse: FloatArray,
    out_specular: FloatArray,
    out_origins: Float32Array,
    out_segments: Float32Array,
) -> int:
    kernels, cosines = np.empty(len(at)), np.empty(len(at))
    facing = np.empty(len(at), dtype=np.int64)
    x, y, z = at[:, 0].copy(), at[:, 1].copy(), at[:, 2].copy()
    u, v, w = at_normals[:, 0].copy(), at_normals[:, 1].copy(), at_normals[:, 2].copy()
    count = 0
    for i in number:
        m = materials[i]
        kd = reflectances.diffuse_share[m] if lobes[i] & DIFFUSE_LOBE else 0.0
        ks = reflectances.specular_share[m] if lobes[i] & SPECULAR_LOBE else 0.0
        if kd + ks <= 0.0:
            continue
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        # Without branches, so that several receivers are done at a time.
        for r in range(len(at)):
            dx, dy, dz = x[r] - px, y[r] - py, z[r] - pz
            square = dx * dx + dy * dy + dz * dz
            distance = math.sqrt(square)
            cosine = -(dx * u[r] + dy * v[r] + dz * w[r]) / distance
            cosine = cosine if on_surface[r] else 1.0
            along = dx * nx + dy * ny + dz * nz
            both = (along > 0.0) & (cosine > 0.0)
            kernels[r] = along * cosine / (square * distance) if both else 0.0
            cosines[r] = cosine
        faced = 0
        for r in range(len(at)):
            facing[faced] = r
            faced += kernels[r] > 0.0
        n = reflectances.exponent[m]
        mx, my, mz = mirrored(incoming[i, 0], incoming[i, 1], incoming[i, 2], nx, ny, nz)
        for r in facing[:faced]:
            kernel, cos_receiver = kernels[r], cosines[r]
            specular = 0.0
            if ks > 0.0:
                dx, dy, dz = x[r] - px, y[r] - py, z[r] - pz
                cos_alpha = (dx * mx + dy * my + dz * mz) / math.sqrt(dx * dx + dy * dy + dz * dz)
                specular = min(math.pi * lobe(n, cos_alpha) * kernel, bound)
                if kd <= 0.0 and specular <= 0.0:
                    continue
            diffuse = min(kernel, bound) if kd > 0.0 else 0.0
            chance = _chance(by_diffuse[i] * diffuse + by_specular[i] * specular, cos_receiver, threshold[r])
            if chance < 1.0:
                passed[r] += chance
                if passed[r] < 1.0:
                    continue
                passed[r] -= 1.0
            out_vertex[count] = i
            out_receiver[count] = r
            out_diffuse[count] = diffuse / (math.pi * cos_receiver * chance)
            out_specular[count] = specular / (math.pi * cos_receiver * chance)
            for axis in range(3):
                out_origins[count, axis] = starts[i, axis]
                out_segments[count, axis] = ends[r, axis] - starts[i, axis]
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
    starts: Float32Array,
    ends: Float32Array,
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
        for axis in range(3):
            out_origins[count, axis] = starts[i, axis]
            out_segments[count, axis] = ends[r, axis] - starts[i, axis]
        count += 1
    return count
