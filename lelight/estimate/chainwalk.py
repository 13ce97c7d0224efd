"""The chains of one batch: from the emitters, or from what a base field lacks."""

from __future__ import annotations

from concurrent.futures import Executor

from lelight.checkpoint.keeper import Keeper
from lelight.estimate.base import BaseField
from lelight.estimate.defect import defect_chains
from lelight.estimate.variants import Variant
from lelight.tracing.chains import ChainVertices, emission_chains, joined, no_vertices
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World

#: Chains walked at once, a power of two; bounds memory, and is part of what their numbers depend on.
CHAINS_AT_ONCE = 4096


def all_vertices(
    world: World,
    base: BaseField | None,
    chains: Stretch,
    variant: Variant,
    seed: tuple[int, ...],
    executor: Executor,
    keep: Keeper,
) -> ChainVertices:
    """Walk the chains of a batch, so many at once, by as many threads as there are.

    Parameters
    ----------
    seed : that of `chain_vertices`
    """
    parts = list(chains.parts(CHAINS_AT_ONCE))
    under_way = [executor.submit(chain_vertices, world, base, part, variant, seed=seed) for part in parts]
    found = [keep.awaited(future) for future in under_way]
    shares = [part.count / chains.count for part in parts]
    return joined([part.with_flux(share * part.flux) for part, share in zip(found, shares, strict=True)])


def chain_vertices(
    world: World, base: BaseField | None, chains: Stretch, variant: Variant, *, seed: tuple[int, ...]
) -> ChainVertices:
    """Walk the chains of a batch: from the emitters, or from what a base field lacks."""
    if not variant.chains:
        return no_vertices(world.channels)
    if base is None:
        return emission_chains(world, chains, seed=seed, nodes=variant.nodes)
    return defect_chains(world, base, chains, seed=seed)
