"""How fast pairs of vertices and receivers are done: beside bare shadow rays, on two threads, and as vertices multiply.

Run by hand: ``pytest tests/bench_pairs.py -s``. Ratios are of medians of interleaved runs; thread seconds where one
thread works, wall seconds where two do.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path

import numpy as np

from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.estimate.chainwalk import chain_vertices
from lelight.estimate.lighttree import TREE_FROM, LightTree
from lelight.estimate.local import VERTEX_CHUNK, local_estimate
from lelight.estimate.pairs import off_surfaces, scanned_pairs
from lelight.estimate.thinning import Thinning
from lelight.estimate.variants import VARIANTS
from lelight.preparation import Stage, prepare
from lelight.reading.loading import load
from lelight.receivers import ILLUMINANCE, Receivers
from lelight.settings import Settings
from lelight.tracing.chains import ChainVertices, hash_of
from lelight.tracing.sobol import Stretch

SCENE = Path(__file__).parents[1] / "scenes" / "corridor.toml"
BOUND = 0.6
ROUNDS = 15
RECEIVERS = 1024
#: Vertices that a receiver asks, however many there are.
ASKED = 128.0


@lru_cache
def stage() -> Stage:
    """The corridor, whose surfaces are all Lambertian."""
    with ThreadPoolExecutor(2) as executor:
        return prepare(load(SCENE), Settings(target=0.02), executor, Keeper())


def vertices_of(log2_chains: int, seed: int) -> ChainVertices:
    base = stage().base
    return chain_vertices(stage().world, base, Stretch.of(log2_chains), VARIANTS["base"], seed=(0, seed, 1))


def neighbours(first: int) -> Receivers:
    """Some of the visible nodes that lie together."""
    seen = np.flatnonzero(~stage().mesh.hidden)
    return stage().receivers[seen[first : first + RECEIVERS]]


def interleaved(*works: Callable[[], object], clock: Callable[[], float]) -> list[float]:
    """Median seconds of each work, all of them in turn."""
    spent: list[list[float]] = [[] for _ in works]
    for each in works:
        each()
    for _ in range(ROUNDS):
        for own, work in zip(spent, works, strict=True):
            began = clock()
            work()
            own.append(clock() - began)
    return [float(np.median(own)) for own in spent]


def shadow_rays(receivers: Receivers, vertices: ChainVertices) -> list[tuple[np.ndarray, np.ndarray]]:
    """Rays of all pairs that face each other, as the pair kernel traces them."""
    world = stage().world
    thinning = Thinning.of(world, receivers, vertices, bound=BOUND, asked=np.inf, key=hash_of((1,)))
    ends = off_surfaces(world, vertices, receivers)
    chunks = [slice(first, first + VERTEX_CHUNK) for first in range(0, len(vertices), VERTEX_CHUNK)]
    found = [
        scanned_pairs(world, receivers, vertices, chunk, bound=BOUND, thinning=thinning, off_surfaces=ends)
        for chunk in chunks
    ]
    return [(pairs.origins.copy(), pairs.segments.copy()) for pairs in found]


def test_pairs_beside_bare_shadow_rays():
    world, vertices, receivers = stage().world, vertices_of(7, 1), neighbours(0)
    rays = shadow_rays(receivers, vertices)
    count = sum(len(origins) for origins, _ in rays)
    bare, whole = interleaved(
        lambda: [world.caster.unblocked(*each) for each in rays],
        lambda: local_estimate(world, receivers, vertices=vertices, bound=BOUND),
        clock=time.thread_time,
    )
    print(
        f"\n{count} pairs: {1e-6 * count / whole:.1f} M/s, bare rays {1e-6 * count / bare:.1f} M/s: {bare / whole:.3f}"
    )
    assert bare / whole > 0.7


def test_two_threads_beside_one():
    """No more can be had than bare rays gain on the machine."""
    world, vertices = stage().world, vertices_of(7, 1)
    blocks = [neighbours(first) for first in range(0, 6 * RECEIVERS, RECEIVERS)]
    rays = [shadow_rays(own, vertices) for own in blocks]

    def pairs(own: Receivers) -> None:
        local_estimate(world, own, vertices=vertices, bound=BOUND)

    def bare(own: list[tuple[np.ndarray, np.ndarray]]) -> None:
        for each in own:
            world.caster.unblocked(*each)

    def by_threads(work: Callable[..., None], parts: list, threads: int) -> Callable[[], None]:
        def run() -> None:
            with ThreadPoolExecutor(threads) as executor:
                list(executor.map(work, parts))

        return run

    works = [by_threads(*work, threads) for work in ((pairs, blocks), (bare, rays)) for threads in (1, 2)]
    one, two, bare_one, bare_two = interleaved(*works, clock=time.perf_counter)
    print(
        f"\ntwo threads: {one / two:.2f} times as fast as one, bare rays {bare_one / bare_two:.2f}; "
        f"pairs at {bare_two / two:.3f} of the rate of bare rays"
    )


def test_vertices_times_64():
    """Time and noise of the chains' part with 64 times the vertices, all choosing by the tree."""
    world, receivers, batches = stage().world, neighbours(0), 4
    few = vertices_of(5, 0)
    local_estimate(
        world, receivers, vertices=few, bound=BOUND, asked=8.0, tree=LightTree.of(world, few)
    )  # compiles
    print()
    for log2_chains in (10, 13, 16):
        sets = [vertices_of(log2_chains, seed) for seed in range(batches)]
        began = time.thread_time()
        trees = [LightTree.of(world, vertices) for vertices in sets]
        built = (time.thread_time() - began) / batches
        began = time.thread_time()
        found = [
            local_estimate(
                world,
                receivers,
                vertices=vertices,
                bound=BOUND,
                asked=ASKED,
                key=hash_of((k,)),
                tree=tree,
            )
            for k, (vertices, tree) in enumerate(zip(sets, trees, strict=True))
        ]
        spent = (time.thread_time() - began) / batches
        light = np.array([luminance_weighted(each.moments[:, ILLUMINANCE]) for each in found])
        scatter = float(np.sqrt(light.var(axis=0, ddof=1).mean()))
        rays = np.mean([each.rays for each in found]) / len(receivers)
        print(
            f"{len(sets[0]):8d} vertices (from {TREE_FROM} on by the tree): {1e6 * spent / len(receivers):6.1f} us a "
            f"receiver, {rays:.0f} rays, tree {1e3 * built:.0f} ms, scatter {scatter:.4f} lx"
        )
