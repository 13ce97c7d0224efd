"""Local refinement: what is asked for is cut, nothing hangs, and the mesh follows the edges of shadows."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rooms import grey, lamp, lit, panel
from shapes import box, icosphere
from test_pathends import two_rooms

from lelight.adaptation import bent_by_exchange
from lelight.calculation import calculate
from lelight.channels import luminance_weighted
from lelight.estimate.nearfield import near_field
from lelight.estimate.turns import Turn
from lelight.mesh.edges import directed_edges, edge_keys
from lelight.mesh.locate import Locator
from lelight.mesh.patches import patches
from lelight.mesh.pieces import triangle_quality
from lelight.mesh.refinement import refine
from lelight.mesh.remesh import remesh
from lelight.receivers import ILLUMINANCE, space_receivers, with_surface
from lelight.scene import triangle_areas
from lelight.settings import Settings
from lelight.tracing.sobol import Stretch

EXACT = 1e-9


def surface_of(scene, *, edge):
    labels = patches(scene)
    return remesh(scene, labels, edge=edge), labels


def area(surface):
    return triangle_areas(surface.vertices[surface.triangles]).sum()


def borders(surface):
    """Total length of the edges that belong to one triangle only: a hanging vertex makes more of them."""
    start, end = directed_edges(surface.triangles)
    _, first, count = np.unique(edge_keys(start, end), return_index=True, return_counts=True)
    single = first[count == 1]
    return np.linalg.norm(surface.vertices[start[single]] - surface.vertices[end[single]], axis=1).sum()


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 1.0))
def test_any_triangles_are_cut_and_no_vertex_hangs(seed, share):
    scene = lit(box((4.0, 3.0, 2.5)), materials=[grey("walls", 0.5)])
    surface, labels = surface_of(scene, edge=1.0)
    asked = np.random.default_rng(seed).random(len(surface.triangles)) < share
    finer = refine(surface, asked, corners=scene.corners, labels=labels)
    assert len(finer.triangles) >= len(surface.triangles) + asked.sum()
    np.testing.assert_allclose(area(finer), area(surface), rtol=EXACT)
    np.testing.assert_allclose(borders(finer), borders(surface), rtol=EXACT)
    assert np.all(finer.vertex_patches[finer.triangles] == finer.triangle_patches[:, None])
    np.testing.assert_allclose(np.linalg.norm(finer.normals, axis=1), 1.0, rtol=EXACT)


def test_rounds_at_one_corner_stay_local_and_well_shaped():
    """Twelve rounds halve the edges there six times; the rest of the room keeps its triangles."""
    scene = lit(box((4.0, 3.0, 2.5)), materials=[grey("walls", 0.5)])
    surface, labels = surface_of(scene, edge=1.0)
    least, before = triangle_quality(surface.vertices[surface.triangles]).min(), len(surface.triangles)
    for _ in range(12):
        near = np.linalg.norm(surface.vertices, axis=1) < 1e-9
        surface = refine(surface, near[surface.triangles].any(axis=1), corners=scene.corners, labels=labels)
    assert len(surface.triangles) < before + 300
    assert triangle_quality(surface.vertices[surface.triangles]).min() > 0.5 * least
    near = np.linalg.norm(surface.vertices, axis=1) < 1e-9
    around = surface.vertices[surface.triangles[near[surface.triangles].any(axis=1)]]
    assert np.linalg.norm(np.roll(around, 1, axis=1) - around, axis=2).max() < 1.5 / 2**5


def test_new_vertices_of_a_curved_patch_lie_on_what_rays_meet():
    scene = lit(icosphere(3), materials=[grey("shell", 0.5)])
    surface, labels = surface_of(scene, edge=0.6)
    asked = np.ones(len(surface.triangles), dtype=bool)
    finer = refine(surface, asked, corners=scene.corners, labels=labels)
    fresh = finer.vertices[len(surface.vertices) :]
    # Middles of chords of 0.6 would be 4 % inside the unit sphere; the icosphere is 0.4 % inside at most.
    assert np.linalg.norm(fresh, axis=1).min() > 0.995


def shadowed():
    """A black room with a small screen half-way under its one lamp: a sharp shadow of 0.8 m on the floor."""
    screen = panel((0.8, 0.8, 0.9), (0.4, 0.0, 0.0), (0.0, 0.4, 0.0))
    materials = [grey("walls", 0.0), grey("screen", 0.0)]
    return lit(box((2.0, 2.0, 2.0)), screen, materials=materials, luminaires=(lamp((1.0, 1.0, 1.8)),))


@pytest.fixture(scope="module")
def runs():
    return [
        calculate(shadowed(), Settings(edge=0.25, batches=2, target=0.05, adaptive=adaptive))
        for adaptive in (False, True)
    ]


def test_the_mesh_follows_the_edge_of_a_shadow(runs):
    """Floor nodes that refinement adds lie along the shadow's outline, 0.4 m from the middle in x or in y."""
    off_outline = []
    for run in runs:
        vertices = run.field.mesh.vertices
        on_floor = vertices[vertices[:, 2] == 0.0]
        off_outline.append(np.abs(np.abs(on_floor[:, :2] - 1.0).max(axis=1) - 0.4))
    plain, adaptive = off_outline
    assert len(adaptive) > 2 * len(plain)
    assert np.median(plain) > 0.15
    assert np.median(adaptive) < 0.1


def test_refinement_lowers_the_error_of_the_mean(runs):
    """Of a sharp edge an error stays in the triangles that it crosses; refined, they are a quarter of the area or less.

    The mean of |error| over the floor falls with the width of these triangles, 1/4 after the rounds that are made.
    """
    errors = []
    for run in runs:
        mesh, light = run.field.mesh, run.field.illuminance
        at = np.stack(np.meshgrid(np.linspace(0.02, 1.98, 99), np.linspace(0.02, 1.98, 99)), axis=-1).reshape(
            -1, 2
        )
        points = np.column_stack([at, np.zeros(len(at))])
        corners = run.field.scene.corners
        floor = np.flatnonzero(corners[:, :, 2].max(axis=1) == 0.0)[0]
        patch = np.full(len(points), run.field.labels[floor])
        nodes, weights = Locator(mesh).find(points, patch, np.ones(len(points), dtype=int))
        shade = np.abs(at - 1.0).max(axis=1) < 0.4
        truth = np.where(shade, 0.0, 100.0 * 1.8 / (np.sum((at - 1.0) ** 2, axis=1) + 1.8**2) ** 1.5)
        errors.append(np.abs(np.einsum("kc,kc->k", weights, light[nodes]) - truth).mean())
    assert errors[1] < 0.5 * errors[0]


def test_the_same_mesh_comes_out_twice(runs):
    again = calculate(shadowed(), Settings(edge=0.25, batches=2, target=0.05, adaptive=True, threads=1))
    assert np.array_equal(again.field.mesh.vertices, runs[1].field.mesh.vertices)
    assert np.array_equal(again.field.values.illuminance, runs[1].field.values.illuminance)


def exchanged(stage, points, normals):
    """Illuminance (k,) in lx that the base gives at places (k, 3), by many rays."""
    receivers = with_surface(space_receivers(points, normals))
    together = (Turn.of_all(Stretch.of(12), len(receivers)),)
    moments, _, _ = near_field(
        stage.world, receivers, bound=math.inf, together=together, seed=(9,), base=stage.base
    )
    return luminance_weighted(moments[:, ILLUMINANCE])


def test_triangles_are_cut_over_which_exchanged_light_is_bent():
    """What few rays find is held against many, over a room and one that gets its light through a door."""
    stage, tolerance = two_rooms(), 0.03
    mesh = stage.mesh
    with ThreadPoolExecutor(2) as executor:
        asked = bent_by_exchange(
            stage.world, stage.base, mesh, stage.labels, tolerance=tolerance, seed=0, executor=executor
        )
    seen = np.flatnonzero(~mesh.hidden[mesh.triangles].any(axis=1))
    corners = mesh.triangles[seen]
    at_nodes = exchanged(stage, mesh.positions, mesh.normals)
    middles = mesh.vertices[corners].mean(axis=1)
    inside = exchanged(stage, middles, mesh.normals[corners[:, 0]])
    level = luminance_weighted(stage.base.illuminance)
    scale = np.maximum(level[corners].mean(axis=1), np.average(level, weights=mesh.areas * ~mesh.hidden))
    off = np.abs(at_nodes[corners].mean(axis=1) - inside) / scale
    asked = asked[seen]
    assert 0.01 < asked.mean() < 0.5
    assert np.mean(off[asked] > 0.7 * tolerance) > 0.9
    assert np.mean(off[~asked] < 1.4 * tolerance) > 0.99
