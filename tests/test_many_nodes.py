"""Where there are very many nodes or chains, drafts stand on fewer and work is cut up; light stays what it is."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from commandline import ROOM_TOML, write_room

from lelight.calculation import calculate
from lelight.checkpoint.keeper import Keeper
from lelight.mesh.doubles import without_repeated_faces
from lelight.mesh.neighbours import alike, most_alike
from lelight.preparation import prepare
from lelight.reading.loading import load
from lelight.settings import Settings

SETTINGS = Settings(edge=0.14, target=0.1, batches=10, seed=3, threads=2)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return load(write_room(tmp_path_factory.mktemp("room"), toml=ROOM_TOML))


@pytest.fixture
def few(monkeypatch):
    """Pretend that a few hundred nodes, and a few dozen chains, were very many."""
    monkeypatch.setattr("lelight.placement.COARSE_BASE_NODES", 150)
    monkeypatch.setattr("lelight.estimate.effort.MOST_TRIED", 100)
    monkeypatch.setattr("lelight.estimate.chainwalk.CHAINS_AT_ONCE", 16)


def test_base_is_solved_on_a_coarser_mesh(scene, few):
    with ThreadPoolExecutor(2) as executor:
        stage = prepare(without_repeated_faces(scene), SETTINGS, executor, Keeper())
    assert len(stage.mesh) > 800
    # Borders make it more than asked for.
    assert 120 < len(stage.base.locator) < 300
    assert stage.base.illuminance.shape == (len(stage.base.locator), 1)


def test_light_stays_the_same_on_a_coarser_base(scene, monkeypatch, request):
    fine = calculate(scene, SETTINGS)
    request.getfixturevalue("few")
    coarse = calculate(scene, replace(SETTINGS, seed=4))
    assert len(coarse.field.mesh) == len(fine.field.mesh)
    areas = fine.field.mesh.areas
    means = [run.replicates.at_nodes @ areas / areas.sum() for run in (fine, coarse)]
    error = np.hypot(*(np.std(mean, ddof=1) / np.sqrt(len(mean)) for mean in means))
    # Student's t, 18 degrees of freedom, 99.9 %; and sharp enough to see a few lux in hundreds.
    assert abs(means[0].mean() - means[1].mean()) < 3.9 * error
    assert error < 0.01 * means[0].mean()
    # Trials were made at some receivers; the others sample like those.
    assert len(coarse.sampling.near_doublings) > 800
    assert len(np.unique(coarse.sampling.near_doublings)) > 1


def test_most_alike_is_the_nearest_that_faces_the_same_way():
    rng = np.random.default_rng(1)
    points = rng.random((200, 3))
    normals = np.where(np.arange(200)[:, None] % 2 == 0, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    among = np.arange(0, 200, 5)
    found = among[most_alike(points, normals, among)]
    for k in range(200):
        own = among[among % 2 == k % 2]
        assert found[k] == own[np.argmin(np.linalg.norm(points[own] - points[k], axis=1))]
    np.testing.assert_array_equal(found[among], among)
    np.testing.assert_array_equal(alike(points, normals)[:, 0], np.arange(200))
