"""What is estimated at one block of receivers, which any worker can do by itself, here or on another machine."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from time import perf_counter

import numpy as np

from lelight.estimate.angular import Collecting
from lelight.estimate.averaged import averaged_estimate
from lelight.estimate.base import BaseField
from lelight.estimate.direct import direct_light
from lelight.estimate.lighttree import TREE_FROM, LightTree
from lelight.estimate.local import Arrivals, LocalEstimate, local_estimate
from lelight.estimate.nearfield import near_field
from lelight.estimate.pathends import PathEnds
from lelight.estimate.thinning import vertices_asked
from lelight.estimate.turns import Turn, turns
from lelight.estimate.variants import Variant
from lelight.estimate.workingset import receivers_at_once
from lelight.receivers import MOMENTS, Receivers
from lelight.scene import FloatArray, IntArray
from lelight.tracing.chains import ChainVertices, hash_of
from lelight.tracing.world import World

#: What tells the random numbers of a batch's parts from each other.
CHAINS, DIRECT, NEAR, DISC, LOBES = 1, 2, 3, 4, 5


@dataclass(frozen=True)
class Effort:
    """How many points the sequences of one replicate start with; every doubling takes as many as there are.

    Attributes
    ----------
    log2_chains : int, chains from the emitters, as power of two
    log2_direct : int, shadow rays to emitters for each receiver, as power of two
    log2_near : int, near-field rays for each receiver, as power of two
    bound : float, 1/m²; b that splits the kernel between chains and near field
    path_bound : float, 1/m²; the same at the surfaces of near paths, 0 where paths go on until they are absorbed
    variance, cost : (3,) float, what trials found of the parts (chains, direct light, near field) for one sample each:
        square of the relative error, and rays a receiver, weighed by how long they take; 0 where nothing was tried
    """

    log2_chains: int
    log2_direct: int
    log2_near: int
    bound: float
    path_bound: float = 0.0
    variance: FloatArray = field(default_factory=lambda: np.zeros(3), compare=False)
    cost: FloatArray = field(default_factory=lambda: np.zeros(3), compare=False)

    @property
    def samples(self) -> FloatArray:
        """Samples (3,) of the parts in one batch."""
        return np.asarray(2.0 ** np.array([self.log2_chains, self.log2_direct, self.log2_near]))


@dataclass(frozen=True)
class Batch:
    """What one batch found at r receivers, g of them with angular detail.

    Attributes
    ----------
    direct, indirect : (r, 6, C) float, moments of light straight from emitters and of all the rest
    angular : (g, width, C) float, or (0, 0, C) where nothing is glossy
    vertices, rays : int, chain vertices and rays of all kinds
    seconds : thread seconds spent on chains, on the pair kernel, on direct light and on the near field
    """

    direct: FloatArray
    indirect: FloatArray
    angular: FloatArray
    vertices: int
    rays: int
    seconds: dict[str, float]

    def halfway_to(self, other: Batch) -> Batch:
        """Mean of what two stretches of as many points found; it takes this one's arrays."""
        for name in ("direct", "indirect", "angular"):
            mean = getattr(self, name)
            mean += getattr(other, name)
            mean *= 0.5
        return self


@dataclass(frozen=True)
class Site:
    """What all batches of a run stand on.

    Attributes
    ----------
    base : field on which the estimate stands, None where chains start at the emitters
    detail : how angular distributions are kept, None where nothing is glossy
    variant : how indirect light is estimated
    """

    world: World
    receivers: Receivers
    base: BaseField | None
    detail: Collecting | None
    variant: Variant
    effort: Effort


@dataclass(frozen=True)
class BlockWork:
    """One batch, to be done block by block.

    Attributes
    ----------
    vertices : of the batch's chains
    seed : the run's seed and the replicate's number
    doubling : 0 for the start, k for the points that double the sequences for the k-th time
    room : bytes that a block may take while it is worked on; changes no bit
    """

    site: Site
    vertices: ChainVertices
    seed: tuple[int, int]
    doubling: int
    room: float

    def __call__(self, block: IntArray) -> Batch:
        """Estimate at some receivers (k,) of one degree, as many of them at once as there is room for."""
        receivers, effort = self.site.receivers[block], self.site.effort
        detailed = self.site.detail is not None and receivers.degrees[0] > 0
        log2_more = max(self.doubling - 1, 0)
        at_once = receivers_at_once(
            receivers,
            self.room,
            log2_direct=effort.log2_direct + log2_more,
            log2_near=effort.log2_near + log2_more,
            vertices=len(self.vertices),
            channels=self.site.world.channels,
            kept=self.site.detail.width if self.site.detail is not None and detailed else 0,
        )
        return stacked([self._piece(piece) for piece in receivers.chunks(at_once)])

    @cached_property
    def ends(self) -> PathEnds | None:
        """What near paths end on, the same for all blocks."""
        return path_ends(self.site.world, self.site.base, self.vertices, self.site.effort.path_bound)

    @cached_property
    def tree(self) -> LightTree | None:
        """Tree of the vertices, where there are enough of them and receivers ask some only."""
        if len(self.vertices) < TREE_FROM or not self.site.variant.bounded:
            return None
        return LightTree.of(self.site.world, self.vertices)

    def _piece(self, receivers: Receivers) -> Batch:
        """Let chains, emitters and near surfaces light some receivers."""
        site, effort, seed, doubling = self.site, self.site.effort, self.seed, self.doubling
        times = [perf_counter()]
        chains = chain_light(
            site.world,
            receivers,
            self.vertices,
            site.variant,
            bound=effort.bound,
            seed=(*seed, DISC, doubling),
            tree=self.tree,
        )
        times.append(perf_counter())
        direct, direct_rays = _direct(site.world, receivers, effort, doubling, (*seed, DIRECT), site.base)
        times.append(perf_counter())
        near = _near(
            site.world, receivers, effort, site.variant, doubling, (*seed, NEAR), site.base, self.ends
        )
        times.append(perf_counter())
        if site.detail is not None and receivers.degrees[0] > 0:
            arrivals = chains.arrivals + near.arrivals
            angular = site.detail.collect(receivers, arrivals, seed=(*seed, LOBES, doubling))
        else:
            angular = np.zeros((0, 0, site.world.channels))
        times.append(perf_counter())
        spent = dict(zip(("kernel", "direct", "near_field", "angular"), np.diff(times).tolist(), strict=True))
        rays = chains.rays + direct_rays + near.rays
        return Batch(direct, chains.moments + near.moments, angular, 0, rays, spent)


def stacked(parts: list[Batch]) -> Batch:
    """Put what was found at pieces of a block one after the other."""
    if len(parts) == 1:
        return parts[0]
    seconds: dict[str, float] = {}
    for part in parts:
        for stage, spent in part.seconds.items():
            seconds[stage] = seconds.get(stage, 0.0) + spent
    return Batch(
        direct=np.concatenate([part.direct for part in parts]),
        indirect=np.concatenate([part.indirect for part in parts]),
        angular=np.concatenate([part.angular for part in parts]),
        vertices=0,
        rays=sum(part.rays for part in parts),
        seconds=seconds,
    )


def chain_light(
    world: World,
    receivers: Receivers,
    vertices: ChainVertices,
    variant: Variant,
    *,
    bound: float,
    seed: tuple[int, ...],
    tree: LightTree | None = None,
) -> LocalEstimate:
    """Light that chains give receivers: by the bounded kernel, thinned out, or by the raw one, or around them."""
    bound = variant.chain_bound(bound)
    if variant.averaged:
        return averaged_estimate(world, receivers, vertices=vertices, seed=seed)
    if not variant.bounded:
        return local_estimate(world, receivers, vertices=vertices, bound=bound)
    asked = vertices_asked(len(vertices), by_tree=tree is not None)
    return local_estimate(
        world, receivers, vertices=vertices, bound=bound, asked=asked, key=hash_of(seed), tree=tree
    )


def _direct(
    world: World,
    receivers: Receivers,
    effort: Effort,
    doubling: int,
    seed: tuple[int, ...],
    base: BaseField | None,
) -> tuple[FloatArray, int]:
    """Direct light of a block (r, 6, C), sampled as often as each receiver needs, and the rays it took."""
    moments = np.zeros((len(receivers), MOMENTS, world.channels))
    rays, guide = 0, base.guide if base is not None else None
    for together in turns(effort.log2_direct + receivers.direct_doublings, doubling):
        for turn in together:
            found, traced = direct_light(
                world, receivers[turn.own], samples=turn.samples, seed=seed, guide=guide
            )
            moments[turn.own] += turn.share * found
            rays += traced
    return moments, rays


def near_light(
    world: World,
    receivers: Receivers,
    together: tuple[Turn, ...],
    variant: Variant,
    *,
    bound: float,
    seed: tuple[int, ...],
    base: BaseField | None,
    ends: PathEnds | None,
) -> LocalEstimate:
    """Light that rays from the receivers bring, which is what the variant's chains leave out."""
    if variant.near == "none":
        return LocalEstimate(np.zeros((len(receivers), MOMENTS, world.channels)), (), 0)
    bound = variant.near_bound(bound)
    return LocalEstimate(
        *near_field(world, receivers, bound=bound, together=together, seed=seed, base=base, ends=ends)
    )


def path_ends(world: World, base: BaseField | None, vertices: ChainVertices, bound: float) -> PathEnds | None:
    """Let paths end where there is a base and a bound that is worth it."""
    return PathEnds.of(world, base, vertices, bound) if base is not None and bound > 0.0 else None


def _near(
    world: World,
    receivers: Receivers,
    effort: Effort,
    variant: Variant,
    doubling: int,
    seed: tuple[int, ...],
    base: BaseField | None,
    ends: PathEnds | None,
) -> LocalEstimate:
    """Near field of a block, sampled as often as each receiver needs."""
    moments = np.zeros((len(receivers), MOMENTS, world.channels))
    arrivals: list[Arrivals] = []
    rays = 0
    for together in turns(effort.log2_near + receivers.near_doublings, doubling):
        found = near_light(
            world, receivers, together, variant, bound=effort.bound, seed=seed, base=base, ends=ends
        )
        moments += found.moments
        arrivals += found.arrivals
        rays += found.rays
    return LocalEstimate(moments, tuple(arrivals), rays)
