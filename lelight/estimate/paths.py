"""Paths from the receiver's side: what a surface reflects toward the point that looks at it.

A path goes from surface to surface; at each it takes the light of a drawn source (`pathlight`) and draws a lobe
to go on with. The surface that it starts at may be split: of its kernel only the part above a bound counts,
max(0, 1 - b/G) for the Lambertian lobe and max(0, 1 - b/(pi lobe G)) for the Phong lobe. The rest is the chains'
(`local`).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numba import njit

from lelight.compilation import LEAF
from lelight.estimate.guide import Guide, guided, tables
from lelight.estimate.pathends import END_NUMBERS, PathEnds, add_drawn_vertices, bounded_base, taken_up
from lelight.estimate.pathlight import add_drawn_sources, add_met_emitters
from lelight.estimate.pathstate import Paths, chosen_paths, kernel_between, meet
from lelight.estimate.split import above, lobe_probability, lobe_shares
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.rays import Float32Array
from lelight.tracing.reflection import Reflectances, lobe, lobe_density
from lelight.tracing.sampling import (
    cosine_direction,
    lobe_direction,
    mirrored,
    mix,
    rotated,
    to_axis,
    uniform,
)
from lelight.tracing.world import World

#: Uniform numbers that one surface of a path uses: source, place (2), lobe, direction (2), roulette.
NUMBERS = 7
LONGEST_PATH = 10_000
#: Paths that carry less than this share of a ray's light are ended by Russian roulette, or brought up to it.
LEAST_THROUGHPUT = 0.25


def reflected_radiance(
    world: World,
    paths: Paths,
    *,
    bound: float,
    numbers: FloatArray,
    identity: IntArray,
    key: np.uint64,
    ends: PathEnds | None = None,
    guide: Guide | None = None,
) -> tuple[FloatArray, int]:
    """Radiance (k, C) in cd/m² that paths bring to the rays they started as, and the rays traced.

    Parameters
    ----------
    paths : at their first surfaces
    bound : float, 1/m²; b of the split at those, 0 for all of what they reflect
    numbers : (len(paths), NUMBERS + END_NUMBERS) float in [0, 1), for the first surface
    identity : (k,) int, of the rays; with ``key`` it gives the random numbers of later surfaces
    ends : what paths end on; without it they go on until they are absorbed
    guide : leads Lambertian reflection where paths know their row of it
    """
    radiance = np.zeros((len(identity), world.channels))
    rays = 0
    for depth in range(LONGEST_PATH):
        if ends is not None:
            kept = taken_up(world, paths, bound, numbers[:, NUMBERS + 2])
            paths, numbers = chosen_paths(paths, kept), numbers.take(kept, axis=0)
            rays += add_drawn_vertices(world, paths, ends, bound, numbers[:, NUMBERS:], radiance)
        if not len(paths.number):
            break
        paths, traced = step(
            world, paths, bound=bound, numbers=numbers, radiance=radiance, roulette=True, guide=guide
        )
        rays += traced
        bound = 0.0 if ends is None else ends.bound
        if ends is not None:
            below, paths = bounded_base(world, ends.base, paths, bound)
            radiance[paths.number] += paths.throughput * below
        numbers = hashed_numbers(key, identity[paths.number], depth + 1)
    return radiance, rays


def step(
    world: World,
    paths: Paths,
    *,
    bound: float,
    numbers: FloatArray,
    radiance: FloatArray,
    roulette: bool,
    guide: Guide | None = None,
) -> tuple[Paths, int]:
    """Light each path's surface directly, add it to ``radiance`` (k, C), and go on to the next surface.

    Returns
    -------
    paths : at the surfaces met next, with the kernel G to them where a Lambertian lobe led there and inf where a
        Phong lobe did; without ``roulette`` only absorption ends a path
    rays : int
    """
    rays = add_drawn_sources(world, paths, bound, numbers, radiance)
    origins, directions, throughput, density, going = _go_on(world, paths, bound, numbers, roulette, guide)
    met, kept = meet(world, paths.number[going], origins, directions, throughput)
    left = going[kept]
    if density.any():
        add_met_emitters(world, chosen_paths(paths, left), met, density[kept], radiance)
    cosines = -np.einsum("kx,kx->k", met.outgoing, paths.normals.take(left, axis=0))
    kernel = kernel_between(paths.points.take(left, axis=0), cosines, met)
    return replace(met, geometry=np.where(density[kept] > 0.0, np.inf, kernel)), rays + len(going)


def hashed_numbers(key: np.uint64, identity: IntArray, depth: int) -> FloatArray:
    """Uniform numbers (k, n) for surface ``depth`` of the paths that carry ``identity`` (k,)."""
    numbers = np.empty((len(identity), NUMBERS + END_NUMBERS))
    _fill(key, identity, depth, numbers)
    return numbers


@njit(**LEAF)
def _fill(key: np.uint64, identity: IntArray, depth: int, out: FloatArray) -> None:
    for k in range(len(identity)):
        own = mix(mix(key, np.uint64(identity[k])), np.uint64(depth))
        for d in range(out.shape[1]):
            out[k, d] = uniform(own, np.uint64(d))


@njit(**LEAF)
def rotated_numbers(table: FloatArray, key: np.uint64, identity: IntArray, out: FloatArray) -> None:
    """Write the table (s, d) once a receiver into out (r * s, d), rotated by a hash of its identity."""
    count = len(table)
    for r in range(len(identity)):
        own = mix(key, np.uint64(identity[r]))
        for d in range(out.shape[1]):
            shift = uniform(own, np.uint64(d))
            for s in range(count):
                out[r * count + s, d] = rotated(table[s, d], shift)


def _go_on(
    world: World, paths: Paths, bound: float, numbers: FloatArray, roulette: bool, guide: Guide | None
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, IntArray]:
    """Reflect paths: origins, directions, throughput and lobe density of those that go on, named last."""
    directions = np.empty_like(paths.points)
    throughput = np.zeros_like(paths.throughput)
    density = np.zeros(len(paths.number))
    going = np.zeros(len(paths.number), dtype=np.bool_)
    _reflect_back(
        world.reflectances,
        paths.normals,
        paths.outgoing,
        paths.materials,
        paths.throughput,
        paths.geometry,
        bound,
        numbers,
        world.emitters.weights,
        roulette,
        paths.rows,
        *tables(guide),
        directions,
        throughput,
        density,
        going,
    )
    kept = np.flatnonzero(going)
    origins = world.caster.leave(paths.points.take(kept, axis=0), paths.normals.take(kept, axis=0))
    return origins, directions.take(kept, axis=0), throughput.take(kept, axis=0), density[kept], kept


@njit(**LEAF)
def _reflect_back(
    reflectances: Reflectances,
    normals: FloatArray,
    outgoing: FloatArray,
    materials: IntArray,
    throughput: FloatArray,
    geometry: FloatArray,
    bound: float,
    numbers: FloatArray,
    weights: FloatArray,
    roulette: bool,
    rows: IntArray,
    density_by_cell: Float32Array,
    rings: Float32Array,
    directions: FloatArray,
    onward: FloatArray,
    density: FloatArray,
    going: BoolArray,
) -> None:
    channels = throughput.shape[1]
    for k in range(len(normals)):
        m = materials[k]
        share_d, share_s = lobe_shares(reflectances, m, bound, geometry[k])
        p_diffuse = lobe_probability(reflectances, m, share_d, share_s)
        if p_diffuse < 0.0:
            continue
        nx, ny, nz = normals[k, 0], normals[k, 1], normals[k, 2]
        lead = 1.0
        if numbers[k, 3] < p_diffuse:
            u, v, lead = guided(density_by_cell, rings, rows[k], numbers[k, 4], numbers[k, 5])
            x, y, z = cosine_direction(u, v)
            dx, dy, dz = to_axis(x, y, z, nx, ny, nz)
            for c in range(channels):
                onward[k, c] = throughput[k, c] * reflectances.diffuse[m, c] * share_d / p_diffuse
        else:
            n = reflectances.exponent[m]
            x, y, z = lobe_direction(numbers[k, 4], numbers[k, 5], n)
            ax, ay, az = mirrored(outgoing[k, 0], outgoing[k, 1], outgoing[k, 2], nx, ny, nz)
            dx, dy, dz = to_axis(x, y, z, ax, ay, az)
            cos_theta = max(0.0, dx * nx + dy * ny + dz * nz)
            share = above(bound, math.pi * lobe(n, z) * geometry[k])
            factor = (n + 2.0) / (n + 1.0) * cos_theta * share / (1.0 - p_diffuse)
            density[k] = (1.0 - p_diffuse) * lobe_density(n, z)
            for c in range(channels):
                onward[k, c] = throughput[k, c] * reflectances.specular[m, c] * factor
        directions[k, 0], directions[k, 1], directions[k, 2] = dx, dy, dz
        carried = 0.0
        for c in range(channels):
            carried += weights[c] * onward[k, c]
        if not carried > 0.0:
            continue
        # By what it carries before it is led: where light is expected it carries less for that, and is as good.
        survival = min(1.0, carried / LEAST_THROUGHPUT) if roulette else 1.0
        if numbers[k, 6] < survival:
            going[k] = True
            for c in range(channels):
                onward[k, c] /= survival * lead
