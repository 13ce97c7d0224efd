"""Scenes whose light is known on paper: photometric spheres, the furnace, Sobolev's problem.

Every node is a t-test of the run's own batches against the exact value, with Šidák's correction over the
nodes; the same test must reject the value that a slightly different reflectance would give.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from verdicts import critical_t

from lelight.calculation import calculate
from lelight.mesh.nodes import NodeMesh
from lelight.reading.loading import load
from lelight.scene import BoolArray, FloatArray, triangle_areas
from lelight.settings import Settings

SCENES = Path(__file__).parents[1] / "scenes"


@dataclass(frozen=True)
class Found:
    """Illuminance of the visible nodes: mean (n,) in lx, its standard error, and how many batches gave it."""

    mesh: NodeMesh
    visible: BoolArray
    mean: FloatArray
    std_error: FloatArray
    batches: int

    def agrees(
        self, exact: FloatArray, *, chosen: BoolArray | slice = slice(None), model: float = 0.0
    ) -> bool:
        """Say whether no node's |t| is too large; ``model`` is the exact value's relative uncertainty."""
        exact = np.broadcast_to(exact, self.mean.shape)[chosen]
        off = np.maximum(np.abs(self.mean[chosen] - exact) - model * exact, 0.0)
        return bool(np.all(off <= critical_t(self.batches - 1.0, off.size) * self.std_error[chosen]))

    def relative_error(self, exact: FloatArray | float) -> FloatArray:
        """Standard error of each node (n,) as a share of the exact value."""
        return np.asarray(self.std_error / exact)

    @property
    def positions(self) -> FloatArray:
        """(n, 3) float, m."""
        return self.mesh.positions[self.visible]


@cache
def lit(name: str, *, edge: float, batches: int, target: float) -> Found:
    """Run a scene once for all tests: so many batches, each of a size meant for ``target``."""
    run = calculate(
        load(SCENES / f"{name}.toml"), Settings(edge=edge, batches=batches, target=target, seed=1)
    )
    mesh = run.field.mesh
    visible = ~mesh.hidden
    nodes = slice(0, len(mesh))
    mean, std_error = run.replicates.mean[nodes], run.replicates.std_error[nodes]
    return Found(mesh, visible, mean[visible], std_error[visible], run.replicates.count)


# Photometric sphere: I = 100 cd in the middle of a polyhedron whose 642 vertices lie on the unit sphere.
#
# Direct light at a node x with normal n is I cos / r² = I (-x . n) / r³, whatever facet it belongs to.
#
# Indirect light at a node is rho times the mean of E over the surface, weighted by cos d omega / pi seen
# from the node (a closed surface fills the hemisphere, so the weights sum to 1 whatever its shape). On a
# sphere these weights are uniform in area. On the polyhedron they differ from uniform by at most what
# flattening the facets does, 1 - d² = 0.9 % (d = 0.9955 m, the least distance of a facet), while E differs
# from its mean by at most 0.65 % (direct light I d / r³ between the middle of a facet, r = d, and its
# corner, r = 1). The product of both, 6e-5 of the direct light, bounds the difference between the node's
# mean and the area's mean, which is exactly Phi / (A (1 - rho)) by the balance of energy. So E_indirect =
# rho / (1 - rho) Phi / A to 1e-4.
SPHERE_MODEL = 1e-4
INTENSITY = 100.0


def sphere_area() -> float:
    return float(triangle_areas(load(SCENES / "sphere.toml").corners).sum())


def sphere_illuminance(found: Found, reflectance: float) -> FloatArray:
    distance = np.linalg.norm(found.positions, axis=1)
    normals = found.mesh.normals[found.visible]
    direct = INTENSITY * -np.einsum("nx,nx->n", found.positions, normals) / distance**3
    indirect = reflectance / (1.0 - reflectance) * 4.0 * math.pi * INTENSITY / sphere_area()
    return np.asarray(direct + indirect)


SPHERES = [("sphere", 0.5), ("sphere90", 0.9)]


@pytest.mark.parametrize(("name", "reflectance"), SPHERES)
def test_every_node_of_a_photometric_sphere(name: str, reflectance: float) -> None:
    found = lit(name, edge=0.3, batches=24, target=0.002)
    exact = sphere_illuminance(found, reflectance)
    assert np.median(found.relative_error(exact)) < 0.005
    assert np.max(found.relative_error(exact)) < 0.02
    assert found.agrees(exact, model=SPHERE_MODEL)
    assert not found.agrees(sphere_illuminance(found, reflectance + 0.005), model=SPHERE_MODEL)


@pytest.mark.parametrize(("name", "reflectance"), SPHERES)
def test_mean_of_a_photometric_sphere(name: str, reflectance: float) -> None:
    # E = I / R² / (1 - rho) on the sphere itself; the polyhedron has less area for the same flux.
    found = lit(name, edge=0.3, batches=24, target=0.002)
    mean = np.average(found.mean, weights=found.mesh.areas[found.visible])
    on_sphere = INTENSITY / (1.0 - reflectance)
    less_area = 4.0 * math.pi / sphere_area()
    assert 0.997 * on_sphere < mean < 1.003 * less_area * on_sphere


# Furnace: M = pi L = 100 pi lm/m² everywhere, rho = 0.6, so E = M / (1 - rho) = 250 pi lx at every point,
# corners and edges included (derived in furnace.obj).
FURNACE = 250.0 * math.pi


def test_every_node_of_the_furnace() -> None:
    found = lit("furnace", edge=2.0, batches=24, target=0.004)
    assert np.max(found.relative_error(FURNACE)) < 0.01
    assert found.agrees(np.float64(FURNACE))
    assert not found.agrees(np.float64(math.pi * 100.0 / (1.0 - 0.62)))


def test_furnace_has_nodes_in_its_corners() -> None:
    # The acute corner of 21.8 degrees at B (6.5, 0), floor and ceiling: nodes within 2 cm of it are tested
    # above.
    found = lit("furnace", edge=2.0, batches=24, target=0.004)
    for corner in ([6.5, 0.0, 0.0], [6.5, 0.0, 0.65], [4.0, 1.0, 0.0], [0.0, 0.0, 2.6]):
        assert np.min(np.linalg.norm(found.positions - np.array(corner), axis=1)) < 0.02


# Sobolev's problem on two coaxial discs, solved as the comment of sobolev.toml says.
HEIGHT, RADIUS = 2.0, 10.0


def kernel(r: FloatArray, s: FloatArray) -> FloatArray:
    """Illuminance at r (n, 1) for each lm/m² of the ring at s (m,), per m of s, without its factor s."""
    a, b = HEIGHT**2 + r**2 + s**2, 2.0 * r * s
    return 2.0 * HEIGHT**2 * a / (a * a - b * b) ** 1.5


def discs(
    r: FloatArray, *, source_height: float, reflectances: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Exact illuminance (n,) at radii r (n,) on the lower and the upper disc, point source of 1 cd."""
    x, w = np.polynomial.legendre.leggauss(200)
    s, w = RADIUS * (x + 1.0) / 2.0, w * RADIUS / 2.0
    heights = (source_height, HEIGHT - source_height)

    def direct(z: float, radius: FloatArray) -> FloatArray:
        return np.asarray(z / (radius**2 + z**2) ** 1.5)

    swap = kernel(s[:, None], s) * (w * s)
    low, high = reflectances
    whole = np.block([[np.eye(len(s)), -high * swap], [-low * swap, np.eye(len(s))]])
    solved = np.linalg.solve(whole, np.concatenate([direct(z, s) for z in heights])).reshape(2, -1)
    onto = kernel(np.asarray(r)[:, None], s) * (w * s)
    return direct(heights[0], r) + high * onto @ solved[1], direct(heights[1], r) + low * onto @ solved[0]


SOBOLEV = {"sobolev": (1.0, (0.5, 0.5)), "sobolev_offset": (0.5, (0.5, 0.8))}


def test_disc_solution_against_the_values_of_the_scene_files() -> None:
    radii = np.array([0.0, 1.0, 2.0, 5.0])
    equal, _ = discs(radii, source_height=1.0, reflectances=(0.5, 0.5))
    lower, upper = discs(radii, source_height=0.5, reflectances=(0.5, 0.8))
    np.testing.assert_allclose(equal, [1.131955454, 0.464993788, 0.163276183, 0.024537148], rtol=3e-8)
    np.testing.assert_allclose(lower, [4.188551664, 0.524639748, 0.178824615, 0.038346960], rtol=3e-8)
    np.testing.assert_allclose(upper, [0.648010895, 0.418711615, 0.195840941, 0.034872433], rtol=3e-8)


@pytest.mark.parametrize("name", SOBOLEV)
def test_both_planes_of_sobolevs_problem(name: str) -> None:
    # All nodes up to r = 5.5 m. The planes are 60-gons inscribed in the circles; the strip that is missing,
    # 0.18 % of the area between r = 9.99 and 10 m, gives such a node less than 1e-4 of its light:
    # exitance there is below 2e-3 of that nearby, over a share of 2 h² / (pi (h² + 4.5²)²) 0.57 m² = 4e-3.
    found = lit(name, edge=1.5, batches=48, target=0.03)
    source_height, reflectances = SOBOLEV[name]
    r = np.hypot(found.positions[:, 0], found.positions[:, 1])
    near, upper = r < 5.5, found.positions[:, 2] > HEIGHT / 2

    def exact(scale: float) -> FloatArray:
        low, high = (reflectances[0] * scale, reflectances[1] * scale)
        return np.where(upper, *discs(r, source_height=source_height, reflectances=(low, high))[::-1])

    for radius in (0.0, 1.0, 2.0, 5.0):
        assert np.any(np.abs(r[~upper] - radius) < 0.8)
        assert np.any(np.abs(r[upper] - radius) < 0.8)
    assert np.median(found.relative_error(exact(1.0))[near]) < 0.02
    assert np.max(found.relative_error(exact(1.0))[near]) < 0.05
    assert found.agrees(exact(1.0), chosen=near, model=1e-4)
    assert not found.agrees(exact(1.1), chosen=near, model=1e-4)
