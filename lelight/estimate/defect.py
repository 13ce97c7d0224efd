"""Chains that carry what a base field lacks (sequential Monte Carlo; Halton 1962).

With L_h the base's Lambertian radiance and T the reflection of arriving light, the true field is
L = L_e + L_h + D + T D + T² D + ..., D = T (L_e + L_h) - L_h. Its Lambertian part, kd/pi (E_direct + gathered
base - base), is small where the base is good; its Phong part is what gloss makes of emitters and base. Chains
start from both with signed weights, and light the nodes like any others. The sum is unbiased for any base.
"""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import ARRAY
from lelight.estimate.base import BaseField
from lelight.estimate.cells import Cells, Drawn, cut
from lelight.estimate.direct import direct_light, drawn_illuminance, illuminance_and_density
from lelight.estimate.nearfield import near_field
from lelight.estimate.turns import Turn
from lelight.receivers import ILLUMINANCE, Receivers, space_receivers, with_surface
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
from lelight.tracing.sampling import cosine_directions
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World

#: Rays to emitters and into the room that estimate the defect where a chain starts, as power of two.
LOG2_DEFECT_RAYS = 8
#: Share of starts on sides that the pilot walk found dark, in case it missed something.
DARK_SHARE = 0.1
#: Places at which the defect is measured beforehand for each node, their least and greatest number, and the rays
#: of each, as power of two.
PLACES_PER_NODE, PLACES, LOG2_MEASURING_RAYS = 2, (2**10, 2**16), 5
CHUNK = 1024
#: Share of starts that is drawn evenly, whatever was measured.
EVENLY = 0.2
#: A lamp is close to a place that it lights so many times more than if its flux were spread over all surfaces.
CLOSE = 16.0
#: Parts of a seed.
STARTS, GLOSS, DEFECT_DIRECT, DEFECT_GATHER, BY_LIGHT, MEASURED = 11, 12, 13, 14, 15, 16


def defect_chains(world: World, base: BaseField, chains: Stretch, *, seed: tuple[int, ...]) -> ChainVertices:
    """Vertices of chains that carry what ``base`` lacks; a stretch of each kind.

    Returns
    -------
    ChainVertices : flux is signed; an unbiased estimate of the missing light, as `emission_chains` is of all
    """
    parts = [no_vertices(world.channels)]
    starts = base.starts or neutral_starts(world, base)
    if starts is not None:
        parts.append(_lambertian(world, base, starts, chains, seed=(*seed, STARTS)))
    if np.any(world.reflectances.specular_share > 0):
        parts.append(_glossy(world, base, starts, chains, seed=(*seed, GLOSS)))
    return joined(parts)


def with_starts(
    world: World, base: BaseField, *, seed: int, executor: Executor, keep: Keeper | None = None
) -> BaseField:
    """Measure what a base lacks here and there, so that chains start where it is much.

    Parameters
    ----------
    keep : remembers what was measured, if anything shall
    """
    keep = keep or Keeper()
    cells = neutral_starts(world, base)
    if cells is None:
        return base
    places = _places(base)
    rng = np.random.default_rng((seed, MEASURED))
    numbers = rng.random((places, 3))
    numbers[:, 0] = (np.arange(places) + numbers[:, 0]) / places
    drawn, cell = cells.draw(numbers)
    start = _standing(world, drawn)
    receivers = _at(base, start)

    def part(own: IntArray) -> FloatArray:
        return _lack(world, base, start[own], receivers[own], seed=(seed, MEASURED))

    def everywhere() -> FloatArray:
        chunks = np.split(np.arange(places), np.arange(CHUNK, places, CHUNK))
        return np.concatenate(list(keep.map(executor, "lack/part", part, chunks, ARRAY)))

    lack = keep.once("lack", everywhere, ARRAY)
    return replace(base, starts=cells.with_weights(cells.probability * _importance(lack, cell, len(cells))))


def neutral_starts(world: World, base: BaseField) -> Cells | None:
    """Cells of all sides that reflect diffusely, by area and albedo, dark ones more rarely; None without any."""
    albedo = world.reflectances.diffuse_share[world.materials]
    fronts = triangle_areas(world.caster.corners) * albedo
    weight = np.concatenate([fronts, np.where(world.caster.backs < 0, fronts, 0.0)])
    lit = base.lit[base.labels].T.ravel()
    weight = np.where(lit, weight, _share_of_dark(weight, lit) * weight)
    count = len(world.materials)
    chosen = np.flatnonzero(weight > 0)
    if not len(chosen):
        return None
    faces = chosen % count, np.where(chosen < count, 1, -1)
    return cut(world.caster.corners, faces=faces, weights=weight[chosen], wanted=_places(base))


def _places(base: BaseField) -> int:
    """Count the places at which the defect is measured, about one a cell."""
    return int(np.clip(PLACES_PER_NODE * len(base.illuminance), *PLACES))


def _at(base: BaseField, start: ChainVertices) -> Receivers:
    """Receivers at starts of chains."""
    receivers = with_surface(space_receivers(start.points, start.normals))
    return base.guide.leading(receivers) if base.guide is not None else receivers


def _lack(
    world: World, base: BaseField, start: ChainVertices, receivers: Receivers, *, seed: tuple[int, ...]
) -> FloatArray:
    """Illuminance (k,) in lx that places get in truth beyond what the base says, either way."""
    few = Stretch.of(LOG2_MEASURING_RAYS)
    rest = _rest_of_defect(world, base, start, receivers, few, (*seed, DEFECT_GATHER))
    direct, _ = direct_light(world, receivers, samples=few, seed=(*seed, DEFECT_DIRECT), guide=base.guide)
    return np.abs(luminance_weighted(rest + direct[:, ILLUMINANCE]))


def _importance(lack: FloatArray, cell: IntArray, count: int) -> FloatArray:
    """Factor (count,) of each cell's probability by what was found lacking (k,) in cells (k,), in their order.

    A cell that none was drawn in goes by the next that one was.
    """
    mean = float(lack.mean())
    if not mean > 0.0:
        return np.ones(count)
    drawn = np.bincount(cell, minlength=count)
    found = np.flatnonzero(drawn)
    own = np.bincount(cell, weights=lack, minlength=count)[found] / drawn[found]
    near = np.searchsorted(found, np.arange(count)).clip(max=len(found) - 1)
    return np.asarray(EVENLY + (1.0 - EVENLY) * own[near] / mean)


def _lambertian(
    world: World, base: BaseField, starts: Cells, chains: Stretch, *, seed: tuple[int, ...]
) -> ChainVertices:
    """Chains from the defect of the base, their starts drawn in two ways: over the surface, and by the light itself.

    Over the surface alone, the spot that a lamp close to a wall makes would hardly ever be met. So pairs of lamp
    point z and surface point y are shared out: where the light g(z, y) that is sent, over the density q(z | y) of
    drawing the lamp point from y, is many times what the lamps would give if spread over all surfaces, the pair
    belongs to chains that light leads to y with density g / flux, and otherwise to those over the surface. A pair
    stands for g + rest q, rest being the defect but for its direct light; both ways stay bounded, however close
    the lamp, and where none is close the second costs its rays only.
    """
    if np.any(world.emitters.tables >= 0):
        # A luminaire by table sends from all of its opening but lights far places as a point: no pairs to weigh.
        points, seed = chain_numbers(chains, seed=seed), (*seed, chains.first)
        first, chain = _over_surface(world, base, starts, points, seed, shared_out=False)
        return walk_on(world, first, chain=chain, points=points, seed=seed)
    points, more = chain_numbers(chains, seed=seed), chain_numbers(chains, seed=(*seed, BY_LIGHT))
    seed = (*seed, chains.first)
    both = (
        _over_surface(world, base, starts, points, seed),
        _by_light(world, base, starts, more, (*seed, BY_LIGHT)),
    )
    first = joined([vertices for vertices, _ in both])
    chain = np.concatenate([both[0][1], len(points) + both[1][1]])
    return walk_on(world, first, chain=chain, points=np.concatenate([points, more]), seed=seed)


def _over_surface(
    world: World,
    base: BaseField,
    starts: Cells,
    points: FloatArray,
    seed: tuple[int, ...],
    *,
    shared_out: bool = True,
) -> tuple[ChainVertices, IntArray]:
    """Draw starts over the surface, but for pairs with close lamps; also which row of ``points`` each is."""
    drawn, _ = starts.draw(points[:, :3])
    start, area = _standing(world, drawn), drawn.area
    receivers, samples = _at(base, start), Stretch.of(LOG2_DEFECT_RAYS)
    rest = _rest_of_defect(world, base, start, receivers, samples, (*seed, DEFECT_GATHER))
    owner, light = drawn_illuminance(world, receivers, samples=samples, seed=(*seed, DEFECT_DIRECT))
    kept = luminance_weighted(light) <= (_close_light(world) if shared_out else np.inf)
    # Draws that found no lamp stand for the rest alone, with their whole weight.
    defect = rest * (1.0 - np.bincount(owner, minlength=len(points)) / samples.count)[:, None]
    np.add.at(defect, owner, (light + rest[owner]) * kept[:, None] / samples.count)
    return start.with_flux(defect * (area / len(points))[:, None]), np.arange(len(points))


def _by_light(
    world: World, base: BaseField, starts: Cells, points: FloatArray, seed: tuple[int, ...]
) -> tuple[ChainVertices, IntArray]:
    """Start where light from the emitters falls; also which row of ``points`` each is."""
    emitters = world.emitters
    origins, directions, flux = emit(emitters, points, world.caster.offset)
    start, alive = arrive(world, origins, directions, flux / len(points))
    last = len(emitters.power) - 1
    sources = np.minimum(np.searchsorted(emitters.power_cdf, points[alive, 0], side="right"), last)
    light, drawn = illuminance_and_density(world, sources, start.points, start.normals, start.incoming)
    sent = luminance_weighted(light)
    side = np.where(start.front, 1, -1)
    close = sent > drawn * _close_light(world)
    close &= starts.density(start.triangles, side, start.points) > 0.0
    start, light, drawn = start[close].with_lobes(DIFFUSE_LOBE), light[close], drawn[close, None]
    samples = Stretch.of(LOG2_DEFECT_RAYS)
    rest = _rest_of_defect(world, base, start, _at(base, start), samples, (*seed, DEFECT_GATHER))
    pair = (light + rest * drawn) * (emitters.power.sum() / sent[close, None])
    return start.with_flux(pair / len(points)), alive[close]


def _close_light(world: World) -> float:
    """Illuminance in lx by one drawn lamp point from which on the lamp counts as close."""
    return CLOSE * float(world.emitters.power.sum()) / world.area


def _rest_of_defect(
    world: World,
    base: BaseField,
    start: ChainVertices,
    receivers: Receivers,
    samples: Stretch,
    seed: tuple[int, ...],
) -> FloatArray:
    """Illuminance (k, C) that the base gives at places, gathered by the receivers there, less what it says of them."""
    at_once = (Turn.of_all(samples, len(receivers)),)
    gathered, _, _ = near_field(world, receivers, bound=math.inf, together=at_once, seed=seed, base=base)
    return gathered[:, ILLUMINANCE] - base.illuminance_at(start.triangles, start.points, start.front)


def _standing(world: World, drawn: Drawn) -> ChainVertices:
    """Vertices without flux at drawn places."""
    normals = drawn.side[:, None] * world.normals[drawn.triangle]
    return ChainVertices(
        points=drawn.points,
        normals=normals,
        incoming=normals,
        flux=np.zeros((len(normals), world.channels)),
        materials=world.materials[drawn.triangle],
        triangles=drawn.triangle,
        front=drawn.side > 0,
        lobes=np.full(len(normals), DIFFUSE_LOBE),
    )


def _share_of_dark(weight: FloatArray, lit: BoolArray) -> float:
    """Factor that gives the dark sides together their share; 1 where all that reflects is dark."""
    dark, bright = float(weight[~lit].sum()), float(weight[lit].sum())
    if not bright > 0.0:
        return 1.0
    return DARK_SHARE / (1.0 - DARK_SHARE) * bright / dark if dark > 0 else 0.0


def _glossy(
    world: World, base: BaseField, starts: Cells | None, chains: Stretch, *, seed: tuple[int, ...]
) -> ChainVertices:
    """Chains from emitters and the base's own radiance; of their first reflection only gloss is kept."""
    from_emitters = chain_numbers(chains, seed=(*seed, 1))
    origins, directions, flux = emit(world.emitters, from_emitters, world.caster.offset)
    housing = emitted_housings(world.emitters, from_emitters)
    from_base = chain_numbers(chains, seed=(*seed, 2))
    if starts is not None:
        base_origins, base_directions, base_flux = _emit_base(world, base, starts, from_base)
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
    world: World, base: BaseField, starts: Cells, numbers: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Let the base's Lambertian radiance shine: origins, directions and flux over probability."""
    drawn, _ = starts.draw(numbers[:, :3])
    start = _standing(world, drawn)
    luminance, _ = base.luminance_at(start.triangles, start.points, start.front)
    directions = cosine_directions(numbers[:, 3:5], start.normals)
    origins = world.caster.leave(start.points, start.normals)
    return origins, directions, math.pi * luminance * drawn.area[:, None]
