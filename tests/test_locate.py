"""Locating: linear functions come out exactly, seams clamp, hidden nodes do not bleed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import box, circle, fan, icosphere, l_prism, placed, scene_of, strip

from lelight.mesh.locate import Locator, interpolate
from lelight.mesh.nearest import TriangleGrid
from lelight.mesh.nodes import hide, node_mesh
from lelight.mesh.patches import patches
from lelight.mesh.remesh import remesh
from lelight.scene import triangle_areas

SHAPES = {
    "box": box(),
    "L": l_prism(),
    "disc": fan(circle(48)),
    "tube": strip(circle(40), circle(40, height=2.0)),
    "sphere": icosphere(3),
    "needle": (np.array([[0, 0, 0], [1, 0, 0], [0.3, 1e-6, 0]]), np.array([[0, 1, 2]])),
    "map": placed(box(), shift=(4.5e5, 5.2e6, 120.0)),
}


def mesh_of(shape, edge=0.3, lit=None):
    scene = scene_of(shape)
    surface = remesh(scene, patches(scene), edge=edge)
    sides = np.ones((len(surface.patch_materials), 2), dtype=bool) if lit is None else lit
    return node_mesh(surface, sides)


def surface_points(mesh, count, seed=0):
    """Random points on the mesh's triangles, with their patch and side."""
    random = np.random.default_rng(seed)
    chosen = random.integers(0, len(mesh.triangles), count)
    points = np.einsum(
        "kc,kcx->kx", random.dirichlet([1, 1, 1], count), mesh.vertices[mesh.triangles[chosen]]
    )
    return points, mesh.triangle_patches[chosen], mesh.triangle_sides[chosen]


def assert_weights(weights):
    assert (weights >= 0).all()
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=1e-14)


@pytest.mark.parametrize("name", SHAPES)
def test_linear_functions_are_reproduced(name):
    mesh = mesh_of(SHAPES[name])
    points, own_patches, sides = surface_points(mesh, 2000)
    nodes, weights = Locator(mesh).find(points, own_patches, sides)
    assert_weights(weights)
    assert (mesh.patches[nodes] == own_patches[:, None]).all()
    assert (mesh.sides[nodes] == sides[:, None]).all()
    scale = 1e-12 * np.abs(mesh.vertices).max()
    np.testing.assert_allclose(interpolate(mesh.vertices, nodes, weights), points, rtol=0, atol=scale)


def test_constants_stay_at_one_in_every_channel():
    mesh = mesh_of(box())
    nodes, weights = Locator(mesh).find(*surface_points(mesh, 100))
    values = interpolate(np.ones((len(mesh), 5)), nodes, weights)
    assert values.shape == (100, 5)
    np.testing.assert_allclose(values, 1.0, rtol=1e-14)


def test_points_beside_the_patch_take_its_nearest_point():
    mesh = mesh_of(
        (np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]), np.array([[0, 1, 2], [0, 2, 3]])), 0.1
    )
    points = np.array([[-0.5, 0.3, 0], [1.2, 1.4, 0.1], [0.5, 0.5, -2], [0.77, -40, 3]])
    nodes, weights = Locator(mesh).find(points, np.zeros(4, dtype=int), np.ones(4, dtype=int))
    assert_weights(weights)
    expected = np.array([[0, 0.3, 0], [1, 1, 0], [0.5, 0.5, 0], [0.77, 0, 0]])
    np.testing.assert_allclose(interpolate(mesh.vertices, nodes, weights), expected, atol=1e-12)


def closest_by_force(corners, points):
    """Least distance (k,) over all triangles: from the plane if the foot is inside, else from the edges."""
    a, ahead = corners, np.roll(corners, -1, axis=1) - corners
    part = np.einsum("kmcx,mcx->kmc", points[:, None, None] - a, ahead) / (ahead**2).sum(axis=2)
    feet = a + np.clip(part, 0, 1)[..., None] * ahead
    least = np.linalg.norm(points[:, None, None] - feet, axis=3).min(axis=2)
    normals = np.cross(ahead[:, 0], -ahead[:, 2])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    sides = np.einsum("kmcx,mcx->kmc", points[:, None, None] - a, np.cross(normals[:, None], ahead))
    height = np.abs(np.einsum("kmx,mx->km", points[:, None] - a[:, 0], normals))
    return np.where((sides >= 0).all(axis=2), height, least).min(axis=1)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_nearest_triangle_is_the_nearest_of_all(seed):
    random = np.random.default_rng(seed)
    corners = random.normal(size=(60, 1, 3)) + random.normal(size=(60, 3, 3)) * random.uniform(
        0.01, 1, (60, 1, 1)
    )
    groups = random.integers(0, 3, 60)
    points, own = random.normal(size=(40, 3)) * 2, random.integers(0, 3, 40)
    found, weights = TriangleGrid(corners, groups).find(points, own)
    distance = np.linalg.norm(np.einsum("kc,kcx->kx", weights, corners[found]) - points, axis=1)
    assert (groups[found] == own).all()
    for group in range(3):
        mine = own == group
        expected = closest_by_force(corners[groups == group], points[mine])
        np.testing.assert_allclose(distance[mine], expected, rtol=1e-9, atol=1e-12)


def test_hidden_nodes_weigh_nothing_and_the_rest_makes_up_for_them():
    mesh = mesh_of(box())
    hidden = hide(mesh, np.random.default_rng(1).random(len(mesh)) < 0.3)
    nodes, weights = Locator(hidden).find(*surface_points(mesh, 2000))
    assert_weights(weights)
    assert (weights[hidden.hidden[nodes]] == 0).all()
    values = np.where(hidden.hidden, np.inf, 3.0)
    shown = np.where(weights > 0, values[nodes], 0.0)
    np.testing.assert_allclose((weights * shown).sum(axis=1), 3.0, rtol=1e-14)


def test_among_hidden_nodes_the_nearest_visible_one_of_the_patch_side_stands_in():
    mesh = mesh_of(box())
    floor = (mesh.patches == 0) & (mesh.sides == 1)
    keep = np.flatnonzero(floor)[7]
    hidden = hide(mesh, floor & (np.arange(len(mesh)) != keep))
    points = mesh.vertices[floor]
    where = points, np.zeros(len(points), dtype=int), np.ones(len(points), dtype=int)
    nodes, weights = Locator(hidden).find(*where)
    assert_weights(weights)
    assert (np.where(weights > 0, nodes, keep) == keep).all()
    nodes, weights = Locator(hidden).find(*where, stand_in=False)
    assert set(np.unique(weights.sum(axis=1).round(14))) == {0.0, 1.0}
    assert (nodes[weights > 0] == keep).all()


def test_a_side_without_visible_nodes_weighs_nothing():
    lit = np.ones((6, 2), dtype=bool)
    lit[0, 1] = False
    mesh = mesh_of(box(), lit=lit)
    hidden = hide(mesh, (mesh.patches == 3) & (mesh.sides == 1))
    points = np.array([[2.0, 1.5, 0.0]] * 4)
    asked, sides = np.array([0, 3, 99, 0]), np.array([-1, 1, 1, 1])
    _, weights = Locator(hidden).find(points, asked, sides)
    assert np.array_equal(weights.sum(axis=1) > 0, [False, False, False, True])


def test_everything_hidden_weighs_nothing():
    mesh = mesh_of(box())
    _, weights = Locator(hide(mesh, np.ones(len(mesh), dtype=bool))).find(*surface_points(mesh, 50))
    assert (weights == 0).all()


def test_an_empty_mesh_and_no_points():
    empty = mesh_of(box(), lit=np.zeros((6, 2), dtype=bool))
    nothing = np.zeros(2, dtype=int)
    _, weights = Locator(empty).find(np.zeros((2, 3)), nothing, nothing + 1)
    assert (weights == 0).all()
    nodes, weights = Locator(mesh_of(box())).find(np.zeros((0, 3)), nothing[:0], nothing[:0])
    assert nodes.shape == weights.shape == (0, 3)


def test_integrals_by_located_points_match_node_areas():
    # The mean of an interpolated field over area-uniform points is the area-weighted mean over the nodes.
    mesh = mesh_of(l_prism(), lit=np.tile([True, False], (8, 1)))
    values = mesh.vertices[:, 0] ** 2 + mesh.vertices[:, 2]
    triangle_area = triangle_areas(mesh.vertices[mesh.triangles])
    centroids = mesh.vertices[mesh.triangles].mean(axis=1)
    nodes, weights = Locator(mesh).find(centroids, mesh.triangle_patches, mesh.triangle_sides)
    by_points = (interpolate(values, nodes, weights) * triangle_area).sum()
    np.testing.assert_allclose(by_points, (values * mesh.areas).sum(), rtol=1e-12)
