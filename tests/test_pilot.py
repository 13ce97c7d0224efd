"""The pilot walk: which sides light reaches, and which nodes are buried."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from rooms import grey, lamp, lit, panel
from shapes import box, placed, solid

from lelight import pilot
from lelight.calculation import calculate
from lelight.checkpoint.keeper import Keeper
from lelight.mesh.nodes import node_mesh
from lelight.mesh.patches import patches
from lelight.mesh.remesh import remesh
from lelight.pilot import buried, lit_sides
from lelight.preparation import prepare
from lelight.scene import triangle_normals
from lelight.settings import Settings
from lelight.tracing.world import build_world

THREADS = ThreadPoolExecutor(2)
ROOM = (6.0, 5.0, 3.0)
SOURCE = (lamp((3.0, 2.5, 2.5)),)


def prepared(scene, *, seed=0):
    world, labels = build_world(scene, 1), patches(scene)
    return world, labels, lit_sides(scene, world, labels=labels, seed=seed, executor=THREADS)


def sides_of(scene, labels, lit_, shape_first, shape_last):
    """Sides (k, 2) of the patches of triangles numbered from shape_first to shape_last."""
    return lit_[np.unique(labels[shape_first:shape_last])]


@pytest.mark.parametrize("seed", range(3))
def test_inside_a_closed_box_nothing_is_lit(seed):
    """A cupboard off the walls: light reaches its outside and the room's inside, and no other side."""
    scene = lit(
        box(ROOM),
        solid((1.0, 0.6, 1.8), (1.0, 1.0, 0.1)),
        materials=[grey("a", 0.5), grey("b", 0.5)],
        luminaires=SOURCE,
    )
    _, labels, found = prepared(scene, seed=seed)
    assert np.array_equal(sides_of(scene, labels, found, 0, 12), np.tile([True, False], (6, 1)))
    assert np.array_equal(sides_of(scene, labels, found, 12, 24), np.tile([True, False], (6, 1)))


def test_normals_may_point_either_way():
    """The same cupboard wound inside out: now its backs are lit."""
    inside_out = placed(box((1.0, 0.6, 1.8)), shift=(1.0, 1.0, 0.1))
    scene = lit(box(ROOM), inside_out, materials=[grey("a", 0.5), grey("b", 0.5)], luminaires=SOURCE)
    _, labels, found = prepared(scene)
    assert np.array_equal(sides_of(scene, labels, found, 12, 24), np.tile([False, True], (6, 1)))


def test_a_lamp_inside_the_closed_box_lights_its_inside_only():
    scene = lit(
        box(ROOM),
        solid((1.0, 1.0, 1.0), (1.0, 1.0, 0.5)),
        materials=[grey("a", 0.5), grey("b", 0.5)],
        luminaires=(lamp((1.5, 1.5, 1.0)),),
    )
    _, labels, found = prepared(scene)
    assert not sides_of(scene, labels, found, 0, 12).any()
    assert np.array_equal(sides_of(scene, labels, found, 12, 24), np.tile([False, True], (6, 1)))


def corridor():
    """A U of legs 2 m wide and 10 m long, a lamp at one end."""
    outline = np.array([[0, 0], [10, 0], [10, 6], [0, 6], [0, 4], [8, 4], [8, 2], [0, 2]], dtype=float)
    count = len(outline)
    here, there = np.arange(count), (np.arange(count) + 1) % count
    vertices = np.concatenate([np.c_[outline, np.zeros(count)], np.c_[outline, np.full(count, 2.5)]])
    walls = np.concatenate(
        [np.stack([here, there, count + there], 1), np.stack([here, count + there, count + here], 1)]
    )
    flat = np.array([(0, 1, 7), (1, 6, 7), (1, 2, 6), (2, 5, 6), (2, 3, 5), (3, 4, 5)])
    triangles = np.concatenate([walls[:, ::-1], flat, flat[:, ::-1] + count])
    return lit((vertices, triangles), materials=[grey("walls", 0.3)], luminaires=(lamp((0.5, 1.0, 2.0)),))


def test_the_dark_end_of_a_corridor_is_lit():
    """It sees neither the lamp nor a wall that does, and is lit all the same."""
    scene = corridor()
    world, labels, found = prepared(scene)
    # Whatever the winding, one side of each patch looks into the corridor; it is lit, and the other is not.
    inward = inner_side(scene, labels)
    assert np.array_equal(np.argmax(found, axis=1), inward)
    assert np.array_equal(found.sum(axis=1), np.ones(len(found)))
    mesh = node_mesh(remesh(scene, labels, edge=1.0), found)
    assert not buried(world, mesh, seed=0, executor=THREADS).any()


@pytest.mark.parametrize("seed", range(4))
def test_few_walks_would_take_the_dark_end_for_buried(seed, monkeypatch):
    """Many walks from the nodes left over are there for a reason: without them nodes of the far leg are lost."""
    scene = corridor()
    world, labels, found = prepared(scene)
    mesh = node_mesh(remesh(scene, labels, edge=0.5), found)
    assert not buried(world, mesh, seed=seed, executor=THREADS).any()
    monkeypatch.setattr(pilot, "MANY_WALKS", pilot.FEW_WALKS)
    assert buried(world, mesh, seed=seed, executor=THREADS).any()


def inner_side(scene, labels):
    """Side, 0 front or 1 back, of each patch that looks at the middle of the corridor's nearest leg."""
    corners = scene.corners
    middle = corners.mean(axis=1)
    normals = triangle_normals(corners)
    step = middle + 0.01 * normals
    inside = (step[:, 2] > 0) & (step[:, 2] < 2.5) & (step[:, 0] > 0) & (step[:, 0] < 10)
    inside &= (step[:, 1] > 0) & (step[:, 1] < 6) & ~((step[:, 0] < 8) & (step[:, 1] > 2) & (step[:, 1] < 4))
    sides = np.zeros(labels.max() + 1, dtype=int)
    sides[labels] = np.where(inside, 0, 1)
    return sides


def test_floor_nodes_under_a_box_that_stands_on_it_are_buried_and_no_others():
    """A box 2 m x 1 m on the floor, without a gap: its own underside and the floor beneath are not there."""
    corner, size = np.array([2.0, 2.0]), np.array([2.0, 1.0])
    scene = lit(
        box(ROOM),
        solid((2.0, 1.0, 0.8), (2.0, 2.0, 0.0)),
        materials=[grey("a", 0.5), grey("b", 0.5)],
        luminaires=SOURCE,
    )
    world, labels, found = prepared(scene)
    mesh = node_mesh(remesh(scene, labels, edge=0.3), found)
    hidden = buried(world, mesh, seed=0, executor=THREADS)
    flat = mesh.positions[:, :2]
    margin = np.minimum(flat - corner, corner + size - flat).min(axis=1)
    floor = (mesh.positions[:, 2] < 1e-6) & (mesh.normals[:, 2] > 0.5)
    assert np.sum(floor & (margin > 1e-3)) > 10
    assert np.all(hidden[floor & (margin > 1e-3)])
    assert not np.any(hidden[~(floor & (margin > -1e-3))])


def test_a_one_sided_panel_lights_what_it_faces():
    """A panel just under the ceiling that faces up leaves the room to its ceiling, and the ceiling to it."""
    up = panel((2.0, 2.0, 2.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    scene = lit(box(ROOM), up, materials=[grey("walls", 0.5), grey("lamp", 0.5, luminance=10.0)])
    _, labels, found = prepared(scene)
    assert np.array_equal(sides_of(scene, labels, found, 0, 12), np.tile([True, False], (6, 1)))
    # Its back is lit by the room that it lights.
    assert sides_of(scene, labels, found, 12, 14).all()


def test_the_verdict_does_not_depend_on_the_threads():
    scene = lit(
        box(ROOM),
        solid((2.0, 1.0, 0.8), (2.0, 2.0, 0.0)),
        materials=[grey("a", 0.5), grey("b", 0.5)],
        luminaires=SOURCE,
    )
    world, labels, found = prepared(scene)
    mesh = node_mesh(remesh(scene, labels, edge=0.5), found)
    verdicts = []
    for workers in (1, 3):
        with ThreadPoolExecutor(workers) as executor:
            verdicts.append(buried(world, mesh, seed=4, executor=executor))
    assert np.array_equal(*verdicts)


def test_a_node_in_the_plane_of_a_cupboard_s_front_steps_out_into_the_room():
    """A cupboard 1 m wide stands on the floor against a wall; nodes of the floor's grid lie under its edges."""
    cupboard = placed(box((1.0, 0.5, 1.0)), shift=(1.0, 0.0, 0.0))
    cupboard = cupboard[0], cupboard[1][:, ::-1]
    scene = lit(
        box((4.0, 3.0, 2.5)),
        cupboard,
        materials=[grey("walls", 0.5), grey("wood", 0.3)],
        luminaires=(lamp((2.0, 1.5, 2.0)),),
    )
    field = calculate(scene, Settings(edge=0.5, batches=2, target=0.5)).field
    mesh = field.mesh
    floor = (mesh.vertices[:, 2] == 0.0) & (mesh.normals[:, 2] == 1.0)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    in_front = floor & (y == 0.5) & (x >= 1.0) & (x <= 2.0)
    beside = floor & np.isin(x, [1.0, 2.0]) & (y < 0.5)
    under = floor & (x > 1.0) & (x < 2.0) & (y < 0.5)
    assert (in_front.sum(), beside.sum(), under.sum()) == (3, 2, 1)
    at_edges = in_front | beside
    outside = (mesh.positions[:, 1] > 0.5) | (mesh.positions[:, 0] < 1.0) | (mesh.positions[:, 0] > 2.0)
    assert outside[at_edges].all()
    assert np.all(np.abs(mesh.positions - mesh.vertices)[at_edges].max(axis=1) < 0.1)
    assert mesh.hidden[under].all()
    assert not mesh.hidden[floor & ~under].any()
    # The lamp shines past the front from its middle and past the sides from in front of them.
    assert field.illuminance[in_front].min() > 0.3 * field.illuminance[floor & ~under].mean()


def test_solids_on_one_another_are_dark_without_a_walk(monkeypatch):
    """A box on a box: no walk starts in them or between them, and the verdict is that of all walks."""
    boxes = [solid((1.0, 1.0, 0.5), (2.0, 2.0, 0.2)), solid((0.6, 0.6, 0.5), (2.2, 2.2, 0.7))]
    materials = [grey(name, 0.5) for name in "abc"]
    scene = lit(box(ROOM), *boxes, materials=materials, luminaires=SOURCE)
    asked = []
    reached = pilot.reached_by_light

    def counted(world, receivers, **options):
        asked.append(receivers.points)
        return reached(world, receivers, **options)

    monkeypatch.setattr(pilot, "reached_by_light", counted)
    found = prepared(scene)[2]
    # Four backs of the room's walls, floor and ceiling are all that is asked.
    x, y, z = np.concatenate(asked).T
    assert not np.any((np.abs(x - 2.5) < 0.6) & (np.abs(y - 2.5) < 0.6) & (z > 1e-9) & (z < ROOM[2] - 1e-9))
    monkeypatch.setattr(pilot, "_enclosed", lambda scene, world, labels, seed: np.zeros_like(found))
    assert np.array_equal(found, prepared(scene)[2])


def test_nodes_are_the_same_whatever_the_seed():
    """Slabs 2 mm apart are lit along their rims: a walk from a place between them finds out now and then."""
    slabs = [solid((0.02, 0.25, 0.3), (1.0 + 0.022 * k, 1.0, 0.5)) for k in range(40)]
    scene = lit(box(ROOM), *slabs, materials=[grey("a", 0.5)] * 41, luminaires=SOURCE)
    stages = [
        prepare(scene, Settings(edge=0.5, target=0.1, seed=seed), THREADS, Keeper()) for seed in range(3)
    ]
    first, *others = (stage.mesh for stage in stages)
    for other in others:
        assert np.array_equal(other.positions, first.positions)
        assert np.array_equal(other.hidden, first.hidden)
