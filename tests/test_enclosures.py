"""Closed solids, into which light cannot come, and what is none."""

from __future__ import annotations

import numpy as np
import pytest
from rooms import grey, lamp, lit
from shapes import box, solid, soup

from lelight.mesh.enclosures import enclosures

ROOM = box((6.0, 5.0, 3.0))


def inner_of(*shapes, luminances=None, lamps=((0.2, 0.2, 2.8),)):
    """Sides (n_t, 2) that look into a solid, of the shapes in a room with lamps."""
    shining = luminances or (0.0,) * len(shapes)
    materials = [grey("room", 0.5)] + [
        grey(f"{number}", 0.5, luminance=each) for number, each in enumerate(shining)
    ]
    scene = lit(ROOM, *shapes, materials=materials, luminaires=tuple(lamp(each) for each in lamps))
    found = enclosures(scene)
    assert not found.inner[:12].any()
    return found.inner[12:]


@pytest.mark.parametrize("turned", [False, True])
def test_the_side_of_a_closed_box_that_looks_in(turned):
    """Whichever way it is wound, and with corners of its own in every triangle."""
    vertices, triangles = solid((1.0, 1.0, 1.0), (1.0, 1.0, 0.5))
    shape = (vertices, triangles[:, ::-1] if turned else triangles)
    for each in (shape, soup(shape)):
        assert np.array_equal(inner_of(each), np.tile([turned, not turned], (12, 1)))


def test_boxes_that_stand_exactly_on_one_another_are_boxes():
    """They share corners and an edge of four faces, and the foot of one is the top of the other."""
    low, high = solid((1.0, 1.0, 0.5), (1.0, 1.0, 0.0)), solid((1.0, 1.0, 0.5), (1.0, 1.0, 0.5))
    assert np.array_equal(inner_of(low, high), np.tile([False, True], (24, 1)))


def test_what_is_no_solid():
    """Open boxes, sheets, and solids that hold a lamp or something else, or shine, or touch what does."""
    vertices, triangles = solid((1.0, 1.0, 1.0), (1.0, 1.0, 0.5))
    assert not inner_of((vertices, triangles[:-1])).any()
    flat = np.concatenate([triangles[:2], triangles[:2, ::-1]])
    assert not inner_of((vertices, flat)).any()
    assert not inner_of((vertices, triangles), lamps=((1.5, 1.5, 1.0),)).any()
    assert not inner_of((vertices, triangles), luminances=(10.0,)).any()
    held = inner_of((vertices, triangles), solid((0.2, 0.2, 0.2), (1.4, 1.4, 1.0)))
    assert not held[:12].any()
    assert held[12:, 1].all()
    beside = inner_of((vertices, triangles), solid((1.0, 1.0, 1.0), (2.0, 1.0, 0.5)), luminances=(0.0, 10.0))
    assert not beside.any()


def test_many_boxes_and_many_lamps(monkeypatch):
    """Looked at together and in small lots: the same answer."""
    boxes = [solid((0.2, 0.2, 0.2), (0.5 + 0.3 * k, 1.0, 0.5)) for k in range(12)]
    lamps = [solid((0.1, 0.1, 0.1), (0.5 + 0.3 * k, 3.0, 2.0)) for k in range(6)]
    luminances = (0.0,) * 12 + (10.0,) * 6
    expected = inner_of(*boxes, *lamps, luminances=luminances)
    assert expected[:144, 1].all() and not expected[144:].any()
    monkeypatch.setattr("lelight.mesh.enclosures.MOST_EMITTING", 10)
    monkeypatch.setattr("lelight.mesh.enclosures.AT_ONCE", 5)
    assert np.array_equal(inner_of(*boxes, *lamps, luminances=luminances), expected)
    monkeypatch.setattr("lelight.mesh.enclosures.CROWDED", -1)
    assert not inner_of(*boxes, *lamps, luminances=luminances).any()
