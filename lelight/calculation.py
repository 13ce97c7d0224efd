"""From a scene to its light: the route of the whole program, stage by stage."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from lelight.clock import Clock
from lelight.estimate.angular import AngularDetail, angular_detail
from lelight.estimate.batch import Batch, Effort, estimate_batch
from lelight.estimate.effort import choose_effort
from lelight.estimate.interpolation import InterpolationError
from lelight.estimate.replicates import ErrorReached, Replicates, error_reached, visible_areas
from lelight.estimate.samplingplan import SamplingPlan, StartingCells
from lelight.estimate.schedule import WANTED_BATCHES, Step, next_step
from lelight.estimate.variants import VARIANTS
from lelight.field import RadianceField
from lelight.mesh.doubles import without_repeated_faces
from lelight.mesh.nodes import NodeMesh
from lelight.outcome import found_at_eyes, found_at_probes, found_field, found_on_planes
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
#: Batches that shall at least fit into the time asked for.
LEAST_BATCHES_IN_TIME = 16
#: Batches that an effort is shared out over where a run makes exactly so many replicates without doubling.
BATCHES_WITHOUT_DOUBLING = 12

#: What follows a run: called after every batch.
Progress = Callable[["Standing"], None]


@dataclass(frozen=True)
class Standing:
    """Where a run stands.

    Attributes
    ----------
    replicates, doublings : int; independent scrambles, and how often each has doubled its sequences
    rays : int so far
    seconds : float since the run began
    error : reached so far, None before there are two replicates
    target : float
    """

    replicates: int
    doublings: int
    rays: int
    seconds: float
    error: ErrorReached | None
    target: float


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
    progress: Progress = lambda _: None,
) -> Calculation:
    """Run all stages; `calc` for those who want more than the field.

    Parameters
    ----------
    like : sample as another run did, instead of until a target or a time; its seed and edge are up to the settings
    """
    require_light(scene)
    scene = without_repeated_faces(scene)
    settings = settings.over(scene.settings)
    clock = Clock()
    with ThreadPoolExecutor(max_workers=settings.workers) as executor:
        stage = prepare(scene, settings, executor, clock)
        return _estimate(scene, settings, stage, executor, like=like, progress=progress, clock=clock)


def _estimate(
    scene: Scene,
    settings: Settings,
    stage: Stage,
    executor: Executor,
    *,
    like: SamplingPlan | None,
    progress: Progress,
    clock: Clock,
) -> Calculation:
    """Add replicates and double their sequences until the target, the time or their number is reached."""
    detail = angular_detail(stage.plan, stage.world.reflectances, directions=settings.directions)
    base = stage.base
    if like is None:
        effort, receivers = _effort(settings, stage, executor)
    else:
        effort, receivers = like.effort, like.shared_out(stage.receivers)
        base = like.started_alike(base)
        settings = replace(settings, batches=like.replicates)
    clock.lap("effort")
    began = clock.elapsed

    def batch(replicate: int, doubling: int) -> Batch:
        return estimate_batch(
            stage.world,
            receivers,
            effort=effort,
            seed=(settings.seed, replicate),
            doubling=doubling,
            base=base,
            detail=detail,
            executor=executor,
            variant=VARIANTS[settings.estimator],
        )

    replicates = Replicates(first_in_space=len(stage.mesh), doublings=like.doublings if like else 0)
    convergence: list[Standing] = []
    while (step := _next_step(settings, convergence, began)) != "stop":
        if step == "append":
            replicates.append(batch(replicates.count, k) for k in range(replicates.doublings + 1))
        else:
            replicates.double(batch(r, replicates.doublings + 1) for r in range(replicates.count))
        convergence.append(_standing(settings, stage.mesh, replicates, clock.elapsed))
        progress(convergence[-1])
    clock.lap("estimate")
    sampling = SamplingPlan(
        effort=effort,
        replicates=replicates.count,
        doublings=replicates.doublings,
        direct_doublings=receivers.direct_doublings,
        near_doublings=receivers.near_doublings,
        edge=stage.edge,
        starts=StartingCells.of(base),
    )
    return _found(scene, settings, stage, sampling, detail, replicates, tuple(convergence), clock)


def _effort(settings: Settings, stage: Stage, executor: Executor) -> tuple[Effort, Receivers]:
    """Try small batches to find what a full one should do, and how receivers share its samples."""
    areas = np.zeros(len(stage.receivers))
    areas[: len(stage.mesh)] = visible_areas(stage.mesh.areas, stage.mesh.hidden)
    most_rays = (
        NOMINAL_RAY_RATE * settings.time / LEAST_BATCHES_IN_TIME if settings.time is not None else np.inf
    )
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
        variant=VARIANTS[settings.estimator],
    )


def _next_step(settings: Settings, convergence: list[Standing], began: float) -> Step:
    """Decide how to go on from where the run stands; the estimate began after ``began`` seconds."""
    if not convergence:
        return "append"
    last = convergence[-1]
    missing, room = np.inf, np.inf
    if last.error is not None and (settings.target is not None or settings.time is None):
        missing = last.error.in_targets(last.target) ** 2 - 1.0
    if settings.time is not None:
        room = (settings.time - last.seconds) / max(last.seconds - began, 1e-9)
    return next_step(last.replicates, exactly=settings.batches, missing=missing, room=room)


def _standing(settings: Settings, mesh: NodeMesh, replicates: Replicates, seconds: float) -> Standing:
    return Standing(
        replicates=replicates.count,
        doublings=replicates.doublings,
        rays=replicates.rays,
        seconds=seconds,
        error=_error(mesh, replicates),
        target=settings.target_error,
    )


def _error(mesh: NodeMesh, replicates: Replicates) -> ErrorReached | None:
    """Error so far over the nodes that are seen; None before there are two replicates."""
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
    sampling: SamplingPlan,
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
        effort=sampling.effort,
        field=field,
        planes=found_on_planes(scene, stage, replicates),
        observers=found_at_eyes(scene, stage, replicates),
        replicates=replicates,
        error=error,
        target_met=error.in_targets(settings.target_error) <= 1.0,
        interpolation=found_at_probes(stage, replicates),
        edge=stage.edge,
        seconds=clock.seconds,
        convergence=convergence,
        sampling=sampling,
    )
