"""Nodes: one set for each lit side, in frames, with areas, and off the borders of their patch."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import box, circle, fan, icosphere, l_prism, placed, scene_of, strip

from lelight.mesh.edges import directed_edges, on_border
from lelight.mesh.insets import inset_positions
from lelight.mesh.nodes import INSET, frames_x, hide, node_mesh
from lelight.mesh.patches import patches
from lelight.mesh.remesh import remesh
from lelight.scene import triangle_areas, triangle_normals

SHAPES = {
    "box": box(),
    "L": l_prism(),
    "disc": fan(circle(48)),
    "ring": strip(circle(48, 2.0), circle(48, 1.0)),
    "tube": strip(circle(40), circle(40, height=2.0)),
    "needle": (np.array([[0, 0, 0], [1, 0, 0], [0.3, 1e-6, 0]]), np.array([[0, 1, 2]])),
    "thin strip": (
        np.array([[0, 0, 0], [1, 0, 0], [1, 1e-4, 0], [0, 1e-4, 0]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    ),
    "spike": (np.array([[0, 0, 0], [3, -0.01, 0], [3, 0.01, 0]]), np.array([[0, 1, 2]])),
    "bow tie": (
        np.array([[0, 0, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]], dtype=float),
        np.array([[0, 1, 2], [0, 3, 4]]),
    ),
    "slit": (
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [1, 0, 0]], dtype=float),
        np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]),
    ),
}


def surface_of(shape, edge=0.3):
    scene = scene_of(shape)
    return remesh(scene, patches(scene), edge=edge)


def distance_to_segments(points, starts, ends):
    """Distance (n, k) of points (n, 3) from segments."""
    along = ends - starts
    part = np.einsum("nkx,kx->nk", points[:, None] - starts, along) / (along**2).sum(axis=1)
    nearest = starts + np.clip(part, 0, 1)[:, :, None] * along
    return np.linalg.norm(points[:, None] - nearest, axis=2)


def lies_in_own_triangles(positions, vertices, triangles):
    """Whether each position has non-negative weights in a triangle around its vertex, and lies on it."""
    corners = vertices[triangles]
    inside = np.zeros(len(vertices), dtype=bool)
    for corner in range(3):
        vertex = triangles[:, corner]
        a, b, c = (corners[:, (corner + k) % 3] for k in range(3))
        basis = np.stack([b - a, c - a], axis=2)
        weights = np.einsum("nij,nj->ni", np.linalg.pinv(basis, rcond=1e-14), positions[vertex] - a)
        off = np.linalg.norm(np.einsum("nij,nj->ni", basis, weights) - (positions[vertex] - a), axis=1)
        good = (weights.min(axis=1) >= -1e-9) & (weights.sum(axis=1) <= 1) & (off < 1e-12)
        inside[vertex[good]] = True
    return inside


@pytest.mark.parametrize("name", SHAPES)
def test_border_nodes_go_inside_their_own_triangles_and_the_others_stay(name):
    vertices, triangles = SHAPES[name]
    if name not in ("bow tie", "slit"):
        surface = surface_of(SHAPES[name])
        vertices, triangles = surface.vertices, surface.triangles
    positions = inset_positions(vertices, triangles, inset=INSET)
    single = on_border(triangles)
    start, end = (points[single] for points in directed_edges(triangles))
    border = np.zeros(len(vertices), dtype=bool)
    border[start] = True
    assert np.array_equal(positions[~border], vertices[~border])
    assert lies_in_own_triangles(positions, vertices, triangles).all()
    distance = distance_to_segments(positions[border], vertices[start], vertices[end])
    assert distance.min() > 0
    moved = np.linalg.norm(positions - vertices, axis=1)[border]
    longest = np.linalg.norm(vertices[end] - vertices[start], axis=1).max()
    assert (moved <= 4.001 * INSET * longest).all()


@pytest.mark.parametrize("name", ["box", "L", "disc", "ring"])
def test_border_nodes_stand_off_their_border_by_the_inset(name):
    surface = surface_of(SHAPES[name])
    mesh = node_mesh(surface, np.ones((len(surface.patch_materials), 2), dtype=bool))
    for patch in range(len(surface.patch_materials)):
        triangles = surface.triangles[surface.triangle_patches == patch]
        single = on_border(triangles)
        start, end = (points[single] for points in directed_edges(triangles))
        distance = distance_to_segments(mesh.positions[start], surface.vertices[start], surface.vertices[end])
        edges = np.linalg.norm(surface.vertices[end] - surface.vertices[start], axis=1)
        assert distance.min() > 0.5 * INSET * edges.min()
        assert distance.min(axis=1).max() < 2 * INSET * 0.3 * np.sqrt(2)


def test_a_right_angled_corner_moves_as_far_from_either_wall():
    # Edges 1, 1, sqrt 2 in the triangle at (1, 0): mean (2 + sqrt 2) / 3, the distance from both walls.
    vertices, triangles = (
        np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    expected = np.array([1, 0, 0]) + 0.01 * (2 + np.sqrt(2)) / 3 * np.array([-1, 1, 0])
    np.testing.assert_allclose(inset_positions(vertices, triangles, inset=0.01)[1], expected, atol=1e-15)


@pytest.mark.parametrize("name", ["box", "L", "disc", "tube"])
def test_areas_of_each_side_add_up_to_the_patch(name):
    surface = surface_of(SHAPES[name])
    count = len(surface.patch_materials)
    mesh = node_mesh(surface, np.ones((count, 2), dtype=bool))
    expected = np.bincount(
        surface.triangle_patches, triangle_areas(surface.vertices[surface.triangles]), count
    )
    for side in (1, -1):
        own = mesh.sides == side
        np.testing.assert_allclose(
            np.bincount(mesh.patches[own], mesh.areas[own], count), expected, rtol=1e-12
        )


def test_lit_sides_only_get_nodes_and_triangles_face_their_side():
    surface = surface_of(box())
    lit = np.array([[1, 1], [1, 0], [0, 1], [0, 0], [1, 0], [0, 1]], dtype=bool)
    mesh = node_mesh(surface, lit)
    found = {(int(patch), int(side)) for patch, side in zip(mesh.patches, mesh.sides, strict=True)}
    assert found == {(int(patch), 1 - 2 * int(column)) for patch, column in np.argwhere(lit)}
    facing = triangle_normals(mesh.vertices[mesh.triangles])
    np.testing.assert_allclose(facing, mesh.normals[mesh.triangles[:, 0]], atol=1e-12)
    assert (mesh.sides[mesh.triangles] == mesh.triangle_sides[:, None]).all()
    assert (mesh.patches[mesh.triangles] == mesh.triangle_patches[:, None]).all()
    assert np.array_equal(np.unique(mesh.triangles), np.arange(len(mesh)))
    assert not mesh.hidden.any()


def test_the_back_is_the_front_turned_over():
    surface = surface_of(icosphere(2))
    mesh = node_mesh(surface, np.ones((1, 2), dtype=bool))
    half = len(mesh) // 2
    assert np.array_equal(mesh.normals[half:], -mesh.normals[:half])
    assert np.array_equal(mesh.positions[half:], mesh.positions[:half])
    assert (np.einsum("nx,nx->n", mesh.normals[:half], mesh.vertices[:half]) > 0.9).all()


def test_materials_come_from_the_patch():
    scene = scene_of(box(), placed(fan(circle(8)), shift=(2, 1, 1)), materials=[1, 0])
    surface = remesh(scene, patches(scene), edge=0.5)
    mesh = node_mesh(surface, np.ones((7, 2), dtype=bool))
    assert np.array_equal(mesh.materials, np.where(mesh.patches == 6, 0, 1))


def test_no_lit_side_no_node():
    surface = surface_of(box())
    mesh = node_mesh(surface, np.zeros((6, 2), dtype=bool))
    assert len(mesh) == 0
    assert mesh.triangles.shape == (0, 3)


def test_hiding_copies():
    surface = surface_of(box())
    mesh = node_mesh(surface, np.ones((6, 2), dtype=bool))
    mask = mesh.patches == 2
    hidden = hide(mesh, mask)
    assert np.array_equal(hidden.hidden, mask)
    assert not mesh.hidden.any()
    assert hidden.positions is mesh.positions
    assert np.array_equal(hidden.visible_areas, np.where(mask, 0.0, mesh.areas))


@settings(max_examples=200, deadline=None)
@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3))
def test_frames_are_at_right_angles_and_unit(vector):
    normal = np.array([vector]) / np.linalg.norm(vector)
    x = frames_x(normal)
    assert abs(x[0] @ normal[0]) < 1e-15
    assert abs(np.linalg.norm(x) - 1) < 1e-15


@pytest.mark.parametrize("z", [1.0, -1.0])
def test_frames_hold_at_the_poles(z):
    normals = np.array([[0, 0, z], [0.0, -0.0, z], [1e-12, 1e-300, z]])
    np.testing.assert_allclose(frames_x(normals), [[1, 0, 0]] * 3, atol=2e-12)
