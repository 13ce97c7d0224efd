"""Chains that carry what a base field lacks (sequential Monte Carlo; Halton 1962).

With L_h the base's Lambertian radiance and T the reflection of arriving light, the true field is
L = L_e + L_h + D + T D + T² D + ..., D = T (L_e + L_h) - L_h. Its Lambertian part, kd/pi (E_direct + gathered
base - base), is small where the base is good; its Phong part is what gloss makes of emitters and base. Chains
start from both with signed weights, and light the nodes like any others. The sum is unbiased for any base.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lelight.channels import luminance_weighted
from lelight.estimate.base import BaseField
from lelight.estimate.direct import drawn_illuminance, illuminance_and_density
from lelight.estimate.nearfield import near_field
from lelight.receivers import ILLUMINANCE, space_receivers, with_surface
from lelight.scene import BoolArray, FloatArray, IntArray, triangle_areas
from lelight.tracing.chains import (
    DIFFUSE_LOBE,
    SPECULAR_LOBE,
    ChainVertices,
    arrive,
    chain_numbers,
    emit,
    emitted_housings,
    joined,
    no_vertices,
    walk_on,
)
from lelight.tracing.sampling import Stretch, cosine_directions
from lelight.tracing.world import World

#: Rays to emitters and into the room that estimate the defect where a chain starts, as power of two.
LOG2_DEFECT_RAYS = 6
#: Share of starts on sides that the pilot walk found dark, in case it missed something.
DARK_SHARE = 0.1
#: Parts of a seed.
STARTS, GLOSS, DEFECT_DIRECT, DEFECT_GATHER, BY_LIGHT = 11, 12, 13, 14, 15


@dataclass(frozen=True)
class _Faces:
    """Sides of triangles from which chains can start: triangle, side (+1, -1) and cumulative probability."""

    triangle: IntArray
    side: IntArray
    probability: FloatArray

    def drawn(self, u: FloatArray) -> IntArray:
        """Face (k,) for uniform numbers (k,)."""
        cumulative = np.cumsum(self.probability)
        found = np.searchsorted(cumulative, u * cumulative[-1], side="right")
        return np.asarray(np.minimum(found, len(cumulative) - 1))


def defect_chains(world: World, base: BaseField, chains: Stretch, *, seed: tuple[int, ...]) -> ChainVertices:
    """Vertices of chains that carry what ``base`` lacks; a stretch of each kind.

    Returns
    -------
    ChainVertices : flux is signed; an unbiased estimate of the missing light, as `emission_chains` is of all
    """
    parts = [no_vertices(world.channels)]
    faces = _faces(world, base) if _diffuse(world) else None
    if faces is not None:
        parts.append(_lambertian(world, base, faces, chains, seed=(*seed, STARTS)))
    if np.any(world.reflectances.specular_share > 0):
        parts.append(_glossy(world, base, faces, chains, seed=(*seed, GLOSS)))
    return joined(parts)


def _diffuse(world: World) -> bool:
    """Say whether any surface has a Lambertian lobe."""
    return bool(np.any(world.reflectances.diffuse_share[world.materials] > 0))


def _lambertian(
    world: World, base: BaseField, faces: _Faces, chains: Stretch, *, seed: tuple[int, ...]
) -> ChainVertices:
    """Chains from the defect of the base, their starts drawn twice: over the surface, and by the light itself.

    Over the surface alone, the spot that a lamp close to a wall makes would hardly ever be met. Both ways are
    weighed by the balance heuristic over pairs of lamp point z and surface point y. With g(z, y) the light sent,
    q(z | y) and a(y) the densities of drawing a lamp point from y and y over the surface, and g / flux that of
    light falling from z on y, a pair stands for (g + rest q) / (a q + g / flux), rest being the defect but for
    its direct light. That is bounded, however close the lamp.
    """
    if np.any(world.emitters.tables >= 0):
        # A luminaire by table sends from all of its opening but lights far places as a point: no pairs to weigh.
        points, seed = chain_numbers(chains, seed=seed), (*seed, chains.first)
        first, chain = _over_surface(world, base, faces, points, seed, weighed=False)
        return walk_on(world, first, chain=chain, points=points, seed=seed)
    half = chains.half()
    points, more = chain_numbers(half, seed=seed), chain_numbers(half, seed=(*seed, BY_LIGHT))
    seed = (*seed, chains.first)
    starts = (
        _over_surface(world, base, faces, points, seed),
        _by_light(world, base, faces, more, (*seed, BY_LIGHT)),
    )
    first = joined([vertices for vertices, _ in starts])
    chain = np.concatenate([starts[0][1], len(points) + starts[1][1]])
    return walk_on(world, first, chain=chain, points=np.concatenate([points, more]), seed=seed)


def _over_surface(
    world: World,
    base: BaseField,
    faces: _Faces,
    points: FloatArray,
    seed: tuple[int, ...],
    *,
    weighed: bool = True,
) -> tuple[ChainVertices, IntArray]:
    """Draw starts over the surface, weighed against the other way; also which row of ``points`` each is."""
    start, area = _surface_points(world, faces, points)
    rest = _rest_of_defect(world, base, start, (*seed, DEFECT_GATHER))
    receivers = with_surface(space_receivers(start.points, start.normals))
    owner, light = drawn_illuminance(
        world, receivers, samples=Stretch.of(LOG2_DEFECT_RAYS), seed=(*seed, DEFECT_DIRECT)
    )
    draws = 2**LOG2_DEFECT_RAYS
    by_light = luminance_weighted(light) / world.emitters.power.sum() if weighed else 0.0
    weight = 1.0 / (1.0 + area[owner] * by_light)
    # Draws that found no lamp stand for the rest alone, with their whole weight.
    defect = rest * (1.0 - np.bincount(owner, minlength=len(points)) / draws)[:, None]
    np.add.at(defect, owner, (light + rest[owner]) * weight[:, None] / draws)
    return start.with_flux(defect * (area / len(points))[:, None]), np.arange(len(points))


def _by_light(
    world: World, base: BaseField, faces: _Faces, points: FloatArray, seed: tuple[int, ...]
) -> tuple[ChainVertices, IntArray]:
    """Start where light from the emitters falls; also which row of ``points`` each is."""
    emitters = world.emitters
    origins, directions, flux = emit(emitters, points, world.caster.offset)
    start, alive = arrive(world, origins, directions, flux / len(points))
    density = _surface_density(world, faces)[start.triangles, np.where(start.front, 0, 1)]
    met = np.flatnonzero(density > 0.0)
    start, alive, density = start[met].with_lobes(DIFFUSE_LOBE), alive[met], density[met]
    rest = _rest_of_defect(world, base, start, (*seed, DEFECT_GATHER))
    last = len(emitters.power) - 1
    sources = np.minimum(np.searchsorted(emitters.power_cdf, points[alive, 0], side="right"), last)
    light, drawn = illuminance_and_density(world, sources, start.points, start.normals, start.incoming)
    both_ways = density * drawn + luminance_weighted(light) / emitters.power.sum()
    pair = np.divide(
        light + rest * drawn[:, None],
        both_ways[:, None],
        out=np.zeros_like(light),
        where=both_ways[:, None] > 0,
    )
    return start.with_flux(pair / len(points)), alive


def _rest_of_defect(world: World, base: BaseField, start: ChainVertices, seed: tuple[int, ...]) -> FloatArray:
    """Illuminance (k, C) that the base gives at places, gathered, less what it says of them."""
    gathered, _, _ = near_field(
        world,
        with_surface(space_receivers(start.points, start.normals)),
        bound=math.inf,
        samples=Stretch.of(LOG2_DEFECT_RAYS),
        seed=seed,
        base=base,
    )
    return gathered[:, ILLUMINANCE] - base.illuminance_at(start.triangles, start.points, start.front)


def _surface_density(world: World, faces: _Faces) -> FloatArray:
    """Density (n_t, 2) in 1/m² with which starts are drawn over the fronts and backs of the triangles."""
    density = np.zeros((len(world.materials), 2))
    areas = triangle_areas(world.caster.corners)[faces.triangle]
    density[faces.triangle, np.where(faces.side > 0, 0, 1)] = faces.probability / areas
    return density


def _surface_points(world: World, faces: _Faces, numbers: FloatArray) -> tuple[ChainVertices, FloatArray]:
    """Points on reflecting surfaces and the area (k,) in m² that each stands for, one over its density."""
    face = faces.drawn(numbers[:, 0])
    triangle, side = faces.triangle[face], faces.side[face]
    root = np.sqrt(numbers[:, 1])
    weights = np.stack([1.0 - root, root * (1.0 - numbers[:, 2]), root * numbers[:, 2]], axis=1)
    points = np.einsum("kc,kcx->kx", weights, world.caster.corners[triangle])
    normals = side[:, None] * world.normals[triangle]
    vertices = ChainVertices(
        points=points,
        normals=normals,
        incoming=normals,
        flux=np.zeros((len(points), world.channels)),
        materials=world.materials[triangle],
        triangles=triangle,
        front=side > 0,
        lobes=np.full(len(points), DIFFUSE_LOBE),
    )
    areas = triangle_areas(world.caster.corners)
    return vertices, areas[triangle] / faces.probability[face]


def _faces(world: World, base: BaseField) -> _Faces:
    """Sides of all triangles that reflect diffusely, by area and albedo; dark ones more rarely."""
    albedo = world.reflectances.diffuse_share[world.materials]
    fronts = triangle_areas(world.caster.corners) * albedo
    weight = np.concatenate([fronts, np.where(world.caster.backs < 0, fronts, 0.0)])
    lit = base.lit[base.labels].T.ravel()
    weight = np.where(lit, weight, _share_of_dark(weight, lit) * weight)
    count = len(world.materials)
    chosen = np.flatnonzero(weight > 0)
    return _Faces(
        triangle=chosen % count,
        side=np.where(chosen < count, 1, -1),
        probability=weight[chosen] / weight.sum(),
    )


def _share_of_dark(weight: FloatArray, lit: BoolArray) -> float:
    """Factor that gives the dark sides together their share; 1 where all that reflects is dark."""
    dark, bright = float(weight[~lit].sum()), float(weight[lit].sum())
    if not bright > 0.0:
        return 1.0
    return DARK_SHARE / (1.0 - DARK_SHARE) * bright / dark if dark > 0 else 0.0


def _glossy(
    world: World, base: BaseField, faces: _Faces | None, chains: Stretch, *, seed: tuple[int, ...]
) -> ChainVertices:
    """Chains from emitters and the base's own radiance; of their first reflection only gloss is kept."""
    from_emitters = chain_numbers(chains, seed=(*seed, 1))
    origins, directions, flux = emit(world.emitters, from_emitters, world.caster.offset)
    housing = emitted_housings(world.emitters, from_emitters)
    from_base = chain_numbers(chains, seed=(*seed, 2))
    if faces is not None:
        base_origins, base_directions, base_flux = _emit_base(world, base, faces, from_base)
        origins = np.concatenate([origins, base_origins])
        directions = np.concatenate([directions, base_directions])
        flux = np.concatenate([flux, base_flux])
        housing = np.concatenate([housing, np.zeros(len(base_flux), dtype=np.int64)])
    first, alive = arrive(world, origins, directions, flux / len(from_base), housing=housing)
    glossy = np.flatnonzero(world.reflectances.specular_share[first.materials] > 0)
    first = first[glossy].with_lobes(SPECULAR_LOBE)
    return walk_on(
        world,
        first,
        chain=alive[glossy],
        points=np.concatenate([from_emitters, from_base]),
        seed=(*seed, chains.first),
    )


def _emit_base(
    world: World, base: BaseField, faces: _Faces, numbers: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Let the base's Lambertian radiance shine: origins, directions and flux over probability."""
    start, area = _surface_points(world, faces, numbers)
    luminance = base.luminance_at(start.triangles, start.points, start.front)
    directions = cosine_directions(numbers[:, 3:5], start.normals)
    origins = world.caster.leave(start.points, start.normals)
    return origins, directions, math.pi * luminance * area[:, None]
