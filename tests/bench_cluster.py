"""What other processes cost against threads: ``python tests/bench_cluster.py [SCENE] [TARGET] [ROUNDS]``.

Threads and local clusters of 1, 2 and 4 compute the same in turn; printed are medians of the whole and of the estimate
in wall seconds, and their ratios to as many threads. All point arrays have to be the same to the bit.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace

import numpy as np
from coverage_of import scene_of

from lelight.calculation import Calculation, calculate
from lelight.scene import Scene
from lelight.settings import Settings

CREWS: dict[str, dict[str, object]] = {
    "threads 1": {"threads": 1},
    "threads 2": {"threads": 2},
    "local:1": {"threads": 1, "cluster": "local:1"},
    "local:2": {"threads": 2, "cluster": "local:2"},
    "local:4": {"threads": 2, "cluster": "local:4"},
}


def timed(scene: Scene, settings: Settings, crew: str) -> tuple[Calculation, float, float]:
    """Compute with a crew: what was found, wall seconds of all and of the estimate."""
    begun = time.perf_counter()
    found = calculate(scene, replace(settings, **CREWS[crew]))
    return found, time.perf_counter() - begun, found.seconds["estimate"]


def main(name: str = "office", target: float = 0.02, rounds: int = 3) -> None:
    """Print a line a crew."""
    scene = scene_of(name)
    settings = replace(Settings().over(scene.settings), target=target)
    first, _, _ = timed(scene, settings, "threads 2")
    seconds: dict[str, list[tuple[float, float]]] = {crew: [] for crew in CREWS}
    for _ in range(rounds):
        for crew, taken in seconds.items():
            found, whole, estimate = timed(scene, settings, crew)
            taken.append((whole, estimate))
            same = np.array_equal(found.field.values.illuminance, first.field.values.illuminance)
            same &= np.array_equal(found.field.std_error, first.field.std_error)
            if not same:
                raise SystemExit(f"{crew}: other bits")
    for crew, taken in seconds.items():
        whole, estimate = np.median(taken, axis=0)
        print(f"{name} {target:g} {crew}: {whole:.1f} s in all, estimate {estimate:.1f} s", flush=True)


if __name__ == "__main__":
    given = sys.argv[1:]
    main(*given[:1], *(float(each) for each in given[1:2]), *(int(each) for each in given[2:3]))
