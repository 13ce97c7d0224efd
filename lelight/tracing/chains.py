"""Chains: random walks of light, the Markov chain of equation (16).

At every surface that a chain meets it leaves a vertex: a place with the light that arrives there. Each vertex
then lights every node it sees; that is the local estimate. Chains begin at the emitters (`emission_chains`),
or wherever else light is known to be missing (`estimate.defect`), and all go on alike (`walk_on`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.emitters import Emitters
from lelight.tracing.lamps import emitted_ray
from lelight.tracing.reflection import Reflectances, diffuse_probability
from lelight.tracing.sampling import cosine_direction, lobe_direction, mirrored, mix, to_axis, uniform
from lelight.tracing.sobol import Stretch, sobol
from lelight.tracing.world import World

#: Dimensions of the Sobol points: what to start from, place (2), direction (2), then lobe and direction (3) a
#: reflection.
START_DIMENSIONS = 5
REFLECTION_DIMENSIONS = 3
#: Reflections that the Sobol points serve; later ones draw from a hash.
SOBOL_REFLECTIONS = 8
#: Reflections that every chain makes, with its weight reduced; afterwards Russian roulette decides.
CERTAIN_REFLECTIONS = 2
#: No chain is longer; with the roulette at albedo 0.995 fewer than one in e^50 would be.
LONGEST_CHAIN = 10_000


#: Which lobes of its surface a vertex reflects with.
DIFFUSE_LOBE, SPECULAR_LOBE, BOTH_LOBES = 1, 2, 3


@dataclass(frozen=True)
class ChainVertices:
    """Where chains met surfaces, bounce by bounce.

    Attributes
    ----------
    points, normals : (v, 3) float, m; the normal on the side that was hit
    incoming : (v, 3) float, unit, pointing back to where the light came from
    flux : (v, C) float, lm that the vertex stands for, arriving; negative where light is to be taken away
    materials, triangles : (v,) int
    front : (v,) bool, True where the front of the triangle was hit
    lobes : (v,) int, which lobes reflect: Lambertian, Phong or both
    """

    points: FloatArray
    normals: FloatArray
    incoming: FloatArray
    flux: FloatArray
    materials: IntArray
    triangles: IntArray
    front: BoolArray
    lobes: IntArray

    def __len__(self) -> int:
        """Count vertices."""
        return len(self.points)

    def __getitem__(self, chosen: IntArray | BoolArray) -> ChainVertices:
        """Select some of them."""
        return ChainVertices(**{name: column[chosen] for name, column in vars(self).items()})

    def with_flux(self, flux: FloatArray) -> ChainVertices:
        """Copy them with other flux (v, C), lm."""
        return replace(self, flux=flux)

    def with_lobes(self, lobes: int) -> ChainVertices:
        """Copy them reflecting by ``lobes`` only."""
        return replace(self, lobes=np.full(len(self), lobes))


def emission_chains(
    world: World, chains: Stretch, *, seed: tuple[int, ...], nodes: int | None = None
) -> ChainVertices:
    """Send a stretch of chains out of the emitters until all have died or left.

    The flux of the vertices is normalised: one call is one unbiased estimate. Every vertex's weight is its
    flux over the number of chains, divided by all probabilities of getting there.

    Parameters
    ----------
    seed : integers that fix every random number of the walk
    nodes : vertices after which a chain is cut off; None to let it die by itself
    """
    points = chain_numbers(chains, seed=seed)
    origins, directions, flux = emit(world.emitters, points, world.caster.offset)
    housing = emitted_housings(world.emitters, points)
    first, alive = arrive(world, origins, directions, flux / len(points), housing=housing)
    return walk_on(world, first, chain=alive, points=points, seed=(*seed, chains.first), nodes=nodes)


def chain_numbers(chains: Stretch, *, seed: tuple[int, ...]) -> FloatArray:
    """Quasi-random numbers of a stretch of chains (k, 29): what and where to start, then the reflections."""
    return sobol(START_DIMENSIONS + SOBOL_REFLECTIONS * REFLECTION_DIMENSIONS, chains, seed=seed)


def walk_on(
    world: World,
    first: ChainVertices,
    *,
    chain: IntArray,
    points: FloatArray,
    seed: tuple[int, ...],
    nodes: int | None = None,
) -> ChainVertices:
    """Let chains go on from their first vertices; returns those and all later ones.

    Parameters
    ----------
    chain : (v,) int, row of ``points`` that serves each chain
    points : (k, 5 + 24) float, quasi-random numbers in [0, 1), of which the first five are spent
    seed : fixes the numbers of later reflections and of the roulette; not the same for two stretches
    nodes : vertices of a chain at the most
    """
    key = hash_of((*seed, 1))
    vertices = first
    bounces = [first]
    for bounce in range(LONGEST_CHAIN if nodes is None else nodes - 1):
        if not len(vertices):
            break
        directions, flux, going = _reflect(
            world.reflectances,
            vertices.normals,
            vertices.incoming,
            vertices.flux,
            vertices.materials,
            vertices.lobes,
            world.emitters.weights,
            _numbers(points, chain, bounce, key),
            bounce >= CERTAIN_REFLECTIONS,
        )
        origins = world.caster.leave(vertices.points[going], vertices.normals[going])
        vertices, alive = arrive(world, origins, directions[going], flux[going])
        chain = chain[going][alive]
        bounces.append(vertices)
    return joined(bounces)


def hash_of(seed: tuple[int, ...]) -> np.uint64:
    """Fold integers into one 64-bit key."""
    key = np.uint64(0x6C656C69)
    for number in seed:
        key = np.uint64(mix(key, np.uint64(number)))
    return key


def arrive(
    world: World,
    origins: FloatArray,
    directions: FloatArray,
    flux: FloatArray,
    *,
    housing: IntArray | None = None,
) -> tuple[ChainVertices, IntArray]:
    """Follow rays with flux (k, C) to surfaces: the vertices there, and which of the rays made them.

    Parameters
    ----------
    housing : (k,) int, which surfaces do not block each ray, see `World.closest`
    """
    hits = world.closest(origins, directions, housing=housing)
    alive = np.flatnonzero(hits.triangle >= 0)
    triangles = hits.triangle[alive]
    vertices = ChainVertices(
        points=hits.points[alive],
        normals=hits.normals[alive],
        incoming=-directions[alive],
        flux=flux[alive],
        materials=world.materials[triangles],
        triangles=triangles,
        front=hits.front[alive],
        lobes=np.full(len(alive), BOTH_LOBES),
    )
    return vertices, alive


def _numbers(points: FloatArray, chain: IntArray, bounce: int, key: np.uint64) -> FloatArray:
    """Four uniform numbers a chain (k, 4): lobe, direction (2) and roulette."""
    numbers = np.empty((len(chain), 4))
    first = START_DIMENSIONS + bounce * REFLECTION_DIMENSIONS
    if bounce < SOBOL_REFLECTIONS:
        numbers[:, :3] = points[chain, first : first + REFLECTION_DIMENSIONS]
        _fill(key, chain, bounce, numbers[:, 3:])
    else:
        _fill(key, chain, bounce, numbers)
    return numbers


@njit(**LEAF)
def _fill(key: np.uint64, chain: IntArray, bounce: int, out: FloatArray) -> None:
    for k in range(len(chain)):
        own = mix(mix(key, np.uint64(chain[k])), np.uint64(bounce))
        for d in range(out.shape[1]):
            out[k, d] = uniform(own, np.uint64(d + 4 - out.shape[1]))


@njit(**COMPILED)
def emit(emitters: Emitters, numbers: FloatArray, offset: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Emit by rows (k, 5+) of numbers: origins, directions (k, 3) and flux over probability (k, C)."""
    count = len(numbers)
    triangles = len(emitters.areas)
    channels = emitters.luminance.shape[1]
    origins = np.empty((count, 3))
    directions = np.empty((count, 3))
    flux = np.empty((count, channels))
    for k in range(count):
        u = numbers[k, 0]
        source = min(int(np.searchsorted(emitters.power_cdf, u, side="right")), len(emitters.power) - 1)
        below = emitters.power_cdf[source - 1] if source > 0 else 0.0
        share = emitters.power_cdf[source] - below
        # What is left of the number after the choice is uniform again; it decides the side.
        u = (u - below) / share
        if source >= triangles:
            p = source - triangles
            origins[k], directions[k] = emitted_ray(
                emitters, p, numbers[k, 1], numbers[k, 2], numbers[k, 3], numbers[k, 4], offset
            )
            t = emitters.tables[p]
            of_table = 4.0 * math.pi if t < 0 else emitters.distributions.flux[t]
            for c in range(channels):
                flux[k, c] = of_table * emitters.intensity[p, c] / share
            continue
        both = emitters.both_sides[source]
        side = -1.0 if both and u >= 0.5 else 1.0
        nx, ny, nz = side * emitters.normals[source]
        x, y, z = cosine_direction(numbers[k, 3], numbers[k, 4])
        directions[k] = to_axis(x, y, z, nx, ny, nz)
        root = math.sqrt(numbers[k, 1])
        wa, wb, wc = 1.0 - root, root * (1.0 - numbers[k, 2]), root * numbers[k, 2]
        for axis in range(3):
            origins[k, axis] = (
                wa * emitters.corners[source, 0, axis]
                + wb * emitters.corners[source, 1, axis]
                + wc * emitters.corners[source, 2, axis]
            )
        origins[k, 0] += offset * nx
        origins[k, 1] += offset * ny
        origins[k, 2] += offset * nz
        for c in range(channels):
            exitance = math.pi * emitters.luminance[source, c] * (2.0 if both else 1.0)
            flux[k, c] = exitance * emitters.areas[source] / share
    return origins, directions, flux


def emitted_housings(emitters: Emitters, numbers: FloatArray) -> IntArray:
    """Housing (k,) of the source that `emit` draws by each row of numbers."""
    if not np.any(emitters.housings):
        return np.zeros(len(numbers), dtype=np.int64)
    source = np.searchsorted(emitters.power_cdf, numbers[:, 0], side="right")
    point = np.minimum(source, len(emitters.power) - 1) - len(emitters.areas)
    return np.where(point >= 0, emitters.housings[np.maximum(point, 0)], 0)


@njit(**COMPILED)
def _reflect(
    reflectances: Reflectances,
    normals: FloatArray,
    incoming: FloatArray,
    flux: FloatArray,
    materials: IntArray,
    lobes: IntArray,
    weights: FloatArray,
    numbers: FloatArray,
    roulette: bool,
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Draw the next direction of each chain; returns directions, flux leaving and which chains go on."""
    count, channels = flux.shape
    directions = np.zeros((count, 3))
    leaving = np.zeros((count, channels))
    going = np.zeros(count, dtype=np.bool_)
    for k in range(count):
        m = materials[k]
        p_diffuse = diffuse_probability(reflectances, m)
        if lobes[k] != BOTH_LOBES:
            p_diffuse = 1.0 if lobes[k] == DIFFUSE_LOBE else 0.0
        nx, ny, nz = normals[k]
        if numbers[k, 0] < p_diffuse:
            x, y, z = cosine_direction(numbers[k, 1], numbers[k, 2])
            dx, dy, dz = to_axis(x, y, z, nx, ny, nz)
            for c in range(channels):
                leaving[k, c] = flux[k, c] * reflectances.diffuse[m, c] / p_diffuse
        else:
            n = reflectances.exponent[m]
            x, y, z = lobe_direction(numbers[k, 1], numbers[k, 2], n)
            ax, ay, az = mirrored(incoming[k, 0], incoming[k, 1], incoming[k, 2], nx, ny, nz)
            dx, dy, dz = to_axis(x, y, z, ax, ay, az)
            cos_out = dx * nx + dy * ny + dz * nz
            # (lobe x cosine) / density: what leaves below the horizon is absorbed.
            factor = (n + 2.0) / (n + 1.0) * max(cos_out, 0.0) / (1.0 - p_diffuse)
            for c in range(channels):
                leaving[k, c] = flux[k, c] * reflectances.specular[m, c] * factor
        directions[k, 0], directions[k, 1], directions[k, 2] = dx, dy, dz
        arriving, out = 0.0, 0.0
        for c in range(channels):
            arriving += weights[c] * abs(flux[k, c])
            out += weights[c] * abs(leaving[k, c])
        if not out > 0.0:
            continue
        survival = min(1.0, out / arriving) if roulette else 1.0
        if numbers[k, 3] < survival:
            going[k] = True
            for c in range(channels):
                leaving[k, c] /= survival
    return directions, leaving, going


def no_vertices(channels: int) -> ChainVertices:
    """Chains that never started."""
    places, numbers = np.empty((0, 3)), np.empty(0, dtype=np.int64)
    flux = np.empty((0, channels))
    return ChainVertices(places, places, places, flux, numbers, numbers, np.empty(0, dtype=np.bool_), numbers)


def joined(parts: list[ChainVertices]) -> ChainVertices:
    """Put vertices one after the other."""
    columns = [vars(part) for part in parts]
    return ChainVertices(**{name: np.concatenate([c[name] for c in columns]) for name in columns[0]})
