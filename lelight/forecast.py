"""How long a run will take and what error it will reach, told by a short run on a coarse mesh.

The pilot is a run like any other, with few samples. What it took is carried over to the wanted mesh and target: what
is prepared grows with the receivers, what is estimated with receivers over the square of the target.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from time import perf_counter, process_time

import numpy as np

from lelight.calculation import Calculation, calculate
from lelight.camera import Fisheye
from lelight.dial import edge_scale
from lelight.estimate.blocks import Effort
from lelight.estimate.effort import batches_for, least_error
from lelight.estimate.schedule import WANTED_BATCHES
from lelight.memory import memory_at_rest
from lelight.mesh.grading import graded
from lelight.mesh.patches import patches
from lelight.mesh.remesh import default_edge, remesh
from lelight.placement import nodes_of_base
from lelight.scene import FloatArray, Scene
from lelight.settings import Settings

#: Edge of the pilot's mesh against the wanted one, its replicates and the target that sizes them.
PILOT_EDGE, PILOT_BATCHES, PILOT_TARGET = 2.5, 8, 0.05
#: A mesh of so many vertices takes long whatever its edge, and tells enough in two replicates.
MANY_VERTICES, FEW_BATCHES = 50_000, 2
#: Pixels across the picture that tells how long pictures take.
PILOT_PIXELS = 64
#: Power of the receivers with which preparing grows, measured in the sphere from 642 to 16 482 nodes.
PREPARING = 0.65
#: Time of a sample in a long run over that in the pilot, whose blocks are small.
LONG_RUN = 0.9
#: On a finer mesh the base field is better, and fewer samples are needed: as this power of the receivers.
FINER = -0.2
#: Processor seconds for tables and files; for the overview, which a process of its own draws beside the pictures;
#: what a picture takes with its figures, over its pixels alone.
WRITING, OVERVIEW, JUDGING = 0.5, 1.5, 1.6
#: An edge this much finer than the one that was meshed is meshed before it is believed to fit.
TOO_FAR = 0.8
#: Targets between which the dial is turned.
LEAST_TARGET, MOST_TARGET = 0.002, 0.5


@dataclass(frozen=True)
class Pilot:
    """What a short run took.

    Attributes
    ----------
    edge : float, m, of its mesh
    vertices, nodes, receivers : int, of its surface mesh, one side; nodes; and all places
    per_area : float, vertices that one m² of edge² adds: vertices(edge) = bare + per_area / edge²
    bare : float, vertices that any mesh has
    remeshing, preparing : float, s
    parts : (3,) float, s that a sample of each part takes at all receivers: chains, direct light, near field
    ray_rate : float, rays a second
    effort : of its batches, with what trials found
    least : float, relative error of the shortest run there is
    pictures : float, processor seconds that all pictures of a run will take
    pace : float, processor seconds in a second: how many cores it had
    seconds : float, s of the pilot itself
    """

    edge: float
    vertices: int
    nodes: int
    receivers: int
    per_area: float
    bare: float
    remeshing: float
    preparing: float
    parts: FloatArray
    ray_rate: float
    effort: Effort
    least: float
    pictures: float
    pace: float
    seconds: float

    def vertices_at(self, edge: float) -> float:
        """Vertices of a mesh of this edge, one side."""
        return self.bare + self.per_area / edge**2

    def through(self, edge: float, vertices: int) -> Pilot:
        """Count vertices by one more mesh: as many at this edge, as it were at the pilot's own."""
        per_area = max(vertices - self.vertices, 0) / (edge**-2 - self.edge**-2)
        return replace(self, per_area=per_area, bare=self.vertices - per_area / self.edge**2)

    def growth(self, edge: float) -> float:
        """Receivers at an edge over those of the pilot."""
        nodes = self.nodes * self.vertices_at(edge) / self.vertices
        return (self.receivers - self.nodes + nodes) / self.receivers

    def fixed(self, edge: float) -> float:
        """Seconds of a run beside its estimate."""
        growth = self.growth(edge)
        meshing = self.remeshing * self.vertices_at(edge) / self.vertices
        return meshing + self.preparing * float(growth**PREPARING) + self.writing

    @property
    def writing(self) -> float:
        """Seconds after the estimate."""
        # One more process has a core to itself, or what a thread of two has.
        overview = OVERVIEW / min(self.pace / 2.0, 1.0)
        return WRITING / self.pace + max(overview, self.pictures / self.pace)

    def estimate(self, edge: float, target: float) -> float:
        """Seconds of the estimate alone."""
        count, samples = batches_for(self.effort, target, batches=WANTED_BATCHES)
        return LONG_RUN * count * float(samples @ self.parts) * float(self.growth(edge) ** (1.0 + FINER))

    def seconds_for(self, edge: float, target: float) -> float:
        """Seconds of a run to a target."""
        return self.fixed(edge) + self.estimate(edge, target)

    def error_in(self, edge: float, seconds: float) -> float:
        """Relative standard error that a run reaches in so many seconds in all."""
        left = seconds - self.fixed(edge)
        return min(falling_to(lambda target: self.estimate(edge, target), left), self.least)


@dataclass(frozen=True)
class Forecast:
    """What a run is expected to take and to reach.

    Attributes
    ----------
    edge : float, m
    nodes : float, of all sides
    seconds, error, memory : float; s, relative standard error, bytes
    """

    edge: float
    nodes: float
    seconds: float
    error: float
    memory: float


def pilot_run(scene: Scene, settings: Settings) -> tuple[Pilot, Calculation]:
    """Run shortly on a coarse mesh."""
    started = perf_counter()
    settings = settings.over(scene.settings)
    wanted = settings.edge or default_edge(scene) * settings.edge_scale
    edge = PILOT_EDGE * wanted
    labels = patches(scene)
    coarse, fine = (
        len(graded(remesh(scene, labels, edge=e), scene, labels).vertices) for e in (edge, wanted)
    )
    batches = PILOT_BATCHES if coarse < MANY_VERTICES else FEW_BATCHES
    few = replace(settings, edge=edge, target=PILOT_TARGET, time=None, batches=batches, adaptive=False)
    # What the scene file asks for is in the settings already, and would win over what is None here.
    begun, worked = perf_counter(), process_time()
    run = calculate(replace(scene, settings={}), few)
    pace = (process_time() - worked) / max(perf_counter() - begun, 1e-3)
    per_area = max(fine - coarse, 0) / (wanted**-2 - edge**-2)
    receivers = len(run.replicates.direct)
    spent = run.seconds
    pilot = Pilot(
        edge=edge,
        vertices=coarse,
        nodes=len(run.field.mesh),
        receivers=receivers,
        per_area=per_area,
        bare=coarse - per_area / edge**2,
        remeshing=spent["remesh"],
        preparing=sum(spent[stage] for stage in ("pilot", "base", "effort")),
        parts=_seconds_of_samples(run),
        ray_rate=run.replicates.rays / max(spent["estimate"], 1e-3),
        effort=run.effort,
        least=least_error(run.effort),
        pictures=_pictures(run, settings),
        pace=pace,
        seconds=perf_counter() - started,
    )
    return pilot, run


def _seconds_of_samples(run: Calculation) -> FloatArray:
    """Seconds (3,) of one sample of chains, direct light and near field at all receivers."""
    spent = run.replicates.seconds
    near = spent.get("near_field", 0.0)
    chains = sum(spent.values()) - near - spent.get("direct", 0.0)
    threads = np.array([chains, spent.get("direct", 0.0), near])
    wall = threads * run.seconds["estimate"] / max(float(threads.sum()), 1e-9)
    return np.asarray(wall / (run.replicates.units * run.effort.samples))


def _pictures(run: Calculation, settings: Settings) -> float:
    """Processor seconds that the pictures of all observers will take, from small ones."""
    eyes = run.scene.observers
    if not eyes or settings.pictures is False:
        return 0.0
    with ThreadPoolExecutor(max_workers=settings.workers) as executor:
        times = [process_time()]
        # The first is for what a picture does once; the third less the second are pixels alone.
        for size in (PILOT_PIXELS, PILOT_PIXELS, 3 * PILOT_PIXELS):
            camera = Fisheye(eyes[0].position, eyes[0].direction)
            run.field.picture(camera, size, size, samples=1, executor=executor)
            times.append(process_time())
    values = settings.values
    a_pixel = max(times[3] - times[2] - (times[2] - times[1]), 0.0) / (8 * PILOT_PIXELS**2)
    return len(eyes) * JUDGING * a_pixel * values.picture_size**2 * values.picture_samples


def forecast(scene: Scene, settings: Settings) -> tuple[Forecast, Calculation]:
    """Foretell a run; the short run that tells comes with it."""
    pilot, run = pilot_run(scene, settings)
    settings = settings.over(scene.settings)
    edge = settings.edge or default_edge(scene) * settings.edge_scale
    seconds, error = pilot.seconds_for(edge, settings.target_error), min(settings.target_error, pilot.least)
    if settings.time is not None:
        # The run has a pilot of its own.
        left = max(settings.time - pilot.seconds, 0.0)
        if settings.edge is None:
            pilot, edge = dialled(pilot, scene, left)
        asked = settings.target_error if settings.target is not None else 0.0
        error = max(pilot.error_in(edge, left), asked)
        seconds = min(settings.time, pilot.seconds + pilot.seconds_for(edge, max(asked, LEAST_TARGET)))
    nodes = pilot.nodes * pilot.vertices_at(edge) / pilot.vertices
    detailed = np.count_nonzero(run.field.values.sh_degree) / len(run.field.mesh)
    memory = memory_at_rest(
        pilot.receivers * pilot.growth(edge),
        nodes * detailed,
        degree=run.plan.degree,
        channels=run.plan.channels,
        triangles=len(scene.triangles),
        # What the scene's own triangles ask for, the base has too.
        base_nodes=min(nodes, max(nodes_of_base(nodes), pilot.nodes * pilot.bare / pilot.vertices)),
    )
    return Forecast(edge, nodes, seconds, error, memory), run


def dialled(pilot: Pilot, scene: Scene, seconds: float) -> tuple[Pilot, float]:
    """`dialled_edge`, from a mesh of about that edge; also the pilot as that mesh has corrected it."""
    default = default_edge(scene)
    edge = dialled_edge(pilot, default, seconds)
    if edge < TOO_FAR * pilot.edge / PILOT_EDGE:
        labels = patches(scene)
        vertices = len(graded(remesh(scene, labels, edge=edge), scene, labels).vertices)
        pilot = pilot.through(edge, vertices)
        edge = dialled_edge(pilot, default, seconds)
    return pilot, edge


def dialled_edge(pilot: Pilot, default: float, seconds: float) -> float:
    """Edge in m on the dial at which a run takes so many seconds, the coarsest where all take longer."""

    def takes(target: float) -> float:
        return pilot.seconds_for(default * edge_scale(target), target)

    return default * edge_scale(falling_to(takes, seconds))


def falling_to(takes: Callable[[float], float], seconds: float) -> float:
    """Target at which a falling function of it reaches ``seconds``, by bisection of its logarithm."""
    low, high = math.log(LEAST_TARGET), math.log(MOST_TARGET)
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if takes(math.exp(middle)) <= seconds else (middle, high)
    return math.exp(high)
