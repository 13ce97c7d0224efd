"""lelight and Mitsuba 3 side by side: whether they agree, and what an error costs in each.

``DRJIT_LIBLLVM_PATH=.../libLLVM-19.so python tests/bench_peers.py office corridor glossy`` prints two lines a scene:
the smallest of 300 p values against its Sidak bound, and efficiencies, 1/(relative rms error² x CPU seconds), of
interleaved runs. Errors are those of illuminance relative to max(E, 5 % of the mean), against many paths of Mitsuba
whose own noise is taken off.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from coverage_of import scene_of
from mitsuba_scene import illuminance_by_mitsuba, mitsuba_scene
from rooms import glossy_room

from lelight.calculation import Calculation, calculate
from lelight.comparison import of_estimates, sidak_level
from lelight.scene import FloatArray, IntArray, Scene
from lelight.settings import Settings

PLACES, ROUNDS = 300, 3
#: Paths a place of the reference, in so many batches; of a timed run at every node.
BATCHES, IN_BATCH, TIMED = 16, 2048, 64
DARK_SHARE = 0.05


def places_of(run: Calculation) -> IntArray:
    """Draw nodes (k,) that are seen, at random."""
    seen = np.flatnonzero(~run.field.mesh.hidden)
    return np.random.default_rng(7).choice(seen, min(PLACES, len(seen)), replace=False)


def reference(scene: Scene, run: Calculation, nodes: IntArray) -> tuple[FloatArray, FloatArray]:
    """Illuminance and its standard error (k,) in lx by many paths of Mitsuba."""
    mesh, built = run.field.mesh, mitsuba_scene(scene)
    points, normals = mesh.positions[nodes], mesh.normals[nodes]
    batches = [
        illuminance_by_mitsuba(built, points, normals, paths=IN_BATCH, seed=seed) for seed in range(BATCHES)
    ]
    return np.mean(batches, axis=0), np.std(batches, axis=0, ddof=1) / np.sqrt(BATCHES)


def agreement(run: Calculation, nodes: IntArray, expected: FloatArray, error: FloatArray) -> str:
    """Compare place by place, by Welch's t."""
    freedom = [np.full(len(nodes), count - 1.0) for count in (BATCHES, run.replicates.count)]
    found = of_estimates(expected, run.replicates.mean[nodes], error, run.field.std_error[nodes], *freedom)
    p, difference, bound = found.p_values, found.difference, sidak_level(len(nodes))
    return (
        f"smallest p {p.min():.2g}, bound {bound:.2g}: {'agree' if p.min() > bound else 'DIFFER'}; "
        f"p < 0.05 at {np.mean(p < 0.05):.1%}; mean difference {difference.mean() / expected.mean():+.3%}"
    )


def timed(work: Callable[[], FloatArray]) -> tuple[FloatArray, float, float]:
    """Do it, and take CPU and wall seconds."""
    cpu, wall = time.process_time(), time.perf_counter()
    found = work()
    return found, time.process_time() - cpu, time.perf_counter() - wall


def efficiency(found: FloatArray, cpu: float, expected: FloatArray, error: FloatArray) -> tuple[float, float]:
    """Relative rms error without the reference's noise, and 1/(error² x CPU seconds)."""
    scale = np.maximum(expected, DARK_SHARE * expected.mean())
    square = np.mean(((found - expected) / scale) ** 2) - np.mean((error / scale) ** 2)
    return float(np.sqrt(max(square, 0.0))), float(1.0 / (max(square, 1e-12) * cpu))


def side_by_side(name: str, target: float) -> None:
    """Print both lines of a scene."""
    scene = glossy_room(0.4, 0.3, 30.0) if name == "glossy" else scene_of(name)
    settings = replace(Settings().over(scene.settings), target=target)
    run = calculate(scene, settings)
    nodes = places_of(run)
    expected, error = reference(scene, run, nodes)
    print(f"{name}: {agreement(run, nodes, expected, error)}", flush=True)
    mesh, built = run.field.mesh, mitsuba_scene(scene)
    rows = []
    for seed in range(ROUNDS):
        ours, ours_cpu, ours_wall = timed(
            lambda seed=seed: calculate(scene, replace(settings, seed=seed)).replicates.mean[nodes]
        )
        theirs, cpu, wall = timed(
            lambda seed=seed: illuminance_by_mitsuba(
                built, mesh.positions, mesh.normals, paths=TIMED, seed=100 + seed
            )[nodes]
        )
        rows.append(
            (
                *efficiency(ours, ours_cpu, expected, error),
                ours_wall,
                *efficiency(theirs, cpu, expected, error),
                wall,
            )
        )
    middle = np.median(rows, axis=0)
    print(
        f"{name}: lelight {middle[0]:.2%} in {middle[2]:.1f} s, efficiency {middle[1]:.0f}; "
        f"Mitsuba {middle[3]:.2%} in {middle[5]:.1f} s, efficiency {middle[4]:.0f}; ratio {middle[1] / middle[4]:.2f}",
        flush=True,
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--target", type=float, default=0.02)
    given = parser.parse_args()
    for scene_name in given.scenes:
        side_by_side(scene_name, given.target)
