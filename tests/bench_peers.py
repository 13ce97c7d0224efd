"""lelight, Mitsuba 3 and Radiance side by side: whether they agree, and what an error costs in each.

``DRJIT_LIBLLVM_PATH=.../libLLVM-19.so python tests/bench_peers.py office corridor glossy`` prints for a scene the
smallest p value of many nodes against its Sidak bound, and a line for each program and setting: error, bias, seconds
and efficiency, 1/(relative rms error² x CPU seconds), of interleaved runs: root mean square of their errors, medians of
the rest. Errors are those of illuminance relative to max(E, 5 % of the mean), against many paths of Mitsuba whose own
noise is taken off. ``--csv FILE`` keeps the lines, which `plot_peers` draws.

Radiance runs once, or not at all (``--without-radiance``; where all is gloss its fine setting takes long). Without
interpolation (``-aa 0``) a place costs the same whatever the others are: it is then asked at the compared nodes only,
and its seconds are those times all nodes over them.

``hall --target 0.05 --rounds 1`` is the library hall of 277 240 triangles. Mitsuba's rays start off surfaces by a
share of their coordinates, 3 mm at 30 m, which is more than the gap between two books: its reference is computed
with every place moved to the origin. Radiance with interpolation is left out, it would take hours for so many nodes.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

import mitsuba as mi
import numpy as np
from coverage_of import SCENES, scene_of
from mitsuba_scene import illuminance_by_mitsuba, mitsuba_scene
from radiance_scene import illuminance_by_radiance, radiance_scene, version
from rooms import glossy_room

from lelight.calculation import Calculation, calculate
from lelight.comparison import of_estimates, sidak_level
from lelight.mesh.nodes import NodeMesh
from lelight.reading.loading import load
from lelight.scene import FloatArray, IntArray, Scene
from lelight.settings import Settings

Found = TypeVar("Found")

#: Nodes that are compared: few of them carry much of the error. Fewer where each is moved to the origin, which is where
#: coordinates exceed so many m.
PLACES, MOVED_PLACES, FAR = 2000, 300, 20.0
ROUNDS = 3
#: Most nodes for Radiance with interpolation.
MOST_FOR_RADIANCE = 50_000
#: Settings of ``rtrace``: fine and quick with interpolation, quick and fine without.
RADIANCE = (
    "-ab 5 -ad 512 -as 128 -aa 0.2 -ar 64",
    "-ab 3 -ad 256 -aa 0.3 -ar 64",
    "-ab 4 -ad 64 -aa 0 -lw 2e-3",
    "-ab 8 -ad 1024 -as 0 -aa 0 -lw 1e-6 -ds 0.05 -dt 0 -dc 1",
)
EVERY_PLACE_ANEW = "-aa 0 "
#: Paths a place of the reference, in so many batches; of a timed run at every node.
BATCHES, IN_BATCH, TIMED = 16, 2048, 64
DARK_SHARE = 0.05


def places_of(run: Calculation) -> IntArray:
    """Draw nodes (k,) that are seen, at random."""
    seen = np.flatnonzero(~run.field.mesh.hidden)
    wanted = MOVED_PLACES if far(run.scene) else PLACES
    return np.random.default_rng(7).choice(seen, min(wanted, len(seen)), replace=False)


def far(scene: Scene) -> bool:
    """Say whether the scene reaches so far that Mitsuba's rays start too far off surfaces."""
    return bool(np.abs(scene.vertices).max() > FAR)


def reference(scene: Scene, run: Calculation, nodes: IntArray) -> tuple[FloatArray, FloatArray]:
    """Illuminance and its standard error (k,) in lx by many paths of Mitsuba."""
    points, normals = run.field.mesh.positions[nodes], run.field.mesh.normals[nodes]
    if far(scene):
        parts = [_at_origin(scene, *place) for place in zip(points, normals, strict=True)]
        batches = np.concatenate(parts, axis=1)
    else:
        built = mitsuba_scene(scene)
        batches = np.array(
            [
                illuminance_by_mitsuba(built, points, normals, paths=IN_BATCH, seed=seed)
                for seed in range(BATCHES)
            ]
        )
    return np.mean(batches, axis=0), np.std(batches, axis=0, ddof=1) / np.sqrt(BATCHES)


def _at_origin(scene: Scene, point: FloatArray, normal: FloatArray) -> FloatArray:
    """Batches (BATCHES, 1) of the illuminance of one place, moved to the origin with all of the scene."""
    built = mitsuba_scene(replace(scene, vertices=scene.vertices - point))
    here, same = np.zeros((BATCHES, 3)), np.tile(normal, (BATCHES, 1))
    return illuminance_by_mitsuba(built, here, same, paths=IN_BATCH, seed=0)[:, None]


def scene_for(name: str, folder: Path) -> Scene:
    """A committed scene, a room that is all glossy, or the hall, written into the folder."""
    if name == "glossy":
        return glossy_room(0.4, 0.3, 30.0)
    if name == "hall":
        subprocess.run([sys.executable, SCENES / "make_hall.py", folder], check=True)
        return load(folder / "hall.toml")
    return scene_of(name)


def agreement(run: Calculation, nodes: IntArray, expected: FloatArray, error: FloatArray) -> str:
    """Compare place by place, by Welch's t."""
    freedom = [np.full(len(nodes), count - 1.0) for count in (BATCHES, run.replicates.count)]
    found = of_estimates(expected, run.replicates.mean[nodes], error, run.field.std_error[nodes], *freedom)
    p, difference, bound = found.p_values, found.difference, sidak_level(len(nodes))
    return (
        f"smallest p {p.min():.2g}, bound {bound:.2g}: {'agree' if p.min() > bound else 'DIFFER'}; "
        f"p < 0.05 at {np.mean(p < 0.05):.1%}; mean difference {difference.mean() / expected.mean():+.3%}"
    )


def timed(work: Callable[[], Found]) -> tuple[Found, float, float]:
    """Do it, and take CPU seconds, of other processes too, and wall seconds."""
    cpu, wall = _cpu_seconds(), time.perf_counter()
    found = work()
    return found, _cpu_seconds() - cpu, time.perf_counter() - wall


def _cpu_seconds() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def row_of(found: FloatArray, cpu: float, wall: float, expected: FloatArray, error: FloatArray) -> FloatArray:
    """Square of the relative rms error without the reference's noise, bias of the mean, CPU and wall seconds."""
    scale = np.maximum(expected, DARK_SHARE * expected.mean())
    square = np.mean(((found - expected) / scale) ** 2) - np.mean((error / scale) ** 2)
    bias = found.mean() / expected.mean() - 1.0
    return np.array([square, bias, cpu, wall])


def summed_up(rows: list[FloatArray]) -> FloatArray:
    """Relative rms error, bias of the mean, CPU and wall seconds, and efficiency of several runs."""
    square = max(float(np.mean([row[0] for row in rows])), 1e-12)
    bias, cpu, wall = np.median(rows, axis=0)[1:]
    return np.array([np.sqrt(square), bias, cpu, wall, 1.0 / (square * cpu)])


def side_by_side(
    name: str, target: float, rounds: int, folder: Path, *, radiance: bool
) -> dict[str, FloatArray]:
    """Print what each program does with a scene, and return it. The first run is the first round's."""
    scene = scene_for(name, folder)
    settings = replace(Settings().over(scene.settings), target=target)
    run, *spent = timed(lambda: calculate(scene, settings))
    nodes = places_of(run)
    expected, error = reference(scene, run, nodes)
    print(f"{name}: {agreement(run, nodes, expected, error)}", flush=True)
    mesh, built = run.field.mesh, mitsuba_scene(scene)
    by_lelight_name = f"lelight at {target:.0%}"

    def by_lelight(seed: int) -> FloatArray:
        return calculate(scene, replace(settings, seed=seed)).replicates.mean[nodes]

    def by_mitsuba(seed: int) -> FloatArray:
        found = illuminance_by_mitsuba(built, mesh.positions, mesh.normals, paths=TIMED, seed=100 + seed)
        return found[nodes]

    rows: dict[str, list[FloatArray]] = {by_lelight_name: [], f"Mitsuba, {TIMED} paths": []}
    for seed in range(rounds):
        for (told, own), work in zip(rows.items(), (by_lelight, by_mitsuba), strict=True):
            if seed == 0 and told == by_lelight_name:
                found, cpu, wall = run.replicates.mean[nodes], *spent
            else:
                found, cpu, wall = timed(lambda work=work, seed=seed: work(seed))
            own.append(row_of(found, cpu, wall, expected, error))
    for options, found, cpu, wall in by_radiance(scene, mesh, nodes, folder) if radiance else ():
        rows[f"Radiance {options}"] = [row_of(found, cpu, wall, expected, error)]
    found_by = {told: summed_up(own) for told, own in rows.items()}
    for told, (rms, bias, cpu, wall, efficiency) in found_by.items():
        print(
            f"{name}, {told}: rms {rms:.2%}, bias {bias:+.2%}, {cpu:.1f} CPU s, {wall:.1f} s, "
            f"efficiency {efficiency:.0f}",
            flush=True,
        )
    return found_by


def by_radiance(
    scene: Scene, mesh: NodeMesh, nodes: IntArray, folder: Path
) -> Iterator[tuple[str, FloatArray, float, float]]:
    """Settings of Radiance, illuminance (k,) at the compared nodes, and CPU and wall seconds for all nodes."""
    octree = radiance_scene(scene, folder)
    for options in RADIANCE:
        anew = EVERY_PLACE_ANEW in options
        if not anew and len(mesh) > MOST_FOR_RADIANCE:
            continue
        asked = nodes if anew else np.arange(len(mesh))
        points, normals = mesh.positions[asked], mesh.normals[asked]
        found, cpu, wall = timed(
            lambda given=(points, normals, options): illuminance_by_radiance(octree, *given)
        )
        share = len(asked) / len(mesh)
        yield options, found if anew else found[nodes], cpu / share, wall / share


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--target", type=float, default=0.02)
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--without-radiance", action="store_true")
    given = parser.parse_args()
    print(f"Mitsuba {mi.__version__}, {version()}", flush=True)
    lines = ["scene,program,rms,bias,cpu_s,wall_s,efficiency"]
    for name in given.scenes:
        with TemporaryDirectory() as folder:
            found = side_by_side(
                name, given.target, given.rounds, Path(folder), radiance=not given.without_radiance
            )
            for told, row in found.items():
                lines.append(",".join([name, f'"{told}"', *(f"{value:.4g}" for value in row)]))
        if given.csv is not None:
            given.csv.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
