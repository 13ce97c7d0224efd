"""The near field: what the bounded kernel of the chains leaves out, gathered from the receiver's side.

Rays leave the receiver (cosine-distributed on a surface; in space half of them so, half uniformly); where
they meet a surface so near that the kernel exceeds its bound, paths bring the rest of what that surface
reflects. In open space almost no ray meets anything that near, and a ray is all it costs. With the bound at
zero this is plain path tracing.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.estimate.guide import Guide, guided, tables
from lelight.estimate.local import Arrivals
from lelight.estimate.moments import add_arrivals
from lelight.estimate.pathends import END_NUMBERS, PathEnds, SurfaceLuminance, bounded_base
from lelight.estimate.paths import NUMBERS, reflected_radiance, rotated_numbers
from lelight.estimate.pathstate import Paths, chosen_paths, meet
from lelight.estimate.split import list_near
from lelight.estimate.turns import Turn
from lelight.receivers import MOMENTS, Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import hash_of
from lelight.tracing.rays import Float32Array
from lelight.tracing.sampling import cosine_direction, sphere_direction, to_axis
from lelight.tracing.sobol import Stretch, sobol
from lelight.tracing.world import World

#: More than any receiver samples in a run: numbers its paths apart from those of all others.
MOST_SAMPLES = 2**32


def near_field(
    world: World,
    receivers: Receivers,
    *,
    bound: float,
    together: tuple[Turn, ...],
    seed: tuple[int, ...],
    base: SurfaceLuminance | None = None,
    ends: PathEnds | None = None,
) -> tuple[FloatArray, tuple[Arrivals, ...], int]:
    """Light of near surfaces beyond the bounded kernel.

    Parameters
    ----------
    bound : float, 1/m², b of the split; inf leaves only the base
    base : a field to gather where the kernel is bounded; the chains then carry what it lacks. Its guide, if it has
        one, leads the rays
    ends : what paths end on; without it they go on until they are absorbed
    together : the rays of the receivers, as points of their sequences; receivers without a turn get nothing

    Returns
    -------
    moments : (r, 6, C) float
    arrivals : single rays, only where receivers keep angular detail
    rays : int
    """
    receiver, sample, share = _samples(together)
    numbers = _numbers(receivers, together, seed)
    guide = base.guide if base is not None else None
    directions, solid_angle = _directions(receivers, receiver, numbers, guide)
    paths = _first_surfaces(world, receivers, receiver, directions)
    below = None
    if base is not None:
        below, paths = bounded_base(world, base, paths, bound)
    near = np.flatnonzero(list_near(world.reflectances, paths.materials, paths.geometry, bound))
    radiance, rays = reflected_radiance(
        world,
        chosen_paths(paths, near),
        bound=bound,
        numbers=numbers[paths.number[near], 2:],
        identity=receivers.identity[receiver] * MOST_SAMPLES + sample,
        key=hash_of((*seed, 1)),
        ends=ends,
        guide=guide,
    )
    if below is not None:
        radiance[paths.number] += below
    lit = np.flatnonzero(radiance.any(axis=1))
    weight = (solid_angle * share)[lit, None]
    arrivals = Arrivals(receiver[lit], directions[lit], radiance[lit] * weight)
    moments = np.zeros((len(receivers), MOMENTS, world.channels))
    add_arrivals(
        moments, arrivals.receiver, arrivals.directions, receivers.normals, arrivals.radiance_solid_angle
    )
    return moments, _with_detail(receivers, arrivals), rays + len(receiver)


def hemisphere_rays(
    world: World, receivers: Receivers, *, samples: Stretch, seed: tuple[int, ...]
) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """Cosine-distributed rays from surface receivers.

    Returns
    -------
    origins, directions : (k, 3) float
    receiver : (k,) int
    numbers : (k, 2) float, that gave the directions
    """
    table = sobol(2, samples, seed=seed)
    numbers = np.empty((len(receivers) * len(table), 2))
    rotated_numbers(table, hash_of(seed), receivers.identity, numbers)
    receiver = np.repeat(np.arange(len(receivers)), len(table))
    directions, _ = _directions(receivers, receiver, numbers, None)
    origins = world.caster.leave(receivers.points, receivers.normals).take(receiver, axis=0)
    return origins, directions, receiver, numbers


def _with_detail(receivers: Receivers, arrivals: Arrivals) -> tuple[Arrivals, ...]:
    """Keep the arrivals at receivers that want angular detail."""
    wanted = receivers.degrees[arrivals.receiver] > 0
    if not wanted.any():
        return ()
    return (
        Arrivals(
            arrivals.receiver[wanted], arrivals.directions[wanted], arrivals.radiance_solid_angle[wanted]
        ),
    )


def _samples(together: tuple[Turn, ...]) -> tuple[IntArray, IntArray, FloatArray]:
    """Receiver (k,), place in its sequence (k,), and share of all its samples (k,), of every sample."""
    receiver = np.concatenate([np.repeat(turn.own, turn.samples.count) for turn in together])
    sample = np.concatenate(
        [np.tile(turn.samples.first + np.arange(turn.samples.count), len(turn.own)) for turn in together]
    )
    share = np.concatenate([np.full(len(turn), turn.share / turn.samples.count) for turn in together])
    return receiver, sample, share


def _numbers(receivers: Receivers, together: tuple[Turn, ...], seed: tuple[int, ...]) -> FloatArray:
    """Uniform numbers (k, n) of every sample: two for its direction, the rest for the first surface."""
    numbers = np.empty((sum(len(turn) for turn in together), 2 + NUMBERS + END_NUMBERS))
    first = 0
    for turn in together:
        table = sobol(numbers.shape[1], turn.samples, seed=seed)
        rotated_numbers(
            table, hash_of(seed), receivers.identity[turn.own], numbers[first : first + len(turn)]
        )
        first += len(turn)
    return numbers


def _directions(
    receivers: Receivers, receiver: IntArray, numbers: FloatArray, guide: Guide | None
) -> tuple[FloatArray, FloatArray]:
    """First directions (k, 3) and the solid angle (k,) in sr that each stands for, one over its density."""
    directions = np.empty((len(numbers), 3))
    solid_angles = np.empty(len(numbers))
    _draw_directions(
        receivers.normals,
        receivers.on_surface,
        receivers.rows,
        *tables(guide),
        receiver,
        numbers,
        directions,
        solid_angles,
    )
    return directions, solid_angles


@njit(**LEAF)
def _draw_directions(
    normals: FloatArray,
    on_surface: BoolArray,
    rows: IntArray,
    density_by_cell: Float32Array,
    rings: Float32Array,
    receiver: IntArray,
    numbers: FloatArray,
    directions: FloatArray,
    solid_angles: FloatArray,
) -> None:
    for k in range(len(numbers)):
        r = receiver[k]
        u, v, lead = numbers[k, 0], numbers[k, 1], 1.0
        if on_surface[r]:
            u, v, lead = guided(density_by_cell, rings, rows[r], u, v)
        if on_surface[r] or u < 0.5:
            x, y, z = cosine_direction(u if on_surface[r] else 2.0 * u, v)
            d = to_axis(x, y, z, normals[r, 0], normals[r, 1], normals[r, 2])
        else:
            d = sphere_direction(2.0 * u - 1.0, v)
        directions[k] = d
        cos_theta = d[0] * normals[r, 0] + d[1] * normals[r, 1] + d[2] * normals[r, 2]
        density = lead * max(cos_theta, 1e-12 if on_surface[r] else 0.0) / math.pi
        if not on_surface[r]:
            density = 0.5 * density + 0.125 / math.pi
        solid_angles[k] = 1.0 / density


def _first_surfaces(world: World, receivers: Receivers, receiver: IntArray, directions: FloatArray) -> Paths:
    """Surfaces that the first rays meet, with the kernel G to them."""
    # In space too: a measuring plane may lie exactly on a surface.
    origins = world.caster.leave(receivers.points, receivers.normals).take(receiver, axis=0)
    number = np.arange(len(receiver))
    paths, kept = meet(world, number, origins, directions, np.ones((len(receiver), world.channels)))
    geometry = _geometry(receivers, receiver[kept], directions.take(kept, axis=0), paths)
    return replace(paths, geometry=geometry)


def _geometry(receivers: Receivers, receiver: IntArray, directions: FloatArray, paths: Paths) -> FloatArray:
    """G (k,) in 1/m² from receivers; without their cosine in space."""
    return np.asarray(
        _kernels(
            receivers.points,
            receivers.normals,
            receivers.on_surface,
            receiver,
            directions,
            paths.points,
            paths.normals,
        )
    )


@njit(**COMPILED)
def _kernels(
    at: FloatArray,
    at_normals: FloatArray,
    on_surface: BoolArray,
    receiver: IntArray,
    directions: FloatArray,
    points: FloatArray,
    normals: FloatArray,
) -> FloatArray:
    kernels = np.empty(len(receiver))
    for k in range(len(receiver)):
        r = receiver[k]
        square, cos_receiver, cos_surface = 0.0, 0.0, 0.0
        for axis in range(3):
            square += (points[k, axis] - at[r, axis]) ** 2
            cos_receiver += directions[k, axis] * at_normals[r, axis]
            cos_surface -= directions[k, axis] * normals[k, axis]
        if not on_surface[r]:
            cos_receiver = 1.0
        kernels[k] = cos_surface * cos_receiver / max(square, 1e-300)
    return kernels
