"""How the error falls with samples and with the edge, and what quasi-random numbers save.

    python tests/bench_convergence.py [SCENE...]

Prints two tables. By samples: rms over nodes of the relative standard deviation of one replicate, for chains, direct
light and near field doubled together; its slope in log-log; variance with pseudo-random over that with Sobol numbers at
the most samples, for direct light, indirect light and both. By edge: rms of interpolation between nodes, over the mean.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from unittest import mock

import numpy as np
from rooms import furnace, glossy_room, grey, lamp, lit
from shapes import box

from lelight.calculation import calculate
from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.estimate.batch import estimate_batch
from lelight.estimate.blocks import Effort
from lelight.estimate.effort import LEAST, bound_for
from lelight.estimate.replicates import DARK_SHARE
from lelight.preparation import Stage, prepare
from lelight.reading.loading import load
from lelight.receivers import ILLUMINANCE
from lelight.scene import FloatArray, Scene
from lelight.settings import Settings
from lelight.tracing.sobol import Stretch

FOLDER = Path(__file__).parents[1] / "scenes"
SCENES: dict[str, Callable[[], Scene]] = {
    "furnace": lambda: furnace(0.5),
    "sphere": lambda: load(FOLDER / "sphere90.toml"),
    "sobolev": lambda: load(FOLDER / "sobolev_offset.toml"),
    "cornell": lambda: load(FOLDER / "cornell.toml"),
    "glossy room": lambda: glossy_room(0.4, 0.3, 16.0),
    "corridor": lambda: load(FOLDER / "corridor.toml"),
    "office": lambda: load(FOLDER / "office.toml"),
}
#: Modules that draw from Sobol sequences.
DRAWING = ("lelight.tracing.chains", "lelight.estimate.nearfield", "lelight.estimate.direct")
NODES, REPLICATES, DOUBLINGS = 300, 16, 5
EDGES = (1.0, 0.5, 0.25, 0.125)


def pseudo_random(dimensions: int, stretch: Stretch, *, seed: tuple[int, ...]) -> FloatArray:
    """Draw what `sobol` would, independently."""
    return np.random.default_rng((*seed, stretch.first)).random((stretch.count, dimensions))


@contextmanager
def numbers(kind: str) -> Iterator[None]:
    """Let the estimate draw Sobol or pseudo-random numbers."""
    with ExitStack() as stack:
        for module in DRAWING if kind == "pseudo-random" else ():
            stack.enter_context(mock.patch(f"{module}.sobol", pseudo_random))
        yield


def light(stage: Stage, executor: Executor, doublings: int) -> FloatArray:
    """Direct and indirect illuminance (2, REPLICATES, k), lx, at some nodes."""
    visible = np.flatnonzero(~stage.mesh.hidden)
    receivers = stage.receivers[visible[:: max(1, len(visible) // NODES)]]
    chains, direct, near = (least + doublings for least in LEAST)
    effort = Effort(chains, direct, near, bound_for(stage.world.area, 1024.0))
    batches = [
        estimate_batch(
            stage.world,
            receivers,
            effort=effort,
            seed=(0, k),
            base=stage.base,
            detail=None,
            executor=executor,
            variant=stage.variant,
        )
        for k in range(REPLICATES)
    ]
    parts = np.array([[b.direct[:, ILLUMINANCE], b.indirect[:, ILLUMINANCE]] for b in batches])
    return np.asarray(np.moveaxis(luminance_weighted(parts), 1, 0))


def variances(stage: Stage, executor: Executor, doublings: int) -> FloatArray:
    """Variance (3,) of direct, indirect and all light, relative at each node, mean over nodes."""
    parts = light(stage, executor, doublings)
    both = parts.sum(axis=0)
    mean = both.mean(axis=0)
    floor = np.maximum(mean, DARK_SHARE * mean.mean())
    return np.array([np.mean(each.var(axis=0, ddof=1) / floor**2) for each in (*parts, both)])


def by_samples(name: str, executor: Executor) -> None:
    """Print errors, slope and gain of one scene."""
    stage = prepare(SCENES[name](), Settings(target=0.1), executor, Keeper())
    found = {}
    for kind in ("pseudo-random", "Sobol"):
        with numbers(kind):
            found[kind] = np.array([variances(stage, executor, k) for k in range(DOUBLINGS + 1)])
    for kind, variance in found.items():
        errors = np.sqrt(variance[:, 2])
        slope = np.polyfit(np.arange(len(errors)) * np.log(2), np.log(errors), 1)[0]
        print(f"{name:12} {kind:14} " + " ".join(f"{e:8.3%}" for e in errors) + f"  slope {slope:+.2f}")
    gains = found["pseudo-random"][-1] / np.maximum(found["Sobol"][-1], np.finfo(float).tiny)
    print(
        f"{name:12} gain           "
        + ", ".join(f"{part} {g:.1f}" for part, g in zip(("direct", "indirect", "all"), gains, strict=True)),
        flush=True,
    )


def by_edge(reflectance: float) -> None:
    """Print the error of interpolation in a room under one lamp, by edge, and its slopes."""
    room = lit(
        box((4.0, 5.0, 3.0)),
        materials=[grey("surface", reflectance)],
        luminaires=(lamp((1.7, 2.2, 1.6)),),
    )
    errors = []
    for edge in EDGES:
        found = calculate(room, Settings(edge=edge, target=0.005, time=60.0)).interpolation
        assert found is not None
        errors.append(found.rms)
    slopes = np.diff(np.log(errors)) / np.diff(np.log(EDGES))
    print(
        f"reflectance {reflectance}: "
        + ", ".join(f"{edge} m {error:.3%}" for edge, error in zip(EDGES, errors, strict=True))
        + "; slopes "
        + ", ".join(f"{slope:.2f}" for slope in slopes),
        flush=True,
    )


def main() -> None:
    """Print both tables."""
    with ThreadPoolExecutor(2) as executor:
        for name in sys.argv[1:] or SCENES:
            by_samples(name, executor)
    for reflectance in (0.0, 0.5):
        by_edge(reflectance)


if __name__ == "__main__":
    main()
