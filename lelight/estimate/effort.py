"""How much to do in a batch: tried out on small batches, so that rays go where the noise is.

The error of a batch has three parts, the chains', the emitters' and the near field's. Trial batches tell the
variance of each at every receiver. Receivers sample direct light and near field in proportion to the root of
their variance times a power of the area that they stand for, and the parts to the root of their variance over cost:
that reaches a given error with the fewest rays. The trials are no part of the result, so it stays unbiased.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import form_of
from lelight.estimate.base import BaseField
from lelight.estimate.batch import blocks_of
from lelight.estimate.blocks import CHAINS, DIRECT, DISC, NEAR, Effort, chain_light, near_light, path_ends
from lelight.estimate.chainwalk import chain_vertices
from lelight.estimate.direct import behind_slits, direct_light
from lelight.estimate.pathends import PathEnds, path_bound
from lelight.estimate.replicates import DARK_SHARE, LEAST_REPLICATES
from lelight.estimate.turns import Turn
from lelight.estimate.variants import VARIANTS, Variant
from lelight.mesh.neighbours import alike, half_pooled, most_alike
from lelight.receivers import ILLUMINANCE, Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import ChainVertices
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World

#: Trial batches, and the samples of each part in one, as powers of two. A trial's chains are the same for all
#: receivers, which therefore do not tell their variance together: of chains there are more trials, at fewer receivers.
TRIALS, CHAIN_TRIALS, CHAIN_RECEIVERS = 4, 24, 2048
TRIAL = (4, 2, 3)
#: Chains that near paths of the trials end on, as power of two.
LOG2_ENDS = 8
#: A shadow ray of the pair kernel is coherent with its neighbours and has little beside it; others cost about so many
#: times more, with all that is done for them (office, near field: 0.11 and 0.54 µs).
INCOHERENT_COST = 5.0
#: What a vertex costs at a receiver without a ray, in such rays; and what the start of a chain costs that carries what
#: a base lacks, for all receivers together (225 µs).
PAIR_COST, START_COST = 0.05, 2000.0
#: Most that a receiver's samples are doubled, and halved.
MOST_DOUBLINGS, MOST_HALVINGS = 4, 2
#: How much the variance found at one receiver in a few trials is drawn toward that of all: rare bright paths
#: may have missed it in the trials and will not in the run.
CAUTION = 0.1
#: A receiver's variance counts times this power of the area that it stands for. One would serve the error that a run is
#: asked for, which goes by area, none the mean over all nodes. In a library hall, where books have small nodes and
#: walls large ones, a third leaves 0.64 and 0.47 of the variance by area (near field, direct light) that none leaves,
#: and adds 7 and 11 % to that of the mean node.
AREA_POWER = 1.0 / 3.0
#: Bounds of the split that are tried, against that of 1024 chains, and receivers they are tried on.
BOUNDS_ON_BASE = (0.1, 0.4, 1.6, 6.4)
BOUNDS_OF_EMITTERS = (0.8, 6.4)
#: Likewise where lamps make spots on surfaces: chains start there, and paths of the near field miss them.
BOUNDS_WITH_SPOTS = (6.4, 51.2)
BOUND_RECEIVERS = 512
#: Least samples of the parts in a batch, and most, as powers of two.
LEAST, MOST = (5, 2, 2), 16
#: How much larger batches may be than asked for, and the share of the rays that must be left for that to be worth it.
LARGER_BATCHES, WORTH = (2.0, 4.0), 0.97
#: Receivers on surfaces that are tried: one in so many, but these at the least and these at the most.
#: Each of the others samples like the nearest that was.
ONE_TRIED_IN, LEAST_TRIED, MOST_TRIED = 3, 1 << 14, 1 << 17
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

    def shared_out(
        self, direct: IntArray, near: IntArray, areas: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Variance (3,) and cost (3,) of the parts when receivers double their samples as told."""
        spent = np.stack([np.ones(len(direct)), 2.0**direct, 2.0**near])
        return np.average(self.variance / spent, axis=1, weights=areas), self.cost * spent.mean(axis=1)


def bound_for(area: float, chains: float) -> float:
    """Bound b in 1/m² of the split kernel: 1/(4 s)², s the spacing of the chains' feet on the scene's area."""
    return chains / (16.0 * area)


def choose_effort(
    world: World,
    receivers: Receivers,
    *,
    base: BaseField | None,
    areas: FloatArray,
    target: float,
    most_rays: float,
    batches: float,
    seed: int,
    executor: Executor,
    variant: Variant | None = None,
    keep: Keeper | None = None,
) -> tuple[Effort, Receivers]:
    """Pick the effort of a batch such that about so many of them reach ``target``.

    Parameters
    ----------
    areas : (r,) float, m²; weights of the receivers in the error, 0 for those that do not count
    target : float, relative standard error
    most_rays : float, rays that a batch may take at the most; inf where there is no clock
    batches : float, how many the effort is shared out over
    keep : remembers what was found, if anything shall

    Returns
    -------
    effort : of one batch
    receivers : the same, each with its own share of the samples
    """
    variant = variant or VARIANTS["base" if base is not None else "emitters"]
    asked = int(np.count_nonzero(~receivers.hidden))
    trials = _Trials(world, base, variant, seed, executor, keep or Keeper(), asked)

    def choose() -> _Chosen:
        return _chosen(trials, receivers, areas, target, most_rays, batches)

    chosen = trials.keep.once("effort", choose, form_of(_Chosen))
    shared_out = replace(
        receivers,
        direct_doublings=receivers.direct_doublings + _but_for_slits(receivers, chosen.direct),
        near_doublings=receivers.near_doublings + chosen.near,
    )
    return chosen.effort, shared_out


def _but_for_slits(receivers: Receivers, doublings: IntArray) -> IntArray:
    """Doublings (r,) less those of receivers behind slits, which sample more often by what many rays have told."""
    return np.where(behind_slits(receivers.clear_share), np.minimum(doublings, 0), doublings)


@dataclass(frozen=True)
class _Chosen:
    """Effort of a batch, and how often each receiver (r,) doubles its samples of direct light and near field."""

    effort: Effort
    direct: IntArray
    near: IntArray


@dataclass(frozen=True)
class _Trials:
    """What small batches are tried on, and by whom, for a run that asks so many receivers."""

    world: World
    base: BaseField | None
    variant: Variant
    seed: int
    executor: Executor
    keep: Keeper
    receivers: int

    @cached_property
    def chains(self) -> list[ChainVertices]:
        """Chains of each trial, the same for all bounds."""
        return [
            chain_vertices(
                self.world,
                self.base,
                Stretch.of(TRIAL[0]),
                self.variant,
                seed=(self.seed, TRIAL_SEED + k, CHAINS),
            )
            for k in range(CHAIN_TRIALS)
        ]

    @cached_property
    def ends(self) -> PathEnds | None:
        """What near paths end on: more chains than are tried, lest their noise be taken for that of the paths."""
        if self.base is None:
            return None
        seed, chains = (self.seed, TRIAL_SEED + CHAIN_TRIALS, CHAINS), Stretch.of(LOG2_ENDS)
        vertices = chain_vertices(self.world, self.base, chains, self.variant, seed=seed)
        return path_ends(self.world, self.base, vertices, path_bound(self.world, vertices))


def _chosen(
    trials: _Trials,
    receivers: Receivers,
    areas: FloatArray,
    target: float,
    most_rays: float,
    batches: float,
) -> _Chosen:
    bound = bound_for(trials.world.area, 1024.0)
    if trials.variant.near == "rest":
        bound = _best_bound(trials, receivers, areas)
    tried = _to_be_tried(receivers)
    some = receivers[tried]
    chains = CHAIN_TRIALS if len(tried) < 2 * CHAIN_RECEIVERS else TRIALS
    spread = _spread(trials, "all", some, bound, areas[tried], chains=chains)
    spread = replace(spread, variance=half_pooled(spread.variance, _around(some, areas[tried] > 0.0)))
    direct, near = (_doublings(part, some, areas[tried]) for part in spread.variance[1:])
    variance, cost = spread.shared_out(direct, near, areas[tried])
    if chains < CHAIN_TRIALS:
        few = _strewn(np.flatnonzero(areas > 0.0), CHAIN_RECEIVERS)
        of_chains = _spread(trials, "chains", receivers[few], bound, areas[few])
        variance[0], cost[0] = np.average(of_chains.variance[0], weights=areas[few]), of_chains.cost[0]
    samples = _batch_samples(variance, cost, target, batches=batches, most=most_rays / trials.receivers)
    log2 = [int(each) for each in np.log2(samples)]
    effort = Effort(
        log2_chains=log2[0],
        log2_direct=log2[1],
        log2_near=log2[2],
        bound=bound,
        path_bound=trials.ends.bound if trials.ends is not None else 0.0,
        variance=variance,
        cost=cost,
    )
    if len(tried) < len(receivers):
        own = most_alike(receivers.points, receivers.normals, tried)
        direct, near = direct[own], near[own]
    return _Chosen(effort, direct, near)


def _to_be_tried(receivers: Receivers) -> IntArray:
    """Choose the receivers (k,) that a trial asks: all in space, of those on surfaces as many as are enough."""
    on_surface = np.flatnonzero(receivers.on_surface & ~receivers.hidden)
    wanted = min(max(len(on_surface) // ONE_TRIED_IN, LEAST_TRIED), MOST_TRIED)
    some = _strewn(on_surface, wanted)
    return np.sort(np.concatenate([some, np.flatnonzero(~receivers.on_surface)]))


def _strewn(receivers: IntArray, count: int) -> IntArray:
    """Choose so many of them, one anywhere in every stretch, since nodes follow each other in patterns.

    One in four nodes of a library hall, in step, is the same corner of every book.
    """
    if count >= len(receivers):
        return receivers
    places = np.arange(count) + np.random.default_rng(count).random(count)
    return np.asarray(receivers[(places * (len(receivers) / count)).astype(np.int64)])


def _around(receivers: Receivers, weighed: BoolArray) -> IntArray:
    """Neighbours (k, 7) of receivers, of those that have a weight (k,) among their like, of the others among theirs."""
    weighty, others = (
        alike(receivers.points, receivers.normals, left_out=left_out) for left_out in (~weighed, weighed)
    )
    return np.where(weighed[:, None], weighty, others)


def _best_bound(trials: _Trials, receivers: Receivers, areas: FloatArray) -> float:
    """Bound that asks for the fewest rays, among a few, tried on some of the receivers."""
    world, base = trials.world, trials.base
    chosen = _strewn(np.flatnonzero(areas > 0.0), BOUND_RECEIVERS)
    few = receivers[chosen]
    factors = BOUNDS_OF_EMITTERS if base is None else BOUNDS_ON_BASE
    factors = BOUNDS_WITH_SPOTS if base is not None and base.spots else factors
    bounds = [factor * bound_for(world.area, 1024.0) for factor in factors]
    work = []
    for number, bound in enumerate(bounds):
        spread = _spread(trials, f"bound {number}", few, bound, areas[chosen])
        own = areas[chosen]
        direct, near = (_doublings(part, few, own) for part in spread.variance[1:])
        variance, cost = spread.shared_out(direct, near, own)
        work.append(float(np.sqrt(variance * cost).sum()))
    return bounds[int(np.argmin(work))]


def _doublings(variance: FloatArray, receivers: Receivers, areas: FloatArray) -> IntArray:
    """How often to double each receiver's samples (r,), by the root of its variance and by its area if it has one.

    Points of planes and eyes count for themselves, also where they are so dark that they hardly count among all: they
    sample no less than the rest.
    """
    weighed = areas > 0.0
    typical = float(variance[weighed].mean())
    if not typical > 0.0:
        return np.zeros(len(variance), dtype=np.int64)
    weight = np.ones(len(areas))
    weight[weighed] = (areas[weighed] / areas[weighed].mean()) ** AREA_POWER
    share = np.sqrt(((1.0 - CAUTION) * variance + CAUTION * typical) * weight)
    doublings = np.rint(np.log2(share / share[weighed].mean()))
    least = np.where(receivers.on_surface, -MOST_HALVINGS, 0)
    return np.asarray(np.clip(doublings, least, MOST_DOUBLINGS), dtype=np.int64)


def _samples(variance: FloatArray, cost: FloatArray, target: float) -> FloatArray:
    """Count the samples of each part (3,) that together reach the target with the fewest rays."""
    variance, cost = np.maximum(variance, 1e-12), np.maximum(cost, 1e-3)
    return np.asarray(np.sqrt(variance / cost) * np.sqrt(variance * cost).sum() / target**2)


def _batch_samples(
    variance: FloatArray, cost: FloatArray, target: float, *, batches: float, most: float = np.inf
) -> FloatArray:
    """Share the samples out over batches: those (3,) of each part in one, powers of two within bounds.

    Where a part has its least and would do with fewer, batches are larger if that takes fewer rays in all, since the
    other parts then have their share; but never so large that replicates are too few.

    Parameters
    ----------
    most : float, rays of a receiver in a batch
    """
    samples = _samples(variance, cost, target)
    samples *= min(1.0, batches * most / float(samples @ cost))
    chosen = _within_bounds(samples / batches)
    for factor in LARGER_BATCHES:
        larger = _within_bounds(factor * samples / batches)
        fits = _batches(variance, larger, target) >= LEAST_REPLICATES and cost @ larger <= most
        if fits and _rays(variance, cost, larger) < WORTH * _rays(variance, cost, chosen):
            chosen = larger
    return chosen


def _within_bounds(samples: FloatArray) -> FloatArray:
    """Round samples (3,) of the parts in a batch to powers of two."""
    return np.asarray(2.0 ** np.clip(np.rint(np.log2(np.maximum(samples, 1.0))), LEAST, MOST))


def _batches(variance: FloatArray, samples: FloatArray, target: float) -> float:
    """Count the batches of so many samples (3,) that reach a target."""
    return float(np.sum(variance / samples)) / target**2


def _rays(variance: FloatArray, cost: FloatArray, samples: FloatArray) -> float:
    """Rays of a receiver that batches of so many samples (3,) need for a variance of one."""
    return float(np.sum(variance / samples) * (cost @ samples))


def batches_for(effort: Effort, target: float, *, batches: float) -> tuple[float, FloatArray]:
    """Batches that a run to a target takes if it is sized for so many, and samples (3,) of the parts in one.

    A batch has its least samples, so a loose target may need fewer batches, but never fewer than a run has replicates.
    The trials of the effort tell.
    """
    samples = _batch_samples(effort.variance, effort.cost, target, batches=batches)
    return max(_batches(effort.variance, samples, target), float(LEAST_REPLICATES)), samples


def least_error(effort: Effort) -> float:
    """Relative error of the shortest run there is, with the least samples in a batch, by the trials of an effort."""
    return float(np.sqrt(np.sum(effort.variance / 2.0 ** np.array(LEAST)) / LEAST_REPLICATES))


@dataclass(frozen=True)
class _Tried:
    """What trials found at a block of receivers.

    Attributes
    ----------
    chains : (t, b) float, light that they give in each trial
    own : (TRIALS, 2, b) float, direct light and near field
    rays : (3,) float, that a trial of each part took
    """

    chains: FloatArray
    own: FloatArray
    rays: FloatArray


def _spread(
    trials: _Trials,
    name: str,
    receivers: Receivers,
    bound: float,
    areas: FloatArray,
    *,
    chains: int = CHAIN_TRIALS,
) -> Spread:
    """Try a few small batches at all receivers, so many times the chains."""
    blocks = list(blocks_of(receivers))
    parts = trials.keep.map(
        trials.executor,
        f"effort/{name}",
        lambda block: _tried(trials, receivers[block], bound, chains),
        blocks,
        form_of(_Tried),
    )
    by_chains, own = np.zeros((chains, len(receivers))), np.zeros((TRIALS, 2, len(receivers)))
    rays = np.zeros(len(TRIAL))
    for block, tried in zip(blocks, parts, strict=True):
        by_chains[:, block], own[:, :, block] = tried.chains, tried.own
        rays += tried.rays
    samples = 2.0 ** np.array(TRIAL)
    mean = by_chains.mean(axis=0) + own.sum(axis=1).mean(axis=0)
    floor = np.maximum(mean, DARK_SHARE * np.average(mean, weights=areas))
    variance = np.concatenate([by_chains.var(axis=0, ddof=1)[None], own.var(axis=0, ddof=1)])
    relative = variance / np.maximum(floor, np.finfo(float).tiny) ** 2
    cost = rays / (len(receivers) * samples)
    cost[0] += START_COST / trials.receivers if trials.base is not None else 0.0
    return Spread(relative * samples[:, None], cost)


def _tried(trials: _Trials, receivers: Receivers, bound: float, chains: int) -> _Tried:
    """Try a few small batches at a block of receivers."""
    world, base, variant, seed = trials.world, trials.base, trials.variant, trials.seed
    guide = base.guide if base is not None else None
    by_chains, own = np.zeros((chains, len(receivers))), np.zeros((TRIALS, 2, len(receivers)))
    rays = np.zeros(len(TRIAL))
    for k, vertices in enumerate(trials.chains[:chains]):
        lit = chain_light(world, receivers, vertices, variant, bound=bound, seed=(seed, TRIAL_SEED + k, DISC))
        by_chains[k] = luminance_weighted(lit.moments[:, ILLUMINANCE])
        rays[0] += (lit.rays + PAIR_COST * len(vertices) * len(receivers)) / chains
    at_once = Turn.of_all(Stretch.of(TRIAL[2]), len(receivers))
    for k in range(TRIALS):
        trial = (seed, TRIAL_SEED + k)
        direct, direct_rays = direct_light(
            world, receivers, samples=Stretch.of(TRIAL[1]), seed=(*trial, DIRECT), guide=guide
        )
        near = near_light(
            world,
            receivers,
            (at_once,),
            variant,
            bound=bound,
            seed=(*trial, NEAR),
            base=base,
            ends=trials.ends,
        )
        for part, moments in enumerate((direct, near.moments)):
            own[k, part] = luminance_weighted(moments[:, ILLUMINANCE])
        rays[1:] += INCOHERENT_COST / TRIALS * np.array([direct_rays, near.rays])
    return _Tried(by_chains, own, rays)
