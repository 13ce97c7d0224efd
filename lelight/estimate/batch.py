"""One batch: an unbiased estimate of the light at all receivers by a stretch of one replicate's sequences.

It depends on the run's seed, the replicate and the stretch only. Receivers are worked on in blocks, by as many
threads as there are, and every receiver adds its contributions in the same order whatever the blocks and
threads: the bits do not change.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Executor
from time import perf_counter

import numpy as np

from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import form_of
from lelight.estimate.angular import Collecting
from lelight.estimate.base import BaseField
from lelight.estimate.blocks import CHAINS, Batch, BlockWork, Effort, Site
from lelight.estimate.chainwalk import all_vertices
from lelight.estimate.variants import VARIANTS, Variant
from lelight.receivers import MOMENTS, Receivers
from lelight.scene import IntArray
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World

#: Receivers in a block: enough for coherent rays, few enough for memory and for all threads to have work.
BLOCK = 1024


def estimate_batch(
    world: World,
    receivers: Receivers,
    *,
    effort: Effort,
    seed: tuple[int, int],
    base: BaseField | None,
    detail: Collecting | None,
    executor: Executor,
    doubling: int = 0,
    variant: Variant | None = None,
    keep: Keeper | None = None,
    name: str = "batch",
    room: float = math.inf,
) -> Batch:
    """Estimate once, by the first points of a replicate's sequences or by those of one of their doublings.

    Parameters
    ----------
    seed : the run's seed and the replicate's number
    doubling : 0 for the start, k for the points that double the sequences for the k-th time
    variant : how indirect light is estimated; default split between chains and near field, on the base if any
    base : field on which the estimate stands; without one the chains start at the emitters
    detail : how angular distributions are kept, None where nothing is glossy
    keep, name : remembers what was found under this name, if anything shall
    room : bytes that a block may take while it is worked on; changes no bit
    """
    started = perf_counter()
    keep = keep or Keeper()
    variant = variant or VARIANTS["base" if base is not None else "emitters"]
    site = Site(world, receivers, base, detail, variant, effort)
    vertices = all_vertices(
        world, base, Stretch.of(effort.log2_chains, doubling), variant, (*seed, CHAINS), executor, keep
    )
    chain_seconds = perf_counter() - started
    blocks = list(blocks_of(receivers))
    parts = keep.map(
        executor,
        name,
        BlockWork(site, vertices, seed, doubling, room),
        blocks,
        form_of(Batch),
    )
    batch = _assembled(receivers, blocks, parts, world.channels, detail)
    batch.seconds["chains"] = chain_seconds
    return Batch(
        batch.direct, batch.indirect, batch.angular, len(vertices), batch.rays + len(vertices), batch.seconds
    )


def blocks_of(receivers: Receivers) -> Iterator[IntArray]:
    """Cut receivers into blocks of neighbours that keep the same angular detail, without the hidden ones."""
    for degree in np.unique(receivers.degrees):
        own = np.flatnonzero((receivers.degrees == degree) & ~receivers.hidden)
        for first in range(0, len(own), BLOCK):
            yield own[first : first + BLOCK]


def _assembled(
    receivers: Receivers,
    blocks: list[IntArray],
    parts: Iterator[Batch],
    channels: int,
    detail: Collecting | None,
) -> Batch:
    """Put the blocks back in the receivers' order, with nothing at those of no block."""
    count = len(receivers)
    direct, indirect = np.zeros((count, MOMENTS, channels)), np.zeros((count, MOMENTS, channels))
    detailed = np.cumsum(receivers.degrees > 0) - 1
    width = detail.width if detail is not None else 0
    angular = np.zeros((int(np.count_nonzero(receivers.degrees > 0)) if width else 0, width, channels))
    rays = 0
    seconds: dict[str, float] = {}
    for block, part in zip(blocks, parts, strict=True):
        direct[block], indirect[block] = part.direct, part.indirect
        if len(part.angular):
            angular[detailed[block]] = part.angular
        rays += part.rays
        for stage, spent in part.seconds.items():
            seconds[stage] = seconds.get(stage, 0.0) + spent
    return Batch(direct, indirect, angular, 0, rays, seconds)
