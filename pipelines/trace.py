"""``lelight render --method trace``: a picture by double local estimation, kept as it grows."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

from lelight.calculation import NOMINAL_RAY_RATE
from lelight.checkpoint.stop import Stop
from lelight.clock import Clock
from lelight.course import Standing
from lelight.doublelocal import DoubleLocal, stored_base, traced_view
from lelight.estimate.variants import VARIANTS
from lelight.field import RadianceField
from lelight.pipelines.render import Colouring, Shot, stored_field, write_picture
from lelight.settings import Settings
from lelight.tracedpicture import REPLICATES, Exposing, Exposure, Taken, picture_effort
from lelight.writing.files import make_folder, safe_name, write_text

#: Where chains start: from what the stored field lacks, or from the emitters as in the method's paper.
Chains = Literal["field", "emitters"]
#: Chains of a replicate of which frames are kept, as power of two: about the 1000 of the paper's figure 7.
LOG2_FRAME_CHAINS = 10
#: Pixels across of the picture by which frames share a scale.
SCALE_PIXELS = 250
#: Seconds between two writings, as multiple of what the last one took.
PAUSES = 4.0


@dataclass(frozen=True)
class Tracing:
    """How a picture is traced.

    Attributes
    ----------
    target, time : relative standard error to reach, seconds to spend; None for none
    chains : where they start
    frames : whether the picture is kept after every step of the first replicate, from the first node on
    seed : int
    """

    target: float | None = None
    time: float | None = None
    chains: Chains = "field"
    frames: bool = False
    seed: int = 0

    @property
    def target_error(self) -> float:
        """Relative standard error to reach, or by which the effort is chosen."""
        return self.target if self.target is not None else Settings().target_error

    @property
    def endless(self) -> bool:
        """Whether neither target nor time was asked for."""
        return self.target is None and self.time is None


def run_trace(
    out: Path,
    shot: Shot,
    tracing: Tracing,
    *,
    colouring: Colouring,
    threads: int = 0,
    stop: Stop,
    progress: Callable[[Standing], None] = lambda _: None,
) -> tuple[Path, Taken]:
    """Write ``OUT/renders/NAME-trace.exr``, ``.hdr`` and ``.png``, and their standard error; better with every step.

    Parameters
    ----------
    stop : interrupts; what the picture was then is kept, and the remark says which one the disk holds
    """
    clock = Clock()
    field = stored_field(out)
    executor = ThreadPoolExecutor(max_workers=Settings(threads=threads).workers)
    if tracing.frames:
        colouring = _on_one_scale(field, shot, colouring, executor)
    keeper = _Keeper(out, shot, tracing, field, colouring, stop)
    try:
        exposing = _exposing(field, shot, tracing, executor)
        if tracing.frames:
            keeper.frame_nodes(exposing)
        for taken in _steps(exposing, tracing, clock):
            progress(_standing(taken, tracing, clock))
            keeper.take(taken, clock)
        keeper.write(clock)
    except KeyboardInterrupt:
        executor.shutdown(wait=False, cancel_futures=True)
        keeper.write(clock)
        raise
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
    assert keeper.taken is not None
    return keeper.stem.with_name(f"{keeper.stem.name}.png"), keeper.taken


def _exposing(field: RadianceField, shot: Shot, tracing: Tracing, executor: Executor) -> Exposing:
    """Set up the estimate and find out how much it should do at a time."""
    on_field = tracing.chains == "field"
    estimate = DoubleLocal(
        view=traced_view(field),
        base=stored_base(field, seed=tracing.seed, executor=executor) if on_field else None,
        variant=VARIANTS["base" if on_field else "emitters"],
        seed=tracing.seed,
        executor=executor,
    )
    exposure = Exposure(shot.camera(field.scene), shot.size, shot.height, shot.samples)
    most_rays = float("inf") if tracing.time is None else NOMINAL_RAY_RATE * tracing.time / REPLICATES
    effort = picture_effort(estimate, exposure, target=tracing.target_error, most_rays=most_rays)
    if tracing.frames:
        effort = replace(effort, log2_chains=LOG2_FRAME_CHAINS)
    return Exposing(estimate, exposure, effort)


def _on_one_scale(field: RadianceField, shot: Shot, colouring: Colouring, executor: Executor) -> Colouring:
    """Give all frames the scale that the stored field's picture has."""
    small = replace(shot, size=min(shot.size, SCALE_PIXELS))
    camera = shot.camera(field.scene)
    luminance = field.picture(camera, small.size, small.height, samples=1, executor=executor)
    return replace(colouring, limits=colouring.limits_of(luminance), decades=None)


def _steps(exposing: Exposing, tracing: Tracing, clock: Clock) -> Iterator[Taken]:
    """Go on until target or time is reached; frames that nobody limits end with the first replicate."""
    target = tracing.target_error if tracing.endless and not tracing.frames else tracing.target
    for taken in exposing.run(target=target, time=tracing.time, clock=lambda: clock.elapsed):
        yield taken
        if tracing.frames and tracing.endless and taken.replicates == 1:
            return


def _standing(taken: Taken, tracing: Tracing, clock: Clock) -> Standing:
    return Standing(
        replicates=taken.replicates,
        doublings=0,
        rays=0,
        seconds=clock.elapsed,
        error=taken.error,
        target=tracing.target_error,
    )


class _Keeper:
    """Keeps the last picture, on disk now and then and at the end.

    Attributes
    ----------
    stem : path of the files without suffix
    taken : the last picture, None before there is one
    """

    def __init__(
        self,
        out: Path,
        shot: Shot,
        tracing: Tracing,
        field: RadianceField,
        colouring: Colouring,
        stop: Stop,
    ) -> None:
        """Write nothing yet."""
        name = shot.seen_by(field.scene).name
        self.stem = make_folder(out / "renders") / f"{safe_name(name)}-trace"
        self.taken: Taken | None = None
        self._title, self._tracing, self._colouring = name, tracing, colouring
        self._stop = stop
        self._camera = shot.camera(field.scene)
        self._written: Taken | None = None
        self._due, self._frames = 0.0, 0

    def take(self, taken: Taken, clock: Clock) -> None:
        """Take a better picture; write it, unless one was written just before."""
        self.taken = taken
        if self._tracing.frames:
            chains = "1 chain" if taken.chains == 1 else f"{taken.chains} chains"
            self._frame(taken, chains)
        if clock.elapsed >= self._due:
            began = clock.elapsed
            self.write(clock)
            self._due = clock.elapsed + PAUSES * (clock.elapsed - began)

    def frame_nodes(self, exposing: Exposing) -> None:
        """Keep what the first node and the first two nodes of the first chain give."""
        for nodes in (1, 2):
            taken = Taken(exposing.first_nodes(nodes), None, None, 1, 0)
            self._frame(taken, f"1 chain, {nodes} node" + "s" * (nodes > 1))

    def write(self, clock: Clock) -> None:
        """Write the last picture, its standard error and what is known about it, unless that was done."""
        taken = self.taken
        if taken is None or taken is self._written:
            return
        write_picture(self.stem, taken.luminance, self._camera, title=self._title, colouring=self._colouring)
        self._stop.remark = f"the picture of {taken.chains} chains is kept in {self.stem}.exr"
        write_text(self.stem.with_name(f"{self.stem.name}.json"), self._record(taken, clock))
        if taken.std_error is not None:
            title = f"{self._title}: standard error"
            beside = self.stem.with_name(f"{self.stem.name}-error")
            write_picture(beside, taken.std_error, self._camera, title=title, colouring=Colouring())
        self._written = taken

    def _frame(self, taken: Taken, told: str) -> None:
        self._frames += 1
        folder = make_folder(self.stem.with_name(f"{self.stem.name}-frames"))
        stem = folder / f"{self._frames:03d} {told}"
        write_picture(
            stem, taken.luminance, self._camera, title=f"{self._title}: {told}", colouring=self._colouring
        )

    def _record(self, taken: Taken, clock: Clock) -> str:
        record: dict[str, Any] = {
            "chains": taken.chains,
            "replicates": taken.replicates,
            "error": None if taken.error is None else asdict(taken.error),
            "target": self._tracing.target_error,
            "target_met": taken.meets(self._tracing.target_error),
            "seconds": clock.elapsed,
            "seed": self._tracing.seed,
            "chains_from": self._tracing.chains,
        }
        return json.dumps(record, indent=1, allow_nan=False) + "\n"
