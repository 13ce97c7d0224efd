"""Blocks at the workers of a Dask cluster, in processes of their own on this machine: the bits of one process."""

from __future__ import annotations

import os
import signal
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commandline import ROOM_TOML, lelight, write_room

from lelight.calculation import Calculation, calculate
from lelight.cluster import ClusterExecutor, cluster_executor
from lelight.errors import ClusterError
from lelight.estimate.blocks import BlockWork, Site
from lelight.reading.loading import load
from lelight.settings import Settings
from lelight.tracing.chains import no_vertices

SETTINGS = Settings(edge=0.16, target=0.2, batches=8, threads=2)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return load(write_room(tmp_path_factory.mktemp("room"), toml=ROOM_TOML))


@pytest.fixture(scope="module")
def alone(scene):
    return calculate(scene, SETTINGS)


def same_bits(one: Calculation, other: Calculation) -> bool:
    pairs = zip(vars(one.field.values).values(), vars(other.field.values).values(), strict=True)
    return all(np.array_equal(a, b) for a, b in pairs) and one.replicates.rays == other.replicates.rays


def test_bits_are_those_of_one_process(scene, alone):
    assert len(alone.replicates.direct) > 1024  # more than one block
    assert same_bits(alone, calculate(scene, replace(SETTINGS, cluster="local:2")))


def test_a_worker_killed_in_the_middle_costs_no_bit(scene, alone, monkeypatch):
    """One of two workers is killed at the third batch; its blocks are done by the other, by its successor or here."""
    killed = []
    send = ClusterExecutor._vertices_at_workers

    def kill_once(self, vertices):
        changed = self._vertices[0] is not vertices
        sent = send(self, vertices)
        killed.append("batch") if changed else None
        if killed.count("batch") == 3 and "worker" not in killed:
            killed.append("worker")
            workers = list(self._client.run(os.getpid).values())
            threading.Timer(0.02, os.kill, (workers[0], signal.SIGKILL)).start()
        return sent

    monkeypatch.setattr(ClusterExecutor, "_vertices_at_workers", kill_once)
    run = calculate(scene, replace(SETTINGS, cluster="local:2"))
    assert "worker" in killed
    assert same_bits(alone, run)


def test_a_cluster_that_does_not_answer_is_named(tmp_path: Path, monkeypatch):
    monkeypatch.setattr("lelight.cluster.PATIENCE", 0.5)
    with (
        pytest.raises(ClusterError, match=r"127\.0\.0\.1:9: no worker answers"),
        cluster_executor("tcp://127.0.0.1:9", 1),
    ):
        pass


def test_workers_of_another_version_are_refused(monkeypatch):
    monkeypatch.setattr("lelight.cluster.versions", lambda: {"lelight": str(time.time())})
    with pytest.raises(ClusterError, match="has lelight"), cluster_executor("local:1", 1):
        pass


def test_errors_of_a_block_are_raised_here():
    empty = Site(None, None, None, None, None, None)
    broken = BlockWork(empty, vertices=no_vertices(1), seed=(1, 2), doubling=0, room=1e9)
    with cluster_executor("local:1", 1) as executor:
        assert executor.submit(os.getpid).result() == os.getpid()
        with pytest.raises(TypeError, match="NoneType"):
            executor.submit(broken, np.arange(3)).result(timeout=60)


def test_command_line_names_a_wrong_address(tmp_path: Path):
    outcome = lelight("calc", write_room(tmp_path), "--cluster", "nowhere", "--quiet")
    assert outcome.status == 1
    assert outcome.stderr.startswith("lelight: --cluster nowhere: no worker answers")
    assert outcome.stderr.count("\n") == 1
