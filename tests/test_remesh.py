"""Remeshing: every patch keeps area, extent, plane and orientation; edges come out as wanted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapes import box, circle, fan, icosphere, l_prism, placed, scene_of, soup, strip

import lelight.mesh.remesh
from lelight.mesh.bisection import bisect
from lelight.mesh.patches import patches
from lelight.mesh.pieces import triangle_quality
from lelight.mesh.quads import grid_quads
from lelight.mesh.remesh import FAITHFUL, default_edge, remesh
from lelight.reading.loading import load
from lelight.scene import triangle_areas, triangle_normals

SCENES = sorted((Path(__file__).parent.parent / "scenes").glob("*.toml"))

SQUARE_WITH_TEE = (
    np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [0, 1, 0], [1, 2, 0], [0, 2, 0]], dtype=float),
    np.array([[0, 1, 2], [0, 2, 4], [4, 3, 5], [4, 5, 6]]),
)
FIN = (
    np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]], dtype=float),
    np.array([[0, 1, 2], [0, 2, 3], [0, 2, 4]]),
)
NEEDLE = np.array([[0, 0, 0], [1, 0, 0], [0.3, 1e-6, 0]], dtype=float), np.array([[0, 1, 2]])
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float), np.array([[0, 1, 2], [0, 2, 3]])

SHAPES = {
    "box": (box(), 2.5),
    "L": (l_prism(), 2.5),
    "disc": (fan(circle(64)), 1.0),
    "ring": (strip(circle(48, 2.0), circle(48, 1.0)), 2.0),
    "tube": (strip(circle(40), circle(40, height=2.0)), 2.0),
    "coarse sphere": (icosphere(2), 1.0),
    "fine sphere": (icosphere(4), 1.0),
    "T junction": (SQUARE_WITH_TEE, 2.0),
    "fin": (FIN, 1.0),
    "needle": (NEEDLE, 1.0),
}


def assert_faithful(scene, surface, labels):
    count = int(labels.max()) + 1
    assert len(surface.patch_materials) == count
    corners, remeshed = scene.corners, surface.vertices[surface.triangles]
    solid = np.unique(labels[triangle_areas(corners) > 0])
    assert np.array_equal(np.unique(surface.triangle_patches), solid)
    assert np.array_equal(
        surface.vertex_patches[surface.triangles], np.repeat(surface.triangle_patches[:, None], 3, 1)
    )
    assert np.array_equal(np.unique(surface.triangles), np.arange(len(surface.vertices)))
    origin = corners.mean(axis=(0, 1))
    before = np.bincount(labels, triangle_areas(corners - origin), count)
    after = np.bincount(surface.triangle_patches, triangle_areas(remeshed - origin), count)
    np.testing.assert_allclose(after[solid], before[solid], rtol=FAITHFUL)
    for patch in solid:
        old, new = corners[labels == patch].reshape(-1, 3), surface.vertices[surface.vertex_patches == patch]
        extent = np.linalg.norm(np.ptp(old, axis=0))
        np.testing.assert_allclose(new.min(axis=0), old.min(axis=0), rtol=0, atol=FAITHFUL * extent)
        np.testing.assert_allclose(new.max(axis=0), old.max(axis=0), rtol=0, atol=FAITHFUL * extent)
    assert (np.abs(np.linalg.norm(surface.normals, axis=1) - 1) < 1e-12).all()


@pytest.mark.parametrize("fraction", [0.04, 0.15, 3.0])
@pytest.mark.parametrize("name", SHAPES)
def test_patches_survive(name, fraction):
    shape, size = SHAPES[name]
    scene = scene_of(shape)
    labels = patches(scene)
    assert_faithful(scene, remesh(scene, labels, edge=fraction * size), labels)


@pytest.mark.parametrize(
    ("scale", "shift"), [(1e-3, (0, 0, 0)), (1e4, (0, 0, 0)), (1.0, (4.5e5, 5.2e6, 120.0))]
)
@pytest.mark.parametrize("name", ["box", "L", "disc", "tube"])
def test_scale_and_place_do_not_matter(name, scale, shift):
    shape, size = SHAPES[name]
    scene = scene_of(placed(soup(shape), scale=scale, shift=shift))
    labels = patches(scene)
    assert_faithful(scene, remesh(scene, labels, edge=0.1 * size * scale), labels)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_our_own_scenes_survive(path):
    scene = load(path)
    labels = patches(scene)
    surface = remesh(scene, labels, edge=default_edge(scene))
    assert_faithful(scene, surface, labels)


def test_the_same_input_gives_the_same_bits_whatever_ran_before():
    scene = scene_of(
        l_prism(), placed(fan(circle(64)), shift=(10, 0, 0)), strip(circle(40), circle(40, height=2.0))
    )
    labels = patches(scene)
    first = remesh(scene, labels, edge=0.25)
    remesh(scene_of(fan(circle(32))), np.zeros(30, dtype=np.int64), edge=0.2)
    second = remesh(scene, labels, edge=0.25)
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.triangles.tobytes() == second.triangles.tobytes()
    assert first.normals.tobytes() == second.normals.tobytes()


@pytest.mark.parametrize("name", ["L", "disc", "ring"])
def test_flat_patches_stay_in_their_plane_face_the_same_way_and_come_out_well_shaped(name):
    shape, size = SHAPES[name]
    scene = scene_of(shape)
    labels = patches(scene)
    surface = remesh(scene, labels, edge=0.1 * size)
    corners = surface.vertices[surface.triangles]
    expected = triangle_normals(scene.corners)[np.unique(labels, return_index=True)[1]]
    np.testing.assert_allclose(surface.normals, expected[surface.vertex_patches], atol=1e-12)
    facing = np.einsum("nx,nx->n", triangle_normals(corners), expected[surface.triangle_patches])
    np.testing.assert_allclose(facing, 1.0, rtol=1e-9)
    quality = triangle_quality(corners)
    assert quality.mean() > 0.8
    assert quality.min() > 0.1


def test_a_sphere_has_the_normals_of_a_sphere():
    scene = scene_of(icosphere(4))
    surface = remesh(scene, patches(scene), edge=0.5)
    cosine = np.einsum("nx,nx->n", surface.normals, surface.vertices)
    assert cosine.min() > np.cos(np.radians(1.0))


@pytest.mark.parametrize("edge", [0.3, 0.1])
def test_a_rectangle_is_a_grid_of_the_fewest_cells_however_it_is_triangulated(edge):
    side = np.linspace(0, 1, 8)
    low, high = (np.column_stack([side, np.full(8, y), np.zeros(8)]) for y in (0.0, 0.5))
    points = np.concatenate([low, high])
    here = np.arange(7)
    faces = np.concatenate([np.stack([here, here + 1, here + 9], 1), np.stack([here, here + 9, here + 8], 1)])
    scene = scene_of((points, faces))
    surface = remesh(scene, patches(scene), edge=edge)
    columns, rows = int(np.ceil(1 / edge)), int(np.ceil(0.5 / edge))
    assert len(surface.vertices) == (columns + 1) * (rows + 1)
    assert len(surface.triangles) == 2 * columns * rows


def test_a_bent_sheet_of_very_many_triangles_gets_an_edge_that_covers_it():
    """At the edge that is asked for it would lose too much area; its own triangles are far more than it needs."""
    points, triangles, *_ = grid_quads(SQUARE[0][None], edge=1 / 80)
    bowl = np.column_stack([points[:, :2], 0.1 * (points[:, :2] ** 2).sum(axis=1)])
    scene = scene_of((bowl, triangles))
    labels = patches(scene)
    surface = remesh(scene, labels, edge=0.3)
    assert_faithful(scene, surface, labels)
    assert len(surface.vertices) < len(points) / 10


def test_where_pymeshlab_fails_the_original_triangles_are_bisected(monkeypatch):
    nothing = np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    monkeypatch.setattr(lelight.mesh.remesh, "_run_pymeshlab", lambda *_: nothing)
    scene = scene_of(fan(circle(64)))
    surface = remesh(scene, patches(scene), edge=0.1)
    corners = surface.vertices[surface.triangles]
    assert np.linalg.norm(np.roll(corners, 1, axis=1) - corners, axis=2).max() <= 0.1
    np.testing.assert_allclose(triangle_areas(corners).sum(), triangle_areas(scene.corners).sum(), rtol=1e-12)


def test_a_mesh_that_loses_area_is_not_taken(monkeypatch):
    lost = np.array([[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0]]), np.array([[0, 1, 2]])
    monkeypatch.setattr(lelight.mesh.remesh, "_run_pymeshlab", lambda *_: lost)
    scene = scene_of(fan(circle(64)))
    labels = patches(scene)
    assert_faithful(scene, remesh(scene, labels, edge=0.1), labels)


def test_nothing_reaches_the_terminal(capfd):
    scene = scene_of(l_prism(), NEEDLE, fan(circle(64)))
    remesh(scene, patches(scene), edge=0.2)
    assert capfd.readouterr() == ("", "")


def test_materials_follow_their_patches():
    scene = scene_of(box(), placed(SQUARE, shift=(1, 1, 1)), materials=[1, 0])
    surface = remesh(scene, patches(scene), edge=0.5)
    assert surface.patch_materials.tolist() == [1] * 6 + [0]


def test_triangles_without_area_leave_an_empty_patch():
    line = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], dtype=float), np.array([[0, 1, 2]])
    scene = scene_of(line, SQUARE)
    surface = remesh(scene, patches(scene), edge=0.5)
    assert len(surface.patch_materials) == 2
    assert np.unique(surface.triangle_patches).tolist() == [1]


@pytest.mark.parametrize("edge", [0.0, -1.0, np.nan, np.inf])
def test_an_edge_must_be_a_length(edge):
    scene = scene_of(SQUARE)
    with pytest.raises(ValueError, match="edge"):
        remesh(scene, patches(scene), edge=edge)


def test_bisection_conforms():
    vertices, triangles = icosphere(1)
    points, faces, parents = bisect(vertices, triangles, edge=0.2)
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    assert np.array_equal(points[: len(vertices)], vertices)
    np.testing.assert_allclose(
        np.bincount(parents, triangle_areas(points[faces])), triangle_areas(vertices[triangles]), rtol=1e-12
    )


def test_an_ordinary_room_gets_about_four_thousand_nodes_by_default():
    scene = scene_of(box((4.0, 3.0, 2.7)))
    edge = default_edge(scene)
    # 2 (12 + 10.8 + 8.1) m² = 61.8 m² over 4000 nodes.
    assert edge == pytest.approx(np.sqrt(61.8 / 4000), rel=1e-12)
    assert 3000 < len(remesh(scene, patches(scene), edge=edge).vertices) < 8000


def test_the_default_edge_of_a_wire_is_not_absurd():
    scene = scene_of((SQUARE[0] * [100.0, 1e-4, 1.0], SQUARE[1]))
    assert default_edge(scene) == pytest.approx(100.0 / 500, rel=1e-6)
