"""Illuminance against Mitsuba 3, whose code and whose random numbers are none of ours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rooms import glossy_room
from scipy.stats import t as student

from lelight.calculation import calculate
from lelight.settings import Settings

PLACES, BATCHES, PATHS = 60, 8, 1024


def test_a_glossy_room_has_the_light_that_mitsuba_finds():
    """No place of 60 is further off than chance allows among so many, and the mean agrees to half a per cent."""
    try:
        from mitsuba_scene import illuminance_by_mitsuba, mitsuba_scene
    except (ImportError, RuntimeError, OSError) as error:
        pytest.skip(f"Mitsuba 3 or the LLVM library it compiles with is missing: {error}")
    scene = glossy_room(0.4, 0.3, 30.0)
    run = calculate(scene, replace(Settings(edge=0.7), target=0.02))
    mesh = run.field.mesh
    seen = np.flatnonzero(~mesh.hidden)
    nodes = np.random.default_rng(3).choice(seen, min(PLACES, len(seen)), replace=False)
    built = mitsuba_scene(scene)
    points, normals = mesh.positions[nodes], mesh.normals[nodes]
    batches = [
        illuminance_by_mitsuba(built, points, normals, paths=PATHS, seed=seed) for seed in range(BATCHES)
    ]
    expected, error = np.mean(batches, axis=0), np.std(batches, axis=0, ddof=1) / np.sqrt(BATCHES)
    own = run.field.std_error[nodes]
    difference, square = run.replicates.mean[nodes] - expected, own**2 + error**2
    freedom = square**2 / (own**4 / (run.replicates.count - 1) + error**4 / (BATCHES - 1))
    p = 2 * student.sf(np.abs(difference) / np.sqrt(square), freedom)
    assert p.min() > 1 - 0.99 ** (1 / len(nodes))
    assert difference.mean() / expected.mean() == pytest.approx(0.0, abs=0.005)
