"""Illuminance against Mitsuba 3, whose code and whose random numbers are none of ours."""

from __future__ import annotations

import numpy as np
import pytest
from rooms import glossy_room

from lelight.calculation import calculate
from lelight.comparison import of_estimates
from lelight.settings import Settings

PLACES, BATCHES, PATHS = 60, 8, 1024


def test_a_glossy_room_has_the_light_that_mitsuba_finds():
    """No place of 60 is further off than chance allows among so many, and the mean agrees to half a per cent."""
    try:
        from mitsuba_scene import illuminance_by_mitsuba, mitsuba_scene
    except (ImportError, RuntimeError, OSError) as error:
        pytest.skip(f"Mitsuba 3 or the LLVM library it compiles with is missing: {error}")
    scene = glossy_room(0.4, 0.3, 30.0)
    run = calculate(scene, Settings(edge=0.7, target=0.01))
    mesh = run.field.mesh
    seen = np.flatnonzero(~mesh.hidden)
    nodes = np.random.default_rng(3).choice(seen, min(PLACES, len(seen)), replace=False)
    built = mitsuba_scene(scene)
    points, normals = mesh.positions[nodes], mesh.normals[nodes]
    batches = [
        illuminance_by_mitsuba(built, points, normals, paths=PATHS, seed=seed) for seed in range(BATCHES)
    ]
    expected, error = np.mean(batches, axis=0), np.std(batches, axis=0, ddof=1) / np.sqrt(BATCHES)
    freedom = [np.full(len(nodes), count - 1.0) for count in (BATCHES, run.replicates.count)]
    found = of_estimates(expected, run.replicates.mean[nodes], error, run.field.std_error[nodes], *freedom)
    assert found.p_values.min() > 1 - 0.99 ** (1 / len(nodes))
    assert found.difference.mean() / expected.mean() == pytest.approx(0.0, abs=0.005)
