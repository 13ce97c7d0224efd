"""Paths from the receiver's side: what a surface reflects toward the point that looks at it.

A path goes from surface to surface; at each it draws a source (next-event estimation) and a lobe to go on
with. The Lambertian lobe takes its direct light from the drawn source only; the Phong lobe combines it with
what its own direction meets, by the balance heuristic (Veach & Guibas 1995).

The first surface may be split: of its kernel only the part above a bound counts, max(0, 1 - b/G) for the
Lambertian lobe and max(0, 1 - b/(pi lobe G)) for the Phong lobe. The rest is the chains' (`local`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.estimate.split import above, lobe_probability, lobe_shares
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.drawing import (
    LOCAL_CHOICE_LIMIT,
    chosen,
    drawn_density,
    rough_cdfs,
    shines,
    source_housing,
    source_strength,
    toward_face,
)
from lelight.tracing.emitters import Emitters
from lelight.tracing.lamps import toward_lamp
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

_COMPILED = {"cache": True, "nogil": True, "error_model": "numpy"}

#: Uniform numbers that one surface of a path uses: source, place (2), lobe, direction (2), roulette.
NUMBERS = 7
LONGEST_PATH = 10_000
#: Paths for which the choice of sources is laid out at once; bounds memory, does not change results.
PATHS_AT_ONCE = 256


@dataclass(frozen=True)
class Paths:
    """k paths under way, each at a surface that it has just met.

    Attributes
    ----------
    number : (k,) int, which of the caller's rays the path belongs to
    points, normals : (k, 3) float; the normal on the side that was met
    outgoing : (k, 3) float, unit, back toward where the path came from
    materials, triangles : (k,) int
    throughput : (k, C) float
    geometry : (k,) float, 1/m²; G between the surface and the point looked from, inf where nothing is split
    """

    number: IntArray
    points: FloatArray
    normals: FloatArray
    outgoing: FloatArray
    materials: IntArray
    triangles: IntArray
    throughput: FloatArray
    geometry: FloatArray

    @classmethod
    def at(cls, points: FloatArray, normals: FloatArray, *, channels: int) -> Paths:
        """Stand at surface points (k, 3) whose material does not matter, looking along the normals."""
        none = np.zeros(len(points), dtype=np.int64)
        ones = np.ones((len(points), channels))
        return cls(
            np.arange(len(points)), points, normals, normals, none, none, ones, np.full(len(points), np.inf)
        )


def meet(
    world: World, number: IntArray, origins: FloatArray, directions: FloatArray, throughput: FloatArray
) -> tuple[Paths, IntArray]:
    """Follow rays to surfaces; returns the paths there and which of the rays they are."""
    hits = world.caster.closest(origins, directions)
    kept = np.flatnonzero(hits.triangle >= 0)
    triangles = hits.triangle[kept]
    paths = Paths(
        number=number[kept],
        points=hits.points[kept],
        normals=hits.normals[kept],
        outgoing=-directions[kept],
        materials=world.materials[triangles],
        triangles=triangles,
        throughput=throughput[kept],
        geometry=np.full(len(kept), np.inf),
    )
    return paths, kept


def chosen_paths(paths: Paths, kept: IntArray) -> Paths:
    """Keep some of the paths."""
    return Paths(
        paths.number[kept],
        paths.points[kept],
        paths.normals[kept],
        paths.outgoing[kept],
        paths.materials[kept],
        paths.triangles[kept],
        paths.throughput[kept],
        paths.geometry[kept],
    )


def reflected_radiance(
    world: World, paths: Paths, *, bound: float, numbers: FloatArray, identity: IntArray, key: np.uint64
) -> tuple[FloatArray, int]:
    """Radiance (k, C) in cd/m² that paths bring to the rays they started as, and the rays traced.

    Parameters
    ----------
    paths : at their first surfaces
    bound : float, 1/m²; b of the split at those, 0 for all of what they reflect
    numbers : (len(paths), 7) float in [0, 1), for the first surface
    identity : (k,) int, of the rays; with ``key`` it gives the random numbers of later surfaces
    """
    radiance = np.zeros((len(identity), world.channels))
    rays = 0
    for depth in range(LONGEST_PATH):
        if not len(paths.number):
            break
        paths, traced = step(world, paths, bound=bound, numbers=numbers, radiance=radiance, roulette=True)
        rays += traced
        bound = 0.0
        numbers = hashed_numbers(key, identity[paths.number], depth + 1)
    return radiance, rays


def step(
    world: World, paths: Paths, *, bound: float, numbers: FloatArray, radiance: FloatArray, roulette: bool
) -> tuple[Paths, int]:
    """Light each path's surface directly, add it to ``radiance`` (k, C), and go on to the next surface.

    Returns
    -------
    paths : at the surfaces met next; without ``roulette`` only absorption ends a path
    rays : int
    """
    rays = _add_drawn_sources(world, paths, bound, numbers, radiance)
    origins, directions, throughput, density, going = _go_on(world, paths, bound, numbers, roulette)
    here = chosen_paths(paths, going)
    met, kept = meet(world, here.number, origins, directions, throughput)
    _add_met_emitters(world, chosen_paths(here, kept), met, density[kept], radiance)
    return met, rays + len(going)


def hashed_numbers(key: np.uint64, identity: IntArray, depth: int) -> FloatArray:
    """Uniform numbers (k, 7) for surface ``depth`` of the paths that carry ``identity`` (k,)."""
    numbers = np.empty((len(identity), NUMBERS))
    _fill(key, identity, depth, numbers)
    return numbers


@njit(**_COMPILED)
def _fill(key: np.uint64, identity: IntArray, depth: int, out: FloatArray) -> None:
    for k in range(len(identity)):
        own = mix(mix(key, np.uint64(identity[k])), np.uint64(depth))
        for d in range(out.shape[1]):
            out[k, d] = uniform(own, np.uint64(d))


@njit(**_COMPILED)
def rotated_numbers(table: FloatArray, key: np.uint64, identity: IntArray, out: FloatArray) -> None:
    """Write the table (s, d) once a receiver into out (r * s, d), rotated by a hash of its identity."""
    count = len(table)
    for r in range(len(identity)):
        own = mix(key, np.uint64(identity[r]))
        for d in range(out.shape[1]):
            shift = uniform(own, np.uint64(d))
            for s in range(count):
                out[r * count + s, d] = rotated(table[s, d], shift)


def _add_drawn_sources(
    world: World, paths: Paths, bound: float, numbers: FloatArray, radiance: FloatArray
) -> int:
    """Add the light of one drawn source at each path's surface; returns the shadow rays."""
    light = np.zeros_like(paths.throughput)
    origins, ends = np.empty_like(paths.points), np.empty_like(paths.points)
    housing = np.zeros(len(paths.points), dtype=np.int64)
    _draw_sources(
        world.emitters,
        world.reflectances,
        paths.points,
        paths.normals,
        paths.outgoing,
        paths.materials,
        paths.throughput,
        paths.geometry,
        bound,
        numbers,
        world.caster.offset,
        light,
        origins,
        ends,
        housing,
    )
    lit = np.flatnonzero(light.max(axis=1) > 0.0)
    clear = lit[world.visible(origins[lit], ends[lit], housing=housing[lit])]
    np.add.at(radiance, paths.number[clear], light[clear])
    return len(lit)


@njit(**_COMPILED)
def _draw_sources(
    emitters: Emitters,
    reflectances: Reflectances,
    points: FloatArray,
    normals: FloatArray,
    outgoing: FloatArray,
    materials: IntArray,
    throughput: FloatArray,
    geometry: FloatArray,
    bound: float,
    numbers: FloatArray,
    offset: float,
    light: FloatArray,
    origins: FloatArray,
    ends: FloatArray,
    housing: IntArray,
) -> None:
    corners, faces, areas, both_sides = (
        emitters.corners,
        emitters.normals,
        emitters.areas,
        emitters.both_sides,
    )
    triangles = len(corners)
    # Among very many sources the choice is the same at every place: one row serves all.
    everywhere = len(emitters.power) > LOCAL_CHOICE_LIMIT
    cdfs = np.empty((1 if everywhere else min(PATHS_AT_ONCE, len(points)), len(emitters.power)))
    for k in range(len(points)):
        row = 0 if everywhere else k % PATHS_AT_ONCE
        if row == 0 and (k == 0 or not everywhere):
            last = min(k + len(cdfs), len(points))
            rough_cdfs(emitters, points[k:last], normals[k:last], cdfs)
        cdf = cdfs[row]
        m = materials[k]
        share_d, share_s = lobe_shares(reflectances, m, bound, geometry[k])
        p_diffuse = lobe_probability(reflectances, m, share_d, share_s)
        if p_diffuse < 0.0 or not cdf[-1] > 0.0:
            continue
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        nx, ny, nz = normals[k, 0], normals[k, 1], normals[k, 2]
        source, share = chosen(cdf, numbers[k, 0])
        u, v = numbers[k, 1], numbers[k, 2]
        if source < triangles:
            d, end, factor, density = toward_face(
                corners, faces, areas, both_sides, source, x, y, z, u, v, offset
            )
        else:
            d, end, factor, density = toward_lamp(emitters, source - triangles, x, y, z, u, v, offset)
        cos_theta = d[0] * nx + d[1] * ny + d[2] * nz
        if factor <= 0.0 or cos_theta <= 0.0:
            continue
        n = reflectances.exponent[m]
        ax, ay, az = mirrored(outgoing[k, 0], outgoing[k, 1], outgoing[k, 2], nx, ny, nz)
        cos_alpha = d[0] * ax + d[1] * ay + d[2] * az
        peak = lobe(n, cos_alpha)
        phong = peak * above(bound, math.pi * peak * geometry[k])
        if phong > 0.0 and density > 0.0:
            drawn = share * density
            phong *= drawn / (drawn + (1.0 - p_diffuse) * lobe_density(n, cos_alpha))
        for c in range(light.shape[1]):
            reflected = reflectances.diffuse[m, c] * share_d / math.pi + reflectances.specular[m, c] * phong
            strength = source_strength(emitters, source, c) * factor / share
            light[k, c] = throughput[k, c] * strength * cos_theta * reflected
        housing[k] = source_housing(emitters, source)
        for axis in range(3):
            origins[k, axis] = points[k, axis] + offset * normals[k, axis]
            ends[k, axis] = end[axis]


def _go_on(
    world: World, paths: Paths, bound: float, numbers: FloatArray, roulette: bool
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
        directions,
        throughput,
        density,
        going,
    )
    kept = np.flatnonzero(going)
    origins = world.caster.leave(paths.points[kept], paths.normals[kept])
    return origins, directions[kept], throughput[kept], density[kept], kept


@njit(**_COMPILED)
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
        if numbers[k, 3] < p_diffuse:
            x, y, z = cosine_direction(numbers[k, 4], numbers[k, 5])
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
        before, after = 0.0, 0.0
        for c in range(channels):
            before += weights[c] * throughput[k, c]
            after += weights[c] * onward[k, c]
        if not after > 0.0:
            continue
        survival = min(1.0, after / before) if roulette else 1.0
        if numbers[k, 6] < survival:
            going[k] = True
            for c in range(channels):
                onward[k, c] /= survival


def _add_met_emitters(
    world: World, left: Paths, met: Paths, density: FloatArray, radiance: FloatArray
) -> None:
    """Add emission that Phong lobes met by themselves, weighted against drawing the same source."""
    _weigh_met_emitters(
        world.emitters,
        left.points,
        left.normals,
        met.outgoing,
        met.triangles,
        met.throughput,
        density,
        met.number,
        radiance,
    )


@njit(**_COMPILED)
def _weigh_met_emitters(
    emitters: Emitters,
    points: FloatArray,
    normals: FloatArray,
    back: FloatArray,
    triangles: IntArray,
    throughput: FloatArray,
    density: FloatArray,
    number: IntArray,
    radiance: FloatArray,
) -> None:
    cdf = np.empty((1, len(emitters.power)))
    for k in range(len(points)):
        source = emitters.of_triangle[triangles[k]]
        if density[k] <= 0.0 or source < 0:
            continue
        d = (-back[k, 0], -back[k, 1], -back[k, 2])
        if not shines(emitters, source, d):
            continue
        rough_cdfs(emitters, points[k : k + 1], normals[k : k + 1], cdf)
        drawn = 0.0
        if cdf[0, -1] > 0.0:
            drawn = drawn_density(emitters, cdf[0], source, points[k, 0], points[k, 1], points[k, 2], d)
        weight = density[k] / (density[k] + drawn)
        for c in range(radiance.shape[1]):
            radiance[number[k], c] += weight * throughput[k, c] * emitters.luminance[source, c]
