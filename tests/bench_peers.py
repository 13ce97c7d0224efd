"""lelight, Mitsuba 3 and Radiance side by side: whether they agree, and what an error costs in each.

``DRJIT_LIBLLVM_PATH=.../libLLVM-19.so python tests/bench_peers.py office corridor glossy`` prints for a scene the
smallest of 300 p values against its Sidak bound, and a line for each program and setting: error, bias, seconds and
efficiency, 1/(relative rms error² x CPU seconds), medians of interleaved runs. Errors are those of illuminance relative
to max(E, 5 % of the mean), against many paths of Mitsuba whose own noise is taken off. ``--csv FILE`` keeps the
lines, which `plot_peers` draws.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import mitsuba as mi
import numpy as np
from coverage_of import scene_of
from mitsuba_scene import illuminance_by_mitsuba, mitsuba_scene
from radiance_scene import illuminance_by_radiance, radiance_scene, version
from rooms import glossy_room

from lelight.calculation import Calculation, calculate
from lelight.comparison import of_estimates, sidak_level
from lelight.scene import FloatArray, IntArray, Scene
from lelight.settings import Settings

PLACES, ROUNDS = 300, 3
#: Settings of ``rtrace``: fine, quick, and without interpolation.
RADIANCE = (
    "-ab 5 -ad 512 -as 128 -aa 0.2 -ar 64",
    "-ab 3 -ad 256 -aa 0.3 -ar 64",
    "-ab 4 -ad 64 -aa 0 -lw 2e-3",
)
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
    """Do it, and take CPU seconds, of other processes too, and wall seconds."""
    cpu, wall = _cpu_seconds(), time.perf_counter()
    found = work()
    return found, _cpu_seconds() - cpu, time.perf_counter() - wall


def _cpu_seconds() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def row_of(found: FloatArray, cpu: float, wall: float, expected: FloatArray, error: FloatArray) -> FloatArray:
    """Relative rms error without the reference's noise, bias of the mean, CPU and wall seconds, efficiency."""
    scale = np.maximum(expected, DARK_SHARE * expected.mean())
    square = np.mean(((found - expected) / scale) ** 2) - np.mean((error / scale) ** 2)
    bias = found.mean() / expected.mean() - 1.0
    return np.array([np.sqrt(max(square, 0.0)), bias, cpu, wall, 1.0 / (max(square, 1e-12) * cpu)])


def side_by_side(name: str, target: float, folder: Path) -> dict[str, FloatArray]:
    """Print what each program does with a scene: medians by program."""
    scene = glossy_room(0.4, 0.3, 30.0) if name == "glossy" else scene_of(name)
    settings = replace(Settings().over(scene.settings), target=target)
    run = calculate(scene, settings)
    nodes = places_of(run)
    expected, error = reference(scene, run, nodes)
    print(f"{name}: {agreement(run, nodes, expected, error)}", flush=True)
    mesh, built, octree = run.field.mesh, mitsuba_scene(scene), radiance_scene(scene, folder)

    def by_lelight(seed: int) -> FloatArray:
        return calculate(scene, replace(settings, seed=seed)).replicates.mean

    def by_mitsuba(seed: int) -> FloatArray:
        return illuminance_by_mitsuba(built, mesh.positions, mesh.normals, paths=TIMED, seed=100 + seed)

    def by_radiance(options: str) -> Callable[[int], FloatArray]:
        return lambda _seed: illuminance_by_radiance(octree, mesh.positions, mesh.normals, options)

    programs = {f"lelight at {target:.0%}": by_lelight, f"Mitsuba, {TIMED} paths": by_mitsuba}
    programs |= {f"Radiance {options}": by_radiance(options) for options in RADIANCE}
    rows: dict[str, list[FloatArray]] = {told: [] for told in programs}
    for seed in range(ROUNDS):
        for told, work in programs.items():
            found, cpu, wall = timed(lambda work=work, seed=seed: work(seed))
            rows[told].append(row_of(found[nodes], cpu, wall, expected, error))
    medians = {told: np.median(own, axis=0) for told, own in rows.items()}
    for told, (rms, bias, cpu, wall, efficiency) in medians.items():
        print(
            f"{name}, {told}: rms {rms:.2%}, bias {bias:+.2%}, {cpu:.1f} CPU s, {wall:.1f} s, "
            f"efficiency {efficiency:.0f}",
            flush=True,
        )
    return medians


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--target", type=float, default=0.02)
    parser.add_argument("--csv", type=Path)
    given = parser.parse_args()
    print(f"Mitsuba {mi.__version__}, {version()}", flush=True)
    lines = ["scene,program,rms,bias,cpu_s,wall_s,efficiency"]
    for name in given.scenes:
        with TemporaryDirectory() as folder:
            for told, row in side_by_side(name, given.target, Path(folder)).items():
                lines.append(",".join([name, f'"{told}"', *(f"{value:.4g}" for value in row)]))
        if given.csv is not None:
            given.csv.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
