"""How much to do in a batch: tried out on small batches, so that rays go where the noise is.

The error of a batch has three parts, the chains', the emitters' and the near field's. Trial batches tell the
variance of each at every receiver. Receivers sample direct light and near field in proportion to the root of
their variance, and so do the parts to the root of their variance over cost: that reaches a given error with
the fewest rays. The trials are no part of the result, so it stays unbiased.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from lelight.channels import luminance_weighted
from lelight.estimate.base import BaseField
from lelight.estimate.batch import CHAINS, DIRECT, NEAR, Effort, blocks_of, chain_vertices
from lelight.estimate.direct import direct_light
from lelight.estimate.local import local_estimate
from lelight.estimate.nearfield import near_field
from lelight.estimate.replicates import DARK_SHARE
from lelight.receivers import ILLUMINANCE, Receivers
from lelight.scene import FloatArray, IntArray
from lelight.tracing.world import World

#: Trial batches, and the samples of each part in one, as powers of two.
TRIALS = 8
TRIAL = (4, 3, 4)
#: Batches that the chosen effort should need; more than the least, so that the stop is close to the target.
WANTED_BATCHES = 12
#: A shadow ray of the pair kernel is coherent with its neighbours; others cost about this much more.
INCOHERENT_COST = 2.5
#: Most that a receiver's samples are doubled or halved.
MOST_DOUBLINGS = 3
#: How much the variance found at one receiver in a few trials is drawn toward that of all.
CAUTION = 0.2
#: Bound of the split for chains that carry only what a base lacks, against that for chains that carry all.
BASE_BOUND_FACTOR = 0.2
#: Least samples of the parts in a batch, and most, as powers of two.
LEAST, MOST = (5, 2, 2), 16
#: Seeds of trials are apart from those of batches.
TRIAL_SEED = 1 << 20


@dataclass(frozen=True)
class Spread:
    """Noise of the parts of the estimate for one sample each: chains, direct light, near field.

    Attributes
    ----------
    variance : (3, r) float, square of the relative error at each receiver
    cost : (3,) float, rays a receiver
    """

    variance: FloatArray
    cost: FloatArray


def bound_for(area: float, chains: float, *, on_base: bool) -> float:
    """Bound b in 1/m² of the split kernel: 1/(4 s)², s the spacing of chains on the scene's area."""
    return chains / (16.0 * area) * (BASE_BOUND_FACTOR if on_base else 1.0)


def choose_effort(
    world: World,
    receivers: Receivers,
    *,
    base: BaseField | None,
    areas: FloatArray,
    target: float,
    seed: int,
    executor: Executor,
) -> tuple[Effort, Receivers]:
    """Pick the effort of a batch such that about a dozen of them reach ``target``.

    Parameters
    ----------
    areas : (r,) float, m²; weights of the receivers in the error, 0 for those that do not count
    target : float, relative standard error

    Returns
    -------
    effort : of one batch
    receivers : the same, each with its own share of the samples
    """
    chains = 1024.0 if base is not None else 8192.0
    bound = bound_for(world.area, chains, on_base=base is not None)
    spread = _spread(world, receivers, base, bound, areas, seed, executor)
    direct, near = _doublings(spread.variance[1]), _doublings(spread.variance[2])
    spent = np.stack([np.ones(len(receivers)), 2.0**direct, 2.0**near])
    variance = np.average(spread.variance / spent, axis=1, weights=areas)
    samples = _samples(variance, spread.cost * spent.mean(axis=1), target)
    log2 = [round(float(np.log2(max(1.0, count / WANTED_BATCHES)))) for count in samples]
    log2_chains, log2_direct, log2_near = np.clip(log2, LEAST, MOST).tolist()
    bound = bound_for(world.area, WANTED_BATCHES * 2.0**log2_chains, on_base=base is not None)
    effort = Effort(log2_chains, log2_direct, log2_near, bound)
    return effort, replace(receivers, direct_doublings=direct, near_doublings=near)


def _doublings(variance: FloatArray) -> IntArray:
    """How often to double each receiver's samples (r,), by the root of its variance."""
    typical = float(variance.mean())
    if not typical > 0.0:
        return np.zeros(len(variance), dtype=np.int64)
    share = np.sqrt((1.0 - CAUTION) * variance + CAUTION * typical)
    doublings = np.rint(np.log2(share / share.mean()))
    return np.asarray(np.clip(doublings, -MOST_DOUBLINGS, MOST_DOUBLINGS), dtype=np.int64)


def _samples(variance: FloatArray, cost: FloatArray, target: float) -> FloatArray:
    """Count the samples of each part (3,) that together reach the target with the fewest rays."""
    variance, cost = np.maximum(variance, 1e-12), np.maximum(cost, 1e-3)
    return np.asarray(np.sqrt(variance / cost) * np.sqrt(variance * cost).sum() / target**2)


def _spread(
    world: World,
    receivers: Receivers,
    base: BaseField | None,
    bound: float,
    areas: FloatArray,
    seed: int,
    executor: Executor,
) -> Spread:
    """Try a few small batches at all receivers."""
    chains = [
        chain_vertices(world, base, log2_chains=TRIAL[0], seed=(seed, TRIAL_SEED + k, CHAINS))
        for k in range(TRIALS)
    ]
    light = np.zeros((TRIALS, len(TRIAL), len(receivers)))
    rays = np.zeros(len(TRIAL))

    def try_block(block: IntArray) -> FloatArray:
        spent = np.zeros(len(TRIAL))
        for k, vertices in enumerate(chains):
            own = receivers[block]
            of_chains = local_estimate(world, own, vertices=vertices, bound=bound)
            direct, direct_rays = direct_light(
                world, own, log2_samples=TRIAL[1], seed=(seed, TRIAL_SEED + k, DIRECT)
            )
            near, _, near_rays = near_field(
                world, own, bound=bound, log2_samples=TRIAL[2], seed=(seed, TRIAL_SEED + k, NEAR), base=base
            )
            for part, moments in enumerate((of_chains.moments, direct, near)):
                light[k, part, block] = luminance_weighted(moments[:, ILLUMINANCE])
            spent += np.array([of_chains.rays, INCOHERENT_COST * direct_rays, INCOHERENT_COST * near_rays])
        return spent

    for spent in executor.map(try_block, list(blocks_of(receivers.degrees))):
        rays += spent
    samples = 2.0 ** np.array(TRIAL)
    mean = light.sum(axis=1).mean(axis=0)
    floor = np.maximum(mean, DARK_SHARE * np.average(mean, weights=areas))
    relative = light.var(axis=0, ddof=1) / np.maximum(floor, np.finfo(float).tiny) ** 2
    return Spread(relative * samples[:, None], rays / (TRIALS * len(receivers) * samples))
