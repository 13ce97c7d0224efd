"""Office, corridor and Cornell box against a brute-force path tracer that shares only the scene with lelight.

Illuminance at nodes and radiance toward an observer, each difference measured by both standard errors and all
of them judged together (Šidák); a wrong reflectance must be rejected by the same statistic.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pathtracer import PathTracer
from verdicts import critical_t

from lelight.calculation import Calculation, calculate
from lelight.reading.loading import load
from lelight.scene import LUMINANCE_WEIGHTS, FloatArray, IntArray, Scene
from lelight.settings import Settings

SCENES = Path(__file__).parents[1] / "scenes"
EDGES = {"office": 0.8, "corridor": 0.8, "cornell": 0.15}
BATCHES = 36
#: Relative error for which a batch samples: in the corridor light comes by rare paths, and only the means of many
#: of them are normal.
TARGETS = {"office": 0.05, "corridor": 0.025, "cornell": 0.05}
#: Independent runs of lelight, whose spread is the error of what no run reports an error for.
RUNS = 20
#: Radiance is compared where the illuminance is at least this share of the median.
LEAST_SHARE = 0.2
#: Metres that the tracer steps toward the eye before it looks back: out of the surface, and less than a node
#: stands off the next one.
STEP = 1e-4
#: The tracer's paths are averaged in groups, so that its t has normal terms and known degrees of freedom.
GROUPS = 32


@dataclass(frozen=True)
class Estimates:
    """Means (k,) with their standard errors (k,) and degrees of freedom."""

    mean: FloatArray
    std_error: FloatArray
    freedom: int

    @classmethod
    def of(cls, replicates: FloatArray) -> Estimates:
        """From independent estimates (R, k)."""
        count = len(replicates)
        return cls(replicates.mean(axis=0), replicates.std(axis=0, ddof=1) / np.sqrt(count), count - 1)

    @classmethod
    def of_paths(cls, paths: FloatArray) -> Estimates:
        """From one estimate a path (k, paths)."""
        return cls.of(paths.reshape(len(paths), GROUPS, -1).mean(axis=2).T)


def agree(one: Estimates, other: Estimates) -> bool:
    """Welch's t-test at every place, Šidák over all of them."""
    variances = one.std_error**2, other.std_error**2
    together = variances[0] + variances[1]
    freedom = together**2 / (variances[0] ** 2 / one.freedom + variances[1] ** 2 / other.freedom)
    t = np.abs(one.mean - other.mean) / np.sqrt(together)
    return bool(np.all(t <= critical_t(freedom, t.size)))


def relative_error(one: Estimates, other: Estimates) -> float:
    """Median standard error of the difference, as a share of the value."""
    return float(np.median(np.hypot(one.std_error, other.std_error) / other.mean))


@cache
def scene_of(name: str) -> Scene:
    return load(SCENES / f"{name}.toml")


@cache
def lit(name: str, *, seed: int = 0, batches: int = BATCHES) -> Calculation:
    settings = Settings(edge=EDGES[name], target=TARGETS[name], batches=batches, seed=seed)
    return calculate(scene_of(name), settings)


def with_reflectance(scene: Scene, name: str, reflectance: float) -> Scene:
    """The scene with another diffuse reflectance of one material."""
    changed = [replace(m, diffuse=np.full(3, reflectance)) if m.name == name else m for m in scene.materials]
    assert [m.name for m in changed].count(name) == 1
    return replace(scene, materials=tuple(changed))


def drawn_nodes(run: Calculation, count: int, *, least_x: float = -np.inf) -> IntArray:
    """Visible nodes, drawn without looking at the light that is compared."""
    mesh = run.field.mesh
    open_to_light = np.flatnonzero(~mesh.hidden & (mesh.positions[:, 0] > least_x))
    return np.random.default_rng(5).choice(open_to_light, count, replace=False)


def illuminance_of(run: Calculation, nodes: IntArray) -> Estimates:
    replicates = run.replicates
    return Estimates(replicates.mean[nodes], replicates.std_error[nodes], replicates.count - 1)


def traced_illuminance(scene: Scene, run: Calculation, nodes: IntArray, *, paths: int) -> FloatArray:
    """One estimate a path (k, paths, 3), lx."""
    mesh = run.field.mesh
    return PathTracer(scene, seed=6).illuminance(mesh.positions[nodes], mesh.normals[nodes], paths=paths)


# In leg 1 of the corridor hardly any path reaches a lamp's light, so a path tracer's own error estimate is
# not to be trusted there; nodes are drawn where x > 9 m.
ROOMS = {"office": -np.inf, "corridor": 9.0}
#: Reflectances of the walls, which are 0.60, that must be told from the right ones.
WRONG = {"office": 0.62, "corridor": 0.68}


@pytest.mark.parametrize("name", ROOMS)
def test_illuminance_at_nodes(name: str) -> None:
    run = lit(name)
    nodes = drawn_nodes(run, 200, least_x=ROOMS[name])
    found = illuminance_of(run, nodes)
    right = Estimates.of_paths(traced_illuminance(scene_of(name), run, nodes, paths=8192) @ LUMINANCE_WEIGHTS)
    assert relative_error(found, right) < 0.05
    assert agree(found, right)


@pytest.mark.parametrize("name", ROOMS)
def test_wrong_reflectance_of_the_walls_is_rejected(name: str) -> None:
    # Node by node a slightly wrong reflectance hides in the noise; in the mean over the nodes it does not, and
    # the mean over the nodes of the right scene must agree. That the wrong one is told apart is the proof of power.
    run = lit(name)
    nodes = drawn_nodes(run, 200, least_x=ROOMS[name])
    of_runs = Estimates.of(
        np.stack([mean_over(lit(name, seed=s, batches=4), nodes) for s in range(1, RUNS + 1)])
    )
    right, wrong = (
        Estimates.of_paths(
            traced_illuminance(scene, run, nodes, paths=8192).mean(axis=0)[None] @ LUMINANCE_WEIGHTS
        )
        for scene in (scene_of(name), with_reflectance(scene_of(name), "wall", WRONG[name]))
    )
    assert agree(of_runs, right)
    assert not agree(of_runs, wrong)


def mean_over(run: Calculation, nodes: IntArray) -> FloatArray:
    return np.array([run.replicates.mean[nodes].mean()])


def test_every_channel_of_the_cornell_box() -> None:
    runs = [lit("cornell", seed=seed, batches=5) for seed in range(1, RUNS + 1)]
    nodes = drawn_nodes(runs[0], 60)
    traced = traced_illuminance(scene_of("cornell"), runs[0], nodes, paths=16384)
    for channel in range(3):
        found = Estimates.of(np.stack([run.field.values.illuminance[nodes, channel] for run in runs]))
        right = Estimates.of_paths(traced[..., channel])
        assert relative_error(found, right) < 0.03
        assert agree(found, right)
    swapped = Estimates.of_paths(traced[..., 2])
    assert not agree(
        Estimates.of(np.stack([run.field.values.illuminance[nodes, 0] for run in runs])), swapped
    )


# Radiance at the nodes themselves, so that nothing is interpolated. On a Lambertian node it is kd E / pi;
# on the glossy floor it also holds harmonics, whose error no run reports, and the drawn image of the lamps.
# The spread of independent runs holds all of these, for any material.
@cache
def observed_places(name: str, count: int) -> tuple[IntArray, FloatArray]:
    """Nodes and unit directions (count, 3) toward the first observer, half of them of glossy material."""
    run, scene = lit(name, seed=1, batches=4), scene_of(name)
    mesh = run.field.mesh
    way = scene.observers[0].position - mesh.positions
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    facing = ~mesh.hidden & (np.einsum("nx,nx->n", way, mesh.normals) > 0.2)
    inside = mesh.positions[:, 0] > ROOMS[name]
    glossy = np.array([m.glossy for m in scene.materials])[mesh.materials]
    # Places that hardly a path lights have no normal means. Another run, that is not compared, tells which.
    other = lit(name)
    illuminance = other.replicates.mean[: len(mesh)]
    inside &= illuminance > LEAST_SHARE * np.median(illuminance[inside])
    rng = np.random.default_rng(7)
    parts = [np.flatnonzero(facing & inside & kind) for kind in (glossy, ~glossy)]
    nodes = np.concatenate([rng.choice(part, min(count // 2, len(part)), replace=False) for part in parts])
    return nodes, way[nodes]


@pytest.mark.parametrize("name", ROOMS)
def test_radiance_toward_an_observer(name: str) -> None:
    nodes, way = observed_places(name, 500)
    points = lit(name, seed=1, batches=4).field.mesh.positions[nodes]
    runs = [lit(name, seed=seed, batches=4).field for seed in range(1, RUNS + 1)]
    found = Estimates.of(np.stack([run.radiance(points, way)[:, 0] for run in runs]))
    tracer = PathTracer(scene_of(name), seed=8)
    paths = tracer.radiance(points + STEP * way, -way, paths=4096) @ LUMINANCE_WEIGHTS
    assert relative_error(found, Estimates.of_paths(paths)) < 0.08
    assert agree(found, Estimates.of_paths(paths))
