"""Light that comes straight from the emitters, sampled from the receiver's side.

Sources are drawn by what they can give at the receiver and by what is known to be in sight there, luminous triangles by
solid angle unless they are far, so a lamp costs a few rays however near it is. The unshadowed illuminance is known in
closed form; a share of it, by source, chosen beforehand, is taken from there and only the difference is sampled (a
control variate). Where nothing is in the way of a receiver and of the nodes around it, no noise is left.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lelight.compilation import COMPILED, LEAF
from lelight.estimate.guide import Guide
from lelight.estimate.knowndirect import add_known
from lelight.estimate.local import Arrivals
from lelight.estimate.moments import add_arrivals
from lelight.receivers import ILLUMINANCE, MOMENTS, Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import hash_of
from lelight.tracing.drawing import (
    LOCAL_CHOICE_LIMIT,
    choice_cdf,
    chosen,
    source_housing,
    source_strength,
    toward_face,
)
from lelight.tracing.emitters import Emitters
from lelight.tracing.lamps import has_closed_form, toward_lamp
from lelight.tracing.sampling import mix, rotated, uniform
from lelight.tracing.sight import Shares, known_share, row_of_sight, unseen
from lelight.tracing.sobol import Stretch, sobol
from lelight.tracing.triangles import triangle_density
from lelight.tracing.world import World

#: Rays by receiver and source.
Counts = NDArray[np.uint8]
#: Shadow rays that tell beforehand how much of the emitters a receiver sees, as power of two.
LOG2_PREVIEW = 5
#: Where less than this share came through, it may be by a slit. So many more rays tell then, for so many
#: receivers at once, and where it is little but something, receivers sample more often, so much at the most, as power
#: of two.
LITTLE = 0.1
LOG2_SLIT_PREVIEW, BLOCKED_AT_ONCE, SLIT_DOUBLINGS = 10, 256, 6
#: Where there are more receivers than this, fewer rays look for slits: a twentieth of the time of a library hall.
MANY_RECEIVERS, LOG2_ROUGH_SLIT_PREVIEW = 1 << 16, 8


def direct_light(
    world: World,
    receivers: Receivers,
    *,
    samples: Stretch,
    seed: tuple[int, ...],
    guide: Guide | None = None,
) -> tuple[FloatArray, int]:
    """Moments (r, 6, C) of the light that reaches the receivers from emitters, and the rays it took.

    Parameters
    ----------
    samples : the shadow rays of each receiver, as points of its sequence
    guide : tells receivers that know their row of it which sources are in sight
    """
    sight = guide.sight if guide is not None else unseen()
    drawn, clear = _traced(world, receivers, samples, seed, sight)
    return _summed(world, receivers, drawn, clear, samples), len(drawn.source)


def direct_light_and_sight(
    world: World, receivers: Receivers, *, samples: Stretch, seed: tuple[int, ...]
) -> tuple[FloatArray, Counts, Counts]:
    """Do as `direct_light`, and count by source the rays of each receiver and those of them that nothing blocked.

    Returns
    -------
    moments : (r, 6, C) float
    asked, clear : (r, S) uint8, of fewer than 256 samples; S is 0 where there are too many sources to choose by place

    Raises
    ------
    ValueError
        where there are more samples than such a count holds
    """
    if samples.count > np.iinfo(np.uint8).max:
        raise ValueError(f"{samples.count} samples: their counts would not fit")
    drawn, clear = _traced(world, receivers, samples, seed, unseen())
    sources = len(world.emitters.power)
    shape = (len(receivers), sources if sources <= LOCAL_CHOICE_LIMIT else 0)
    asked, through = np.zeros(shape, dtype=np.uint8), np.zeros(shape, dtype=np.uint8)
    if shape[1]:
        _count_rays(drawn.arrivals.receiver, drawn.source, clear, asked, through)
    return _summed(world, receivers, drawn, clear, samples), asked, through


@njit(**LEAF)
def _count_rays(
    receiver: IntArray, source: IntArray, clear: BoolArray, asked: Counts, through: Counts
) -> None:
    for k in range(len(receiver)):
        asked[receiver[k], source[k]] += 1
        if clear[k]:
            through[receiver[k], source[k]] += 1


def _summed(
    world: World, receivers: Receivers, drawn: _Drawn, clear: BoolArray, samples: Stretch
) -> FloatArray:
    """Moments (r, 6, C) of drawn rays."""
    light, owner = drawn.arrivals.radiance_solid_angle / samples.count, drawn.arrivals.receiver
    moments = np.zeros((len(receivers), MOMENTS, world.channels))
    add_arrivals(moments, owner[clear], drawn.arrivals.directions[clear], receivers.normals, light[clear])
    _correct(moments, receivers, drawn, light)
    return moments


def drawn_illuminance(
    world: World, receivers: Receivers, *, samples: Stretch, seed: tuple[int, ...]
) -> tuple[IntArray, FloatArray]:
    """Draws that found a source in sight: receiver (k,) and the illuminance (k, C) in lx that one stands for.

    The mean of all draws, those that found nothing as zero, is the direct illuminance.
    """
    drawn, clear = _traced(world, receivers, samples, seed, unseen())
    owner, directions = drawn.arrivals.receiver[clear], drawn.arrivals.directions[clear]
    cosine = np.maximum(np.einsum("kx,kx->k", directions, receivers.normals[owner]), 0.0)
    return owner, drawn.arrivals.radiance_solid_angle[clear] * cosine[:, None]


def illuminance_and_density(
    world: World, sources: IntArray, points: FloatArray, normals: FloatArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Light that sources (k,) send to surface points (k, 3), and the density of drawing it from there.

    Parameters
    ----------
    directions : (k, 3) float, unit, from the points to where on its source the light comes from

    Returns
    -------
    illuminance : (k, C) float; lx per sr for a triangle, lx for a point source
    density : (k,) float; 1/sr for a triangle, 1 for a point: `drawn_illuminance` is one over the other
    """
    illuminance, density = np.zeros((len(sources), world.channels)), np.zeros(len(sources))
    _weigh_sources(world.emitters, sources, points, normals, directions, illuminance, density)
    return illuminance, density


@njit(**COMPILED)
def _weigh_sources(
    emitters: Emitters,
    sources: IntArray,
    points: FloatArray,
    normals: FloatArray,
    directions: FloatArray,
    illuminance: FloatArray,
    density: FloatArray,
) -> None:
    cdf, unseen_here = np.empty(len(emitters.power)), np.empty((0, 0), dtype=np.uint8)
    triangles = len(emitters.areas)
    for k in range(len(sources)):
        s = sources[k]
        x, y, z = points[k]
        nx, ny, nz = normals[k]
        dx, dy, dz = directions[k]
        factor = max(0.0, dx * nx + dy * ny + dz * nz)
        share = 0.0
        if choice_cdf(emitters, x, y, z, nx, ny, nz, True, -1, unseen_here, cdf):
            share = cdf[s] - (cdf[s - 1] if s > 0 else 0.0)
        if s < triangles:
            corners, normal, area = emitters.corners[s], emitters.normals[s], emitters.areas[s]
            density[k] = share * triangle_density(corners, normal, area, x, y, z, (dx, dy, dz))
        else:
            away = emitters.positions[s - triangles] - points[k]
            square = away[0] * away[0] + away[1] * away[1] + away[2] * away[2]
            factor /= max(square, 1e-300)
            density[k] = share
        for c in range(illuminance.shape[1]):
            illuminance[k, c] = source_strength(emitters, s, c) * factor


def with_clear_share(
    world: World, receivers: Receivers, *, seed: tuple[int, ...], among: int | None = None
) -> Receivers:
    """Find out beforehand how much of the emitters' light reaches each receiver.

    Receivers that look all but blocked are asked again with many more rays: those that see a little, through a slit,
    will sample direct light more often than others. Among very many sources the closed form would cost more
    than it saves; there the share stays zero.

    Parameters
    ----------
    among : how many receivers there are in all, where these are a part of them
    """
    if len(world.emitters.power) > LOCAL_CHOICE_LIMIT:
        return receivers
    many = (among or len(receivers)) > MANY_RECEIVERS
    log2_slit_preview = LOG2_ROUGH_SLIT_PREVIEW if many else LOG2_SLIT_PREVIEW
    share = _clear_share(world, receivers, LOG2_PREVIEW, seed)
    blocked = np.flatnonzero((share < LITTLE) & ~receivers.hidden)
    doublings = receivers.direct_doublings.copy()
    for first in range(0, len(blocked), BLOCKED_AT_ONCE):
        asked = blocked[first : first + BLOCKED_AT_ONCE]
        share[asked] = _clear_share(world, receivers[asked], log2_slit_preview, seed)
        doublings[asked] += _slit_doublings(share[asked])
    exact = closed_forms(world.emitters, receivers.points, receivers.normals)
    return replace(receivers, clear_share=np.where(exact, share, 0.0), direct_doublings=doublings)


def behind_slits(share: FloatArray) -> BoolArray:
    """Say which receivers see a little of what they would without anything between, by their clear share (r,)."""
    return np.asarray((share > 0.0) & (share < LITTLE))


def _slit_doublings(share: FloatArray) -> IntArray:
    """How much more often to sample (r,), by the relative deviation of one ray that comes through or not."""
    seen = np.clip(share, 0.25**SLIT_DOUBLINGS, LITTLE)
    doublings = np.rint(0.5 * np.log2(1.0 / seen - 1.0)).astype(np.int64)
    return np.where(behind_slits(share), np.minimum(doublings, SLIT_DOUBLINGS), 0)


def with_rough_clear_share(
    world: World, receivers: Receivers, *, log2_samples: int, seed: tuple[int, ...]
) -> Receivers:
    """Do as `with_clear_share` with few rays, where there are too many receivers to look for slits."""
    if len(world.emitters.power) > LOCAL_CHOICE_LIMIT:
        return receivers
    exact = closed_forms(world.emitters, receivers.points, receivers.normals)
    share = _clear_share(world, receivers, log2_samples, seed)
    return replace(receivers, clear_share=np.where(exact, share, 0.0))


def _clear_share(world: World, receivers: Receivers, log2_samples: int, seed: tuple[int, ...]) -> FloatArray:
    """Share (r,) of the drawn light that nothing blocks, 0 where none is drawn."""
    drawn, clear = _traced(world, receivers, Stretch.of(log2_samples), seed, unseen())
    weight = drawn.arrivals.radiance_solid_angle.sum(axis=1)
    count = len(receivers)
    total = np.bincount(drawn.arrivals.receiver, weights=weight, minlength=count)
    seen = np.bincount(drawn.arrivals.receiver, weights=weight * clear, minlength=count)
    return np.divide(seen, total, out=np.zeros(count), where=total > 0)


@njit(**COMPILED)
def closed_forms(emitters: Emitters, points: FloatArray, normals: FloatArray) -> BoolArray:
    """Say at which places (r,) the closed form holds."""
    exact = np.empty(len(points), dtype=np.bool_)
    for r in range(len(points)):
        x, y, z = points[r]
        nx, ny, nz = normals[r]
        exact[r] = has_closed_form(emitters, x, y, z, nx, ny, nz)
    return exact


class _Drawn:
    """Shadow rays of a block of receivers: the light each would bring, its two ends and its source.

    ``control`` (k,) is the share of a ray's source that is known, ``known`` (r, C) what that makes at receivers, in lx.
    """

    def __init__(self, room: int, count: int, channels: int) -> None:
        self.arrivals = Arrivals(
            np.empty(room, dtype=np.int64), np.empty((room, 3)), np.empty((room, channels))
        )
        self.origins, self.ends = np.empty((room, 3)), np.empty((room, 3))
        self.housing, self.source = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
        self.control = np.empty(room)
        self.known = np.zeros((count, channels))

    def cut(self, count: int) -> None:
        """Keep the first ``count`` rays."""
        a = self.arrivals
        self.arrivals = Arrivals(a.receiver[:count], a.directions[:count], a.radiance_solid_angle[:count])
        self.origins, self.ends = self.origins[:count], self.ends[:count]
        self.housing, self.source = self.housing[:count], self.source[:count]
        self.control = self.control[:count]


def _traced(
    world: World, receivers: Receivers, samples: Stretch, seed: tuple[int, ...], sight: Shares
) -> tuple[_Drawn, BoolArray]:
    """Draw shadow rays and say of each (k,) whether nothing is in its way."""
    numbers = sobol(3, samples, seed=seed)
    drawn = _Drawn(len(receivers) * len(numbers), len(receivers), world.channels)
    count = _draw_rays(
        world.emitters,
        receivers.points,
        receivers.normals,
        receivers.on_surface,
        numbers,
        receivers.identity,
        receivers.clear_share,
        receivers.rows,
        receivers.known_direct,
        sight,
        hash_of(seed),
        world.caster.offset,
        drawn.source,
        drawn.control,
        drawn.arrivals.receiver,
        drawn.arrivals.directions,
        drawn.arrivals.radiance_solid_angle,
        drawn.origins,
        drawn.ends,
        drawn.housing,
        drawn.known,
    )
    drawn.cut(count)
    return drawn, world.visible(drawn.origins, drawn.ends, housing=drawn.housing)


def _correct(moments: FloatArray, receivers: Receivers, drawn: _Drawn, light: FloatArray) -> None:
    """Add share x (closed form - all samples, blocked or not) of each source to the illuminance; it expects 0."""
    owner = drawn.arrivals.receiver
    cos_theta = np.einsum("kx,kx->k", drawn.arrivals.directions, receivers.normals[owner])
    sampled = np.zeros_like(drawn.known)
    _add_rows(sampled, owner, light * (drawn.control * np.maximum(cos_theta, 0.0))[:, None])
    moments[:, ILLUMINANCE] += drawn.known - sampled


@njit(**LEAF)
def _add_rows(total: FloatArray, owner: IntArray, rows: FloatArray) -> None:
    for k in range(len(owner)):
        for c in range(rows.shape[1]):
            total[owner[k], c] += rows[k, c]


@njit(**COMPILED)
def _draw_rays(
    emitters: Emitters,
    points: FloatArray,
    normals: FloatArray,
    on_surface: BoolArray,
    numbers: FloatArray,
    identity: IntArray,
    clear_share: FloatArray,
    rows: IntArray,
    known_direct: FloatArray,
    sight: Shares,
    key: np.uint64,
    offset: float,
    drawn_source: IntArray,
    drawn_control: FloatArray,
    receiver: IntArray,
    directions: FloatArray,
    light: FloatArray,
    origins: FloatArray,
    ends: FloatArray,
    housing: IntArray,
    known: FloatArray,
) -> int:
    """Draw the shadow rays of each receiver and write what is known of its light; returns how many rays carry some."""
    count = 0
    corners, faces, areas, both_sides = (
        emitters.corners,
        emitters.normals,
        emitters.areas,
        emitters.both_sides,
    )
    triangles = len(corners)
    scratch, shares = np.empty(len(emitters.power)), np.empty(len(emitters.power))
    for r in range(len(points)):
        x, y, z = points[r]
        nx, ny, nz = normals[r]
        row = row_of_sight(sight, rows[r])
        if not choice_cdf(emitters, x, y, z, nx, ny, nz, on_surface[r], row, sight, scratch):
            continue
        # What was found by the guide's sight does not hold without it.
        if clear_share[r] > 0.0 and (row < 0 or np.isnan(known_direct[r, 0])):
            add_known(emitters, points[r], normals[r], row, sight, clear_share[r], shares, known[r])
        elif clear_share[r] > 0.0:
            for c in range(known.shape[1]):
                known[r, c] = known_direct[r, c]
        own = mix(key, np.uint64(identity[r]))
        shifts = (uniform(own, np.uint64(0)), uniform(own, np.uint64(1)), uniform(own, np.uint64(2)))
        for s in range(len(numbers)):
            source, share = chosen(scratch, rotated(numbers[s, 0], shifts[0]))
            u, v = rotated(numbers[s, 1], shifts[1]), rotated(numbers[s, 2], shifts[2])
            if source < triangles:
                d, end, factor, _ = toward_face(
                    corners, faces, areas, both_sides, source, x, y, z, u, v, offset
                )
            else:
                d, end, factor, _ = toward_lamp(emitters, source - triangles, x, y, z, u, v, offset)
            cos_theta = d[0] * nx + d[1] * ny + d[2] * nz
            if factor <= 0.0 or (on_surface[r] and cos_theta <= 0.0):
                continue
            receiver[count], drawn_source[count] = r, source
            drawn_control[count] = known_share(sight, row, source, clear_share[r])
            housing[count] = source_housing(emitters, source)
            directions[count, 0], directions[count, 1], directions[count, 2] = d
            for c in range(light.shape[1]):
                light[count, c] = source_strength(emitters, source, c) * factor / share
            for axis in range(3):
                n = nx if axis == 0 else (ny if axis == 1 else nz)
                o = x if axis == 0 else (y if axis == 1 else z)
                origins[count, axis] = o + offset * n
                ends[count, axis] = end[axis]
            count += 1
    return count
