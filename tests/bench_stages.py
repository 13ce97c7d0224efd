"""Where the time of a run goes. Run by hand: ``python tests/bench_stages.py office corridor --target 0.02``.

One thread, so that seconds are those of a processor. Rays are embree's calls, whoever makes them; what is left of
each part is everything around its rays.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from coverage_of import scene_of

from lelight.calculation import calculate
from lelight.estimate import batch, blocks
from lelight.settings import Settings
from lelight.tracing.rays import RayCaster

#: Parts of the estimate, by the functions that do them.
PARTS = {
    "pairs": (blocks, "chain_light"),
    "direct light": (blocks, "_direct"),
    "near field": (blocks, "_near"),
}
CHAINS = (batch, "all_vertices")


class Watch:
    """Seconds by name; what is timed inside something else is taken off that."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self.rays = 0
        self._inner: list[float] = [0.0]

    def timed(self, name: str, work: Callable[..., Any]) -> Callable[..., Any]:
        """Do the work and keep its seconds."""

        def watched(*arguments: Any, **named: Any) -> Any:
            began = time.perf_counter()
            self._inner.append(0.0)
            try:
                return work(*arguments, **named)
            finally:
                spent = time.perf_counter() - began
                self.seconds[name] += spent - self._inner.pop()
                self._inner[-1] += spent

        return watched


class WatchedScene:
    """Embree's scene, its calls timed."""

    def __init__(self, scene: Any, watch: Watch) -> None:
        self._run, self._watch = watch.timed("rays", scene.run), watch

    def run(self, origins: Any, directions: Any, **options: Any) -> Any:
        """Trace, and count."""
        self._watch.rays += len(origins)
        return self._run(origins, directions, **options)


@contextmanager
def watched(watch: Watch) -> Iterator[None]:
    """Time embree and the parts of the estimate."""
    made = RayCaster.__init__
    kept = {place: getattr(*place) for place in [*PARTS.values(), CHAINS]}

    def make(self: RayCaster, *arguments: Any) -> None:
        made(self, *arguments)
        self._scene = WatchedScene(self._scene, watch)

    RayCaster.__init__ = make  # type: ignore[method-assign]
    for name, place in [*PARTS.items(), ("chains", CHAINS)]:
        setattr(*place, watch.timed(name, kept[place]))
    try:
        yield
    finally:
        RayCaster.__init__ = made  # type: ignore[method-assign]
        for place, work in kept.items():
            setattr(*place, work)


def table(name: str, target: float) -> list[str]:
    """Rows of the stages of one run."""
    scene = scene_of(name)
    calculate(scene, Settings(target=0.2, threads=1))  # compiles
    watch = Watch()
    with watched(watch):
        began = time.perf_counter()
        run = calculate(scene, Settings(target=target, threads=1))
        whole = time.perf_counter() - began
    stages = {stage: spent for stage, spent in run.seconds.items() if stage != "estimate"}
    rows = [f"{name}, {len(run.field.mesh)} nodes, {watch.rays / 1e6:.0f} million rays, {whole:.1f} s"]
    rows += [
        f"  before and after: {stage} | {spent:.2f} s | {spent / whole:.0%}"
        for stage, spent in stages.items()
    ]
    estimate = run.seconds["estimate"]
    rows += [f"  estimate | {estimate:.2f} s | {estimate / whole:.0%}"]
    for part, spent in watch.seconds.items():
        where = "all embree, also before" if part == "rays" else "of the estimate, without rays"
        rows.append(f"  {part} ({where}) | {spent:.2f} s | {spent / whole:.0%}")
    return rows


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--target", type=float, default=0.02)
    given = parser.parse_args()
    for name in given.scenes:
        print("\n".join(table(name, given.target)), flush=True)


if __name__ == "__main__":
    main()
