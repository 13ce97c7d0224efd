"""From a scene to its light: the route of the whole program, stage by stage."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from lelight.clock import Clock
from lelight.estimate.angular import AngularDetail, angular_detail
from lelight.estimate.batch import Effort, estimate_batch
from lelight.estimate.effort import choose_effort
from lelight.estimate.replicates import LEAST_BATCHES, ErrorReached, Replicates, error_reached, visible_areas
from lelight.field import RadianceField
from lelight.mesh.doubles import without_repeated_faces
from lelight.mesh.nodes import NodeMesh
from lelight.outcome import found_at_eyes, found_field, found_on_planes
from lelight.plan import Plan
from lelight.preparation import Stage, prepare
from lelight.reading.loading import require_light
from lelight.receivers import Receivers
from lelight.results import ObserverValues, PlaneValues
from lelight.scene import Scene
from lelight.settings import Settings

#: Rays a second that a clock is taken to stand for, whatever the machine: the size of batches, and with it the
#: result, depends on the time asked for only.
NOMINAL_RAY_RATE = 1e6

#: What follows a run: called after every batch.
Progress = Callable[["Standing"], None]


@dataclass(frozen=True)
class Standing:
    """Where a run stands after a batch.

    Attributes
    ----------
    batches : int done
    seconds : float since the run began
    error : reached so far, None before there are two batches
    target : float
    """

    batches: int
    seconds: float
    error: ErrorReached | None
    target: float


@dataclass(frozen=True)
class Calculation:
    """Everything that one run found.

    Attributes
    ----------
    seconds : by stage
    convergence : one row a batch
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
    edge: float
    seconds: dict[str, float]
    convergence: tuple[Standing, ...]


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


def calculate(scene: Scene, settings: Settings, *, progress: Progress = lambda _: None) -> Calculation:
    """Run all stages; `calc` for those who want more than the field."""
    require_light(scene)
    scene = without_repeated_faces(scene)
    settings = settings.over(scene.settings)
    clock = Clock()
    with ThreadPoolExecutor(max_workers=settings.workers) as executor:
        stage = prepare(scene, settings, executor, clock)
        return _estimate(scene, settings, stage, executor, progress=progress, clock=clock)


def _estimate(
    scene: Scene, settings: Settings, stage: Stage, executor: Executor, *, progress: Progress, clock: Clock
) -> Calculation:
    """Add batches until the target, the time or the number of them is reached."""
    detail = angular_detail(stage.plan, stage.world.reflectances, directions=settings.directions)
    effort, receivers = _effort(settings, stage, executor)
    clock.lap("effort")
    replicates = Replicates(first_in_space=len(stage.mesh))
    convergence: list[Standing] = []
    while not _finished(settings, convergence):
        batch = estimate_batch(
            stage.world,
            receivers,
            effort=effort,
            seed=(settings.seed, replicates.count),
            base=stage.base,
            detail=detail,
            executor=executor,
        )
        replicates.add(batch)
        error = _error(stage.mesh, replicates)
        convergence.append(Standing(replicates.count, clock.elapsed, error, settings.target_error))
        progress(convergence[-1])
    clock.lap("estimate")
    return _found(scene, settings, stage, effort, detail, replicates, tuple(convergence), clock)


def _effort(settings: Settings, stage: Stage, executor: Executor) -> tuple[Effort, Receivers]:
    """Try small batches to find what a full one should do, and how receivers share its samples."""
    areas = np.zeros(len(stage.receivers))
    areas[: len(stage.mesh)] = visible_areas(stage.mesh.areas, stage.mesh.hidden)
    # Against a clock smaller batches stop closer to it; no more than a dozen shall fill it.
    aim = settings.target_error * (2.0 if settings.time is not None else 1.0)
    most_rays = NOMINAL_RAY_RATE * settings.time / 12 if settings.time is not None else np.inf
    return choose_effort(
        stage.world,
        stage.receivers,
        base=stage.base,
        areas=areas,
        target=aim,
        most_rays=most_rays,
        seed=settings.seed,
        executor=executor,
    )


def _finished(settings: Settings, convergence: list[Standing]) -> bool:
    """Say whether enough batches are in."""
    done = len(convergence)
    if settings.batches is not None:
        return done >= settings.batches
    if done < 2:
        return False
    last = convergence[-1]
    if settings.time is not None and last.seconds * (done + 1) / done > settings.time:
        return True
    if settings.time is not None and settings.target is None:
        return False
    return done >= LEAST_BATCHES and last.error is not None and last.error.rms <= last.target


def _error(mesh: NodeMesh, replicates: Replicates) -> ErrorReached | None:
    """Error so far over the nodes that are seen; None before there are two batches."""
    if replicates.count < 2:
        return None
    seen = ~mesh.hidden
    nodes = slice(0, len(mesh))
    return error_reached(
        replicates.mean[nodes][seen], replicates.std_error[nodes][seen], areas=mesh.areas[seen]
    )


def _found(
    scene: Scene,
    settings: Settings,
    stage: Stage,
    effort: Effort,
    detail: AngularDetail | None,
    replicates: Replicates,
    convergence: tuple[Standing, ...],
    clock: Clock,
) -> Calculation:
    """Turn the sums of all batches into field, planes and eyes."""
    field = found_field(scene, stage, replicates, detail)
    clock.lap("fit")
    error = convergence[-1].error or ErrorReached(np.inf, np.inf, np.inf)
    return Calculation(
        scene=scene,
        plan=stage.plan,
        settings=settings,
        effort=effort,
        field=field,
        planes=found_on_planes(scene, stage, replicates),
        observers=found_at_eyes(scene, stage, replicates),
        replicates=replicates,
        error=error,
        target_met=error.rms <= settings.target_error,
        edge=stage.edge,
        seconds=clock.seconds,
        convergence=convergence,
    )
