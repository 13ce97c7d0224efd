"""Bits of a result depend on scene, settings and seed; not on threads, on cores, or on how work is cut up."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commandline import ROOM_TOML, write_room

from lelight.calculation import Calculation, calculate
from lelight.estimate.gmres import gmres
from lelight.reading.loading import load
from lelight.settings import Settings

SETTINGS = Settings(edge=0.25, batches=3, seed=7, threads=1)
#: Colour, so that sums over channels are part of it.
COLOURED = """
[materials]
"wall" = { reflectance = [0.7, 0.5, 0.3] }
"""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    scene = load(write_room(tmp_path_factory.mktemp("room"), toml=ROOM_TOML + COLOURED))
    return scene, bits(calculate(scene, SETTINGS))


def bits(run: Calculation) -> dict[str, bytes]:
    """Every array of nodes, planes and eyes."""
    values = {f"field {name}": array for name, array in vars(run.field.values).items()}
    values |= {f"plane {k}": plane.moment_replicates for k, plane in enumerate(run.planes)}
    values |= {f"eye {k}": eye.moment_replicates for k, eye in enumerate(run.observers)}
    return {name: np.ascontiguousarray(array).tobytes() for name, array in values.items()}


def differing(one: dict[str, bytes], other: dict[str, bytes]) -> list[str]:
    return [name for name in one if one[name] != other[name]]


@pytest.mark.parametrize("threads", [2, 4])
def test_threads_do_not_change_a_bit(undisturbed, threads):
    scene, expected = undisturbed
    assert differing(expected, bits(calculate(scene, replace(SETTINGS, threads=threads)))) == []


def test_sizes_of_blocks_and_chunks_do_not_change_a_bit(undisturbed, monkeypatch):
    scene, expected = undisturbed
    for name, size in (
        ("batch.BLOCK", 101),
        ("local.VERTEX_CHUNK", 37),
        ("base.CHUNK", 77),
    ):
        monkeypatch.setattr(f"lelight.estimate.{name}", size)
    monkeypatch.setattr("lelight.pilot.CHUNK", 53)
    assert differing(expected, bits(calculate(scene, SETTINGS))) == []


def test_another_seed_changes_what_is_random(undisturbed):
    """Otherwise the tests above could not fail."""
    scene, expected = undisturbed
    found = differing(expected, bits(calculate(scene, replace(SETTINGS, seed=8))))
    assert {"field illuminance", "field std_error", "field radiance_sh", "plane 0", "eye 0"} <= set(found)


#: Sums that BLAS would share out over its threads: above 10 000 terms.
LARGE = """
import hashlib
import numpy as np
from lelight.channels import luminance_weighted
from lelight.estimate.base import _Rows, _solved
n = 20_000
direct = np.random.default_rng(2).random((n, 3))
nodes = np.random.default_rng(1).integers(n, size=(4 * n, 3)).astype(np.int32)
weights = np.full(nodes.shape, 1 / 12, dtype=np.float32)
unused = np.zeros((n, 0), dtype=np.uint8)
rows = _Rows(direct, unused, np.full(n, 4, np.int32), np.zeros(4 * n, np.int32), nodes, weights, unused, unused)
found = _solved(rows, direct, np.full((n, 3), 0.2))
light = luminance_weighted(np.random.default_rng(3).random((n, 6, 3)))
print(hashlib.sha256(found.tobytes() + light.tobytes()).hexdigest(), found.mean())
"""


def test_cores_do_not_change_a_bit():
    told = [
        subprocess.run(
            [sys.executable, "-c", LARGE],
            env={**os.environ, "OPENBLAS_NUM_THREADS": threads},
            cwd=Path(__file__).parents[1],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "2")
    ]
    assert told[0] == told[1] and len(told[0]) > 64


def test_gmres_solves_what_can_be_solved_directly():
    rng = np.random.default_rng(5)
    matrix = np.eye(30) - 0.9 * rng.random((30, 30)) / 15
    wanted = rng.random(30)
    found = gmres(lambda x: matrix @ x, wanted, settled=1e-12, restart=7, most=200)
    np.testing.assert_allclose(found, np.linalg.solve(matrix, wanted), rtol=1e-8)
    # The space of one vector is exhausted after one step, and nothing is asked for by zero.
    np.testing.assert_allclose(
        gmres(lambda x: 2 * x, np.ones(4), settled=1e-12, restart=7, most=3), 0.5, rtol=1e-15
    )
    assert np.array_equal(gmres(lambda x: x, np.zeros(4), settled=1e-12, restart=7, most=3), np.zeros(4))
