"""From a scene to its light: the route of the whole program, stage by stage."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace

import numpy as np

from lelight.checkpoint.keeper import Keeper
from lelight.clock import Clock
from lelight.cluster import cluster_executor
from lelight.course import Course, Standing, course_form
from lelight.estimate.angular import AngularDetail, angular_detail
from lelight.estimate.batch import estimate_batch
from lelight.estimate.blocks import Batch, Effort
from lelight.estimate.effort import choose_effort
from lelight.estimate.interpolation import InterpolationError
from lelight.estimate.replicates import ErrorReached, Replicates, error_reached
from lelight.estimate.samplingplan import SamplingPlan, StartingCells
from lelight.estimate.schedule import WANTED_BATCHES, Step, next_step
from lelight.field import RadianceField
from lelight.memory import allowed_memory, require_fitting, room_of_blocks
from lelight.mesh.doubles import without_repeated_faces
from lelight.outcome import (
    found_at_eyes,
    found_at_probes,
    found_field,
    found_on_planes,
    std_error_of_nodes,
)
from lelight.plan import Plan
from lelight.preparation import Stage, prepare
from lelight.reach import without_dark_lamps
from lelight.reading.loading import require_light
from lelight.receivers import Receivers
from lelight.results import ObserverValues, PlaneValues
from lelight.scene import Scene
from lelight.settings import Settings
from lelight.soundness import (
    require_sound_base,
    require_sound_batch,
    require_sound_mesh,
    require_sound_results,
)

#: Rays a second that a clock is taken to stand for where no short run has told.
NOMINAL_RAY_RATE = 1e6
#: Batches that shall at least fit into the time asked for.
LEAST_BATCHES_IN_TIME = 16
#: Batches that an effort is shared out over where a run makes exactly so many replicates without doubling.
BATCHES_WITHOUT_DOUBLING = 12


@dataclass(frozen=True)
class Pace:
    """What a run with a budget of time goes by.

    Attributes
    ----------
    ray_rate : float, rays a second that size the batches
    before, reserve : float, s that are not for the estimate: all, and those after it
    """

    ray_rate: float = NOMINAL_RAY_RATE
    before: float = 0.0
    reserve: float = 0.0


#: What follows a run: called after every batch.
Progress = Callable[["Standing"], None]


@dataclass(frozen=True)
class Calculation:
    """Everything that one run found.

    Attributes
    ----------
    seconds : by stage
    interpolation : error between the nodes, which no replicate sees
    convergence : one row a replicate added or doubling made
    sampling : what another run needs to sample alike
    """

    scene: Scene
    plan: Plan
    settings: Settings
    effort: Effort
    field: RadianceField
    planes: tuple[PlaneValues, ...]
    observers: tuple[ObserverValues, ...]
    replicates: Replicates
    error: ErrorReached
    target_met: bool
    interpolation: InterpolationError | None
    edge: float
    seconds: dict[str, float]
    convergence: tuple[Standing, ...]
    sampling: SamplingPlan


def calc(
    scene: Scene,
    *,
    target: float | None = None,
    time: float | None = None,
    settings: Settings | None = None,
) -> RadianceField:
    """Compute the light in a scene.

    Parameters
    ----------
    scene : as `lelight.load` reads it
    target : float, relative standard error of the illuminance to reach, e.g. 0.02
    time : float, seconds after which the estimate stops
    settings : everything else; ``target`` and ``time`` win

    Returns
    -------
    RadianceField : ``illuminance`` (n,) lx, ``std_error`` (n,) lx, ``radiance(points, directions)`` cd/m²
    """
    chosen = settings or Settings()
    chosen = replace(
        chosen,
        target=target if target is not None else chosen.target,
        time=time if time is not None else chosen.time,
    )
    return calculate(scene, chosen).field


def calculate(
    scene: Scene,
    settings: Settings,
    *,
    like: SamplingPlan | None = None,
    pace: Pace | None = None,
    progress: Progress = lambda _: None,
    keep: Keeper | None = None,
) -> Calculation:
    """Run all stages; `calc` for those who want more than the field.

    Parameters
    ----------
    like : sample as another run did, instead of until a target or a time; its seed and edge are up to the settings
    pace : what is known of the machine, where the run has a budget of time
    keep : remembers what is found, and gives back what an earlier part of the run has found
    """
    require_light(scene)
    scene = without_repeated_faces(scene)
    settings = settings.over(scene.settings)
    if settings.emitters != "all":
        scene = without_dark_lamps(scene)
    keep = keep or Keeper()
    with _crew(settings) as executor:
        try:
            stage = prepare(scene, settings, executor, keep)
            require_sound_mesh(scene, stage.mesh)
            if stage.base is not None:
                require_sound_base(scene, stage.mesh, stage.base)
            pace = pace or Pace()
            return _estimate(
                scene, settings, stage, executor, like=like, pace=pace, progress=progress, keep=keep
            )
        except KeyboardInterrupt:
            executor.shutdown(wait=False, cancel_futures=True)
            keep.flush()
            raise


def _crew(settings: Settings) -> AbstractContextManager[Executor]:
    """Who works: threads of this process, and the workers of a cluster where one was asked for."""
    if settings.cluster is not None:
        return cluster_executor(settings.cluster, settings.workers)
    return ThreadPoolExecutor(max_workers=settings.workers)


def _estimate(
    scene: Scene,
    settings: Settings,
    stage: Stage,
    executor: Executor,
    *,
    like: SamplingPlan | None,
    pace: Pace,
    progress: Progress,
    keep: Keeper,
) -> Calculation:
    """Add replicates and double their sequences until the target, the time or their number is reached."""
    detail = angular_detail(
        stage.plan,
        stage.world.reflectances,
        directions=settings.directions,
        extension=settings.extension,
    )
    base = stage.base
    if like is None:
        effort, receivers = _effort(settings, stage, executor, pace, keep)
    else:
        effort, receivers = like.effort, like.shared_out(stage.receivers)
        base = like.started_alike(base)
        settings = replace(settings, batches=like.replicates)
    keep.clock.lap("effort")
    width = 0 if detail is None else detail.width
    form = course_form(receivers, width=width, channels=stage.world.channels)
    room = _room_of_blocks(scene, settings, stage)
    course = keep.state("course", form) or Course(
        Replicates(first_in_space=len(stage.mesh), doublings=like.doublings if like else 0),
        began=keep.clock.elapsed,
    )
    replicates = course.replicates

    def batch(replicate: int, doubling: int) -> Batch:
        found = estimate_batch(
            stage.world,
            receivers,
            effort=effort,
            seed=(settings.seed, replicate),
            doubling=doubling,
            base=base,
            detail=detail,
            executor=executor,
            variant=stage.variant,
            keep=keep,
            name=f"unit/{replicates.units}",
            room=room,
        )
        require_sound_batch(scene, stage, found)
        return found

    if course.convergence:
        progress(course.convergence[-1])
    with keep.stop.listening():
        while True:
            if replicates.step is None:
                step = _next_step(settings, course, pace)
                if step == "stop":
                    break
                replicates.start(step)
            unit = f"unit/{replicates.units}"
            replicates.take(batch(*replicates.due))
            if replicates.step is None:
                course.convergence.append(_standing(settings, stage, replicates, keep.clock.elapsed))
                progress(course.convergence[-1])
            keep.put("course", lambda: form.pack(course), supersedes=f"{unit}/")
        keep.clock.lap("estimate")
        keep.flush()
    sampling = SamplingPlan(
        effort=effort,
        replicates=replicates.count,
        doublings=replicates.doublings,
        direct_doublings=receivers.direct_doublings,
        near_doublings=receivers.near_doublings,
        edge=stage.edge,
        starts=StartingCells.of(base),
    )
    return _found(scene, settings, stage, sampling, detail, course, keep.clock)


def _room_of_blocks(scene: Scene, settings: Settings, stage: Stage) -> float:
    """Bytes that a block may take; a run that cannot fit is refused."""
    allowed = allowed_memory(settings.memory)
    at_rest = require_fitting(
        scene.name,
        len(stage.receivers),
        int(np.count_nonzero(stage.receivers.degrees)),
        degree=stage.plan.degree,
        channels=stage.world.channels,
        edge=stage.edge,
        allowed=allowed,
        triangles=len(scene.triangles),
        base_nodes=len(stage.base.locator) if stage.base is not None else 0,
    )
    return room_of_blocks(allowed, at_rest, settings.workers)


def _effort(
    settings: Settings, stage: Stage, executor: Executor, pace: Pace, keep: Keeper
) -> tuple[Effort, Receivers]:
    """Try small batches to find what a full one should do, and how receivers share its samples."""
    areas = np.zeros(len(stage.receivers))
    areas[: len(stage.mesh)] = stage.mesh.visible_areas
    most_rays = np.inf
    if settings.time is not None:
        most_rays = pace.ray_rate * max(settings.time - pace.before, 0.0) / LEAST_BATCHES_IN_TIME
    return choose_effort(
        stage.world,
        stage.receivers,
        base=stage.base,
        areas=areas,
        target=settings.target_error,
        most_rays=most_rays,
        batches=WANTED_BATCHES if settings.batches is None else BATCHES_WITHOUT_DOUBLING,
        seed=settings.seed,
        executor=executor,
        variant=stage.variant,
        keep=keep,
    )


def _next_step(settings: Settings, course: Course, pace: Pace) -> Step:
    """Decide how to go on from where the run stands."""
    if not course.convergence:
        return "append"
    last = course.convergence[-1]
    missing, room = np.inf, np.inf
    if last.error is not None and (settings.target is not None or settings.time is None):
        missing = last.error.in_targets(last.target) ** 2 - 1.0
    if settings.time is not None:
        room = (settings.time - pace.reserve - last.seconds) / max(last.seconds - course.began, 1e-9)
    return next_step(last.replicates, exactly=settings.batches, missing=missing, room=room)


def _standing(settings: Settings, stage: Stage, replicates: Replicates, seconds: float) -> Standing:
    return Standing(
        replicates=replicates.count,
        doublings=replicates.doublings,
        rays=replicates.rays,
        seconds=seconds,
        error=_error(stage, replicates),
        target=settings.target_error,
    )


def _error(stage: Stage, replicates: Replicates) -> ErrorReached | None:
    """Error so far over the nodes that are seen; None before there are two replicates."""
    if replicates.count < 2:
        return None
    seen = np.flatnonzero(~stage.mesh.hidden)
    std_error = std_error_of_nodes(stage, replicates)
    return error_reached(replicates.mean[seen], std_error[seen], areas=stage.mesh.areas[seen])


def _found(
    scene: Scene,
    settings: Settings,
    stage: Stage,
    sampling: SamplingPlan,
    detail: AngularDetail | None,
    course: Course,
    clock: Clock,
) -> Calculation:
    """Turn the sums of all batches into field, planes and eyes."""
    replicates, convergence = course.replicates, tuple(course.convergence)
    field = found_field(scene, stage, replicates, detail)
    planes = found_on_planes(scene, stage, replicates)
    observers = found_at_eyes(scene, stage, replicates)
    require_sound_results(scene, field, planes, observers)
    clock.lap("fit")
    error = convergence[-1].error or ErrorReached(np.inf, np.inf, np.inf)
    return Calculation(
        scene=scene,
        plan=stage.plan,
        settings=settings,
        effort=sampling.effort,
        field=field,
        planes=planes,
        observers=observers,
        replicates=replicates,
        error=error,
        target_met=error.in_targets(settings.target_error) <= 1.0,
        interpolation=found_at_probes(stage, replicates),
        edge=stage.edge,
        seconds=clock.seconds,
        convergence=convergence,
        sampling=sampling,
    )
