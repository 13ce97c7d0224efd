"""Probe points between the nodes, and what interpolation is found to be off by there."""

from __future__ import annotations

import numpy as np
import pytest
from rooms import grey, lamp, lit
from shapes import box, icosphere, placed

from lelight.calculation import calculate
from lelight.estimate.interpolation import interpolation_error
from lelight.mesh.nodes import hide, node_mesh
from lelight.mesh.patches import patches
from lelight.mesh.probes import draw_probes
from lelight.mesh.remesh import remesh
from lelight.scene import triangle_areas
from lelight.settings import Settings

EXACT = 1e-9


def mesh_of(scene, *, edge):
    labels = patches(scene)
    return node_mesh(remesh(scene, labels, edge=edge), np.tile([True, False], (labels.max() + 1, 1))), labels


def test_probes_lie_on_the_surface_and_interpolate_a_linear_field_exactly():
    scene = lit(box((4.0, 3.0, 2.5)), materials=[grey("walls", 0.5)])
    mesh, labels = mesh_of(scene, edge=0.5)
    probes = draw_probes(mesh, scene.corners, labels, seed=3)
    assert len(probes) == max(16, len(mesh) // 16)
    linear = np.array([0.3, -0.2, 0.7])
    found = np.einsum("kc,kc->k", probes.weights, (mesh.vertices @ linear)[probes.nodes])
    np.testing.assert_allclose(found, probes.points @ linear, rtol=EXACT, atol=EXACT)
    np.testing.assert_allclose(np.linalg.norm(probes.normals, axis=1), 1.0, rtol=EXACT)
    assert np.all(np.einsum("kx,kx->k", probes.normals, np.array([2.0, 1.5, 1.25]) - probes.points) > 0)


def test_probes_of_a_curved_patch_lie_on_what_rays_meet():
    """The mesh of a sphere cuts corners of the fine icosphere that is traced; its probes must not."""
    scene = lit(icosphere(3), materials=[grey("shell", 0.5)])
    mesh, labels = mesh_of(scene, edge=0.5)
    probes = draw_probes(mesh, scene.corners, labels, seed=3)
    normals = np.cross(
        scene.corners[:, 1] - scene.corners[:, 0], scene.corners[:, 2] - scene.corners[:, 0]
    ) / (2 * triangle_areas(scene.corners)[:, None])
    heights = np.abs(np.einsum("tx,tkx->tk", normals, probes.points[None] - scene.corners[:, :1]))
    assert heights.min(axis=0).max() < 1e-12


def test_buried_triangles_get_no_probes():
    scene = lit(box((4.0, 3.0, 2.5)), materials=[grey("walls", 0.5)])
    mesh, labels = mesh_of(scene, edge=0.5)
    floor = mesh.positions[:, 2] < 1e-6
    probes = draw_probes(hide(mesh, ~floor), scene.corners, labels, seed=3)
    assert np.all(probes.points[:, 2] < 1e-6)
    assert len(draw_probes(hide(mesh, np.ones(len(mesh), dtype=bool)), scene.corners, labels, seed=3)) == 0


NODES, WEIGHTS = np.array([[0, 1, 2], [0, 1, 2]]), np.array([[0.5, 0.5, 0.0], [0.2, 0.3, 0.5]])


def test_interpolation_error_is_signed_and_free_of_noise():
    """Nodes 10, 20, 30 lx interpolate to 15 and 23 lx; the light there is 17 and 23, mean 20: off by -10 % and 0."""
    at_nodes = np.tile([10.0, 20.0, 30.0], (8, 1))
    found = interpolation_error(at_nodes, np.tile([17.0, 23.0], (8, 1)), nodes=NODES, weights=WEIGHTS)
    assert found.rms == pytest.approx(0.1 / np.sqrt(2), rel=EXACT)
    assert (found.mean, found.mean_std_error) == (pytest.approx(-0.05, rel=EXACT), 0.0)
    noise = 3.0 * np.random.default_rng(1).normal(size=(4000, 2))
    noisy = interpolation_error(
        np.tile([10.0, 20.0, 30.0], (4000, 1)), np.array([15.0, 23.0]) + noise, nodes=NODES, weights=WEIGHTS
    )
    # The mean of 4000 is off by 3 / sqrt(4000) lx, 0.3 %; of its square all but chance is taken off.
    assert noisy.rms < 0.005
    assert abs(noisy.mean) < 4 * noisy.mean_std_error


def test_nothing_to_compare_has_no_error():
    dark = np.zeros((3, 2))
    assert interpolation_error(np.zeros((3, 3)), dark, nodes=NODES, weights=WEIGHTS) is None
    assert interpolation_error(np.ones((1, 3)), np.ones((1, 2)), nodes=NODES, weights=WEIGHTS) is None


def test_interpolation_error_falls_with_the_square_of_the_edge():
    """Direct light of a lamp over a black floor is exact at the nodes: what is left is interpolation, slope 2."""
    floor = placed(
        (np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    )
    scene = lit(floor, materials=[grey("floor", 0.0)], luminaires=(lamp((0.0, 0.0, 1.0)),))
    errors = [
        calculate(scene, Settings(edge=edge, batches=2, target=0.5)).interpolation.rms for edge in (0.4, 0.1)
    ]
    slope = np.log(errors[0] / errors[1]) / np.log(4.0)
    assert slope == pytest.approx(2.0, abs=0.35)
    assert errors[0] > 0.005
