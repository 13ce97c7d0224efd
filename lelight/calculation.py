"""From a scene to its light: plan, mesh, pilot, batches, field. The route of the whole program in one file."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from lelight.errors import SceneError
from lelight.estimate.angular import AngularDetail, GridDetail, HarmonicDetail
from lelight.estimate.base import BaseField, solve_base
from lelight.estimate.batch import Effort, estimate_batch
from lelight.estimate.direct import with_clear_share
from lelight.estimate.effort import choose_effort
from lelight.estimate.replicates import LEAST_BATCHES, ErrorReached, Replicates, error_reached, visible_areas
from lelight.field import RadianceField
from lelight.harmonics.hemigrid import HemisphereGrid
from lelight.reading.loading import require_light
from lelight.metrics.grid import grid_points
from lelight.mesh.nodes import NodeMesh, hide, node_mesh
from lelight.mesh.patches import patches
from lelight.pilot import buried, lit_sides
from lelight.plan import Decision, Plan, make_plan
from lelight.receivers import (
    CYLINDRICAL,
    ILLUMINANCE,
    SCALAR,
    VECTOR,
    Receivers,
    joined,
    space_receivers,
    surface_receivers,
)
from lelight.mesh.remesh import default_edge, remesh
from lelight.results import NodeValues, ObserverValues, PlaneValues
from lelight.scene import FloatArray, IntArray, Scene
from lelight.settings import Settings
from lelight.tracing.world import World, build_world

#: What follows a run: called after every batch.
Progress = Callable[["Standing"], None]


#: Grid points and eyes are few, and figures are taken from each: they sample so many doublings more than nodes.
PLANE_DOUBLINGS, EYE_DOUBLINGS = 2, 6


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


@dataclass(frozen=True)
class _Stage:
    """Scene, mesh and receivers, ready to be lit."""

    world: World
    labels: IntArray
    mesh: NodeMesh
    receivers: Receivers
    grids: tuple[tuple[FloatArray, tuple[int, int]], ...]
    edge: float
    plan: Plan
    base: BaseField | None


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
    settings = settings.over(scene.settings)
    clock = _Clock()
    with ThreadPoolExecutor(max_workers=settings.workers) as executor:
        stage = _prepare(scene, settings, executor, clock)
        return _estimate(scene, settings, stage, executor, progress, clock)


def _prepare(scene: Scene, settings: Settings, executor: Executor, clock: _Clock) -> _Stage:
    """Plan, remesh, find the lit sides and the buried nodes, list the receivers."""
    plan = make_plan(scene, method=settings.method)
    labels = patches(scene)
    edge = settings.edge or default_edge(scene) * settings.values.edge_scale
    surface = remesh(scene, labels, edge=edge)
    clock.lap("remesh")
    world = build_world(scene, plan.channels)
    lit = lit_sides(scene, world, labels=labels, seed=settings.seed, executor=executor)
    mesh = node_mesh(surface, lit)
    if not len(mesh):
        raise SceneError(f"{scene.name}: no surface receives light; check where the lamps are and face")
    mesh = hide(mesh, buried(world, mesh, seed=settings.seed, executor=executor))
    clock.lap("pilot")
    grids = tuple(grid_points(plane) for plane in scene.planes)
    receivers = _receivers(scene, mesh, plan, grids)
    sides = Decision(
        "sides", f"{int(lit.sum())} of {2 * len(lit)} patch sides carry nodes", "the others receive no light"
    )
    plan = replace(plan, decisions=(*plan.decisions, sides))
    receivers = with_clear_share(world, receivers, seed=(settings.seed, 3))
    base = None
    if settings.estimator == "base":
        nodes = receivers[slice(0, len(mesh))]
        base = solve_base(
            world, mesh, nodes, labels=labels, lit=lit, seed=settings.seed, executor=executor
        )
    clock.lap("base")
    return _Stage(world, labels, mesh, receivers, grids, edge, plan, base)


def _receivers(
    scene: Scene, mesh: NodeMesh, plan: Plan, grids: tuple[tuple[FloatArray, tuple[int, int]], ...]
) -> Receivers:
    """Nodes first, then the points of all planes, then the eyes."""
    parts = [surface_receivers(mesh, plan.degrees)]
    for plane, (points, _) in zip(scene.planes, grids, strict=True):
        parts.append(space_receivers(points, _repeated(plane.normal, points), doublings=PLANE_DOUBLINGS))
    for eye in scene.observers:
        parts.append(space_receivers(eye.position[None], eye.direction[None], doublings=EYE_DOUBLINGS))
    return joined(parts)


def _repeated(normal: FloatArray, points: FloatArray) -> FloatArray:
    return np.tile(normal, (len(points), 1))


def _detail(plan: Plan, settings: Settings, world: World) -> AngularDetail | None:
    """How glossy nodes keep what they reflect; None where nothing is glossy."""
    if plan.degree == 0:
        return None
    if plan.method == "sh":
        return HarmonicDetail(plan.degree, plan.channels)
    grid = _grid(plan.degree, settings.directions)
    return GridDetail(grid, min(plan.degree, grid.degree), world.reflectances)


def _grid(degree: int, directions: int | None) -> HemisphereGrid:
    """Grid that carries the degree, or the largest of about the number of directions asked for."""
    if directions is not None:
        degree = max(1, int(np.sqrt(directions / 4.0)) - 1)
    return HemisphereGrid(zenith_count=2 * degree + 2, azimuth_count=2 * degree + 1)


def _estimate(
    scene: Scene, settings: Settings, stage: _Stage, executor: Executor, progress: Progress, clock: _Clock
) -> Calculation:
    """Add batches until the target, the time or the number of them is reached."""
    detail = _detail(stage.plan, settings, stage.world)
    areas = np.zeros(len(stage.receivers))
    areas[: len(stage.mesh)] = visible_areas(stage.mesh.areas, stage.mesh.hidden)
    # Against a clock smaller batches stop closer to it.
    aim = settings.target_error * (2.0 if settings.time is not None else 1.0)
    effort, receivers = choose_effort(
        stage.world, stage.receivers, base=stage.base, areas=areas, target=aim, seed=settings.seed,
        executor=executor,
    )
    clock.lap("effort")
    replicates = Replicates(first_in_space=len(stage.mesh))
    convergence: list[Standing] = []
    while not _finished(settings, convergence):
        batch = estimate_batch(
            stage.world, receivers, effort=effort, seed=(settings.seed, replicates.count),
            base=stage.base, detail=detail, executor=executor,
        )
        replicates.add(batch)
        error = _error(stage.mesh, replicates)
        convergence.append(Standing(replicates.count, clock.elapsed, error, settings.target_error))
        progress(convergence[-1])
    clock.lap("estimate")
    field = _field(scene, stage, replicates, detail)
    clock.lap("fit")
    error = convergence[-1].error or ErrorReached(np.inf, np.inf, np.inf)
    return Calculation(
        scene=scene,
        plan=stage.plan,
        settings=settings,
        effort=effort,
        field=field,
        planes=_planes(scene, stage, replicates),
        observers=_observers(scene, stage, replicates),
        replicates=replicates,
        error=error,
        target_met=error.rms <= settings.target_error,
        edge=stage.edge,
        seconds=clock.seconds,
        convergence=tuple(convergence),
    )


def _finished(settings: Settings, convergence: list[Standing]) -> bool:
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
    if replicates.count < 2:
        return None
    seen = ~mesh.hidden
    nodes = slice(0, len(mesh))
    return error_reached(
        replicates.mean[nodes][seen], replicates.std_error[nodes][seen], areas=mesh.areas[seen]
    )


def _field(scene: Scene, stage: _Stage, replicates: Replicates, detail: AngularDetail | None) -> RadianceField:
    """Means over the batches as a field."""
    nodes = slice(0, len(stage.mesh))
    direct = replicates.direct[nodes] / replicates.count
    total = direct + replicates.indirect[nodes] / replicates.count
    # An unbiased estimate of almost nothing may come out below zero; light does not.
    total[:, [ILLUMINANCE, SCALAR]] = np.maximum(total[:, [ILLUMINANCE, SCALAR]], 0.0)
    values = NodeValues(
        illuminance=total[:, ILLUMINANCE],
        std_error=replicates.std_error[nodes],
        direct=np.maximum(direct[:, ILLUMINANCE], 0.0),
        scalar_illuminance=total[:, SCALAR],
        light_vector=total[:, VECTOR : VECTOR + 3],
        sh_degree=stage.receivers.degrees[nodes],
        radiance_sh=_radiance(stage, replicates, detail, total[:, ILLUMINANCE]),
    )
    return RadianceField(scene, stage.mesh, values, stage.labels, stage.world)


def _radiance(
    stage: _Stage, replicates: Replicates, detail: AngularDetail | None, illuminance: FloatArray
) -> FloatArray:
    """Coefficients (n, T, C) of what the nodes reflect: a constant on Lambertian ones."""
    reflectances = stage.world.reflectances
    constant = reflectances.diffuse[stage.mesh.materials] * illuminance / np.pi * np.sqrt(4.0 * np.pi)
    if detail is None:
        return constant[:, None, :].astype(np.float32)
    glossy = np.flatnonzero(stage.receivers.degrees > 0)
    fitted = detail.coefficients(
        replicates.angular / replicates.count,
        receivers=stage.receivers[glossy],
        illuminance=illuminance[glossy],
        reflectances=reflectances,
    )
    radiance = np.zeros((len(stage.mesh), fitted.shape[1], fitted.shape[2]), dtype=np.float32)
    radiance[:, 0] = constant
    radiance[glossy] = fitted
    return radiance


def _planes(scene: Scene, stage: _Stage, replicates: Replicates) -> tuple[PlaneValues, ...]:
    by_batch = np.array(replicates.in_space)
    first = 0
    planes = []
    for plane, (points, shape) in zip(scene.planes, stage.grids, strict=True):
        own = slice(first, first + len(points))
        at = slice(len(stage.mesh) + own.start, len(stage.mesh) + own.stop)
        planes.append(
            PlaneValues(
                plane=plane,
                shape=shape,
                points=points,
                illuminance=replicates.mean[at],
                std_error=replicates.std_error[at],
                cylindrical=by_batch[:, own, CYLINDRICAL].mean(axis=0),
                replicates=by_batch[:, own, ILLUMINANCE],
                cylindrical_replicates=by_batch[:, own, CYLINDRICAL],
            )
        )
        first += len(points)
    return tuple(planes)


def _observers(scene: Scene, stage: _Stage, replicates: Replicates) -> tuple[ObserverValues, ...]:
    indirect = np.array(replicates.indirect_in_space)[..., ILLUMINANCE]
    total = np.array(replicates.in_space)[..., ILLUMINANCE]
    first = sum(len(points) for points, _ in stage.grids)
    return tuple(
        ObserverValues(
            observer=eye,
            direct=float(np.mean(total[:, k] - indirect[:, k])),
            indirect=float(np.mean(indirect[:, k])),
            indirect_replicates=indirect[:, k],
        )
        for k, eye in enumerate(scene.observers, start=first)
    )


class _Clock:
    """Splits the time of a run into stages."""

    def __init__(self) -> None:
        self.started = self.last = perf_counter()
        self.seconds: dict[str, float] = {}

    @property
    def elapsed(self) -> float:
        return perf_counter() - self.started

    def lap(self, stage: str) -> None:
        now = perf_counter()
        self.seconds[stage] = now - self.last
        self.last = now


