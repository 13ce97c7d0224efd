"""How often nominal 95 % intervals hold the truth, over many seeds of whole runs.

``python tests/coverage_of.py office --seeds 200 --target 0.03 --edge 0.8 -o runs`` prints a line for nodes, for
the mean and the minimum of each plane and for the UGR of each eye. What is true is the mean over all other seeds,
whose own error widens the interval: with 200 seeds by a quarter of a per cent. Runs are kept in ``runs``; called
again, the command computes those that are missing.
"""

from __future__ import annotations

import argparse
import pickle
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rooms import grey, lit, panel
from scipy.special import stdtrit
from shapes import box, placed

from lelight.calculation import Calculation, calculate
from lelight.metrics.extremes import counted, least
from lelight.metrics.figure import from_replicates
from lelight.metrics.glare import observer_figures
from lelight.pipelines.eyes import sources_seen
from lelight.reading.loading import load
from lelight.scene import FloatArray, MeasuringPlane, Scene
from lelight.settings import Settings

SCENES = Path(__file__).parents[1] / "scenes"
STEPS = 6

#: Values (k,), standard errors (k,) and degrees of freedom.
Stated = tuple[FloatArray, FloatArray, int]


class Kept(NamedTuple):
    """What one run states, by name, and where its visible nodes lie (k,)."""

    stated: dict[str, Stated]
    places: NDArray[np.bytes_]


def stairs() -> Scene:
    """A stairwell 1.2 x 3 x 3 m of six steps 0.3 m wide and 0.2 m high under a panel: corners everywhere."""
    steps = [
        placed(box((1.2, 0.3 * (STEPS - k), 0.2)), shift=(0.0, 1.2 + 0.3 * k, 0.2 * k)) for k in range(STEPS)
    ]
    lamp = panel((0.4, 0.6, 2.99), (0.0, 0.4, 0.0), (0.4, 0.0, 0.0))
    shapes = [box((1.2, 3.0, 3.0)), *steps, lamp]
    walls = [grey(f"surface {k}", 0.6) for k in range(STEPS + 1)]
    scene = lit(*shapes, materials=[*walls, grey("lamp", 0.5, luminance=2000.0)])
    landing = MeasuringPlane(
        "landing", np.array([0.1, 0.1, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    )
    return Scene(**vars(scene) | {"planes": (landing,)})


def scene_of(name: str) -> Scene:
    """A committed scene, or the stairs."""
    return stairs() if name == "stairs" else load(SCENES / f"{name}.toml")


def figures_of(run: Calculation) -> dict[str, Stated]:
    """What a run states of its nodes, planes and eyes."""
    replicates = run.replicates
    nodes = np.flatnonzero(~run.field.mesh.hidden)
    stated = {"nodes": (replicates.mean[nodes], run.field.std_error[nodes], replicates.count - 1)}
    for plane in run.planes:
        name, each = plane.plane.name, plane.replicates
        mean, error = from_replicates(lambda e: float(np.mean(e)), each)
        stated[f"{name}: mean"] = (np.array([mean]), np.array([error]), len(each) - 1)
        minimum, error_of_minimum = least(each)
        if error_of_minimum is not None:
            freedom = counted(len(each)) - 1
            stated[f"{name}: minimum"] = (np.array([minimum]), np.array([error_of_minimum]), freedom)
    for eye in run.observers:
        ugr = observer_figures(eye, sources_seen(run.field, eye.observer))["ugr"]
        if ugr.value is not None and ugr.std_error:
            freedom = replicates.count - 1
            stated[f"{eye.observer.name}: UGR"] = (np.array([ugr.value]), np.array([ugr.std_error]), freedom)
    return stated


def visible_places(run: Calculation) -> NDArray[np.bytes_]:
    """Where the visible nodes lie and what they face, one name (k,) each."""
    mesh = run.field.mesh
    seen = np.flatnonzero(~mesh.hidden)
    columns = np.round(np.concatenate([mesh.positions[seen], mesh.normals[seen]], axis=1), 6) + 0.0
    return np.array([row.tobytes().hex() for row in columns], dtype=np.bytes_)


def coverage(runs: list[Stated]) -> float:
    """Share of intervals, over all seeds and values, that hold the mean of the other seeds."""
    values = np.array([value for value, _, _ in runs])
    count = len(values)
    others = (values.sum(axis=0) - values) / (count - 1)
    error_of_others = values.std(axis=0, ddof=1) / np.sqrt(count - 1)
    held = []
    for (value, error, freedom), truth in zip(runs, others, strict=True):
        reach = stdtrit(freedom, 0.975) * np.hypot(error, error_of_others)
        held.append(np.abs(value - truth) <= reach)
    return float(np.mean(held))


def kept_run(scene: Scene, settings: Settings, folder: Path) -> Kept:
    """What the run of a seed states, computed where no file of it is kept yet."""
    file = folder / f"{settings.seed}.pickle"
    if not file.exists():
        run = calculate(scene, settings)
        half = file.with_suffix(".half")
        half.write_bytes(pickle.dumps((figures_of(run), visible_places(run))))
        half.replace(file)
    return Kept(*pickle.loads(file.read_bytes()))


def nodes_in_common(runs: list[Kept]) -> list[Stated]:
    """What each run states of the nodes that are visible in all.

    The pilot may find a node buried under one seed and not under another.
    """
    shared = reduce(np.intersect1d, [run.places for run in runs])
    chosen = [np.isin(run.places, shared) for run in runs]
    orders = [np.flatnonzero(own)[np.argsort(run.places[own])] for own, run in zip(chosen, runs, strict=True)]
    nodes = [(run.stated["nodes"], order) for run, order in zip(runs, orders, strict=True)]
    return [(value[order], error[order], freedom) for (value, error, freedom), order in nodes]


def main() -> None:
    """Run all seeds and print what was covered."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--target", type=float, default=0.03)
    parser.add_argument("--edge", type=float, default=0.8)
    parser.add_argument("--threads", type=int)
    parser.add_argument("-o", "--folder", type=Path, required=True)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    scene = scene_of(given.scene)
    settings = Settings(target=given.target, edge=given.edge, threads=given.threads)
    runs = [kept_run(scene, replace(settings, seed=seed), given.folder) for seed in range(given.seeds)]
    nodes = nodes_in_common(runs)
    print(f"{given.scene}, target {given.target:.0%}, edge {given.edge} m: {given.seeds} seeds")
    print(f"  {len(nodes[0][0])} nodes: {coverage(nodes):.1%}")
    for name in runs[0].stated.keys() - {"nodes"}:
        stated = [run.stated[name] for run in runs if name in run.stated]
        print(f"  {name}: {coverage(stated):.1%} of {len(stated)}", flush=True)


if __name__ == "__main__":
    main()
