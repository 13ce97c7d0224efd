"""What a run may take of memory: sizes on the command line, refusals with numbers, the same bits in less room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from commandline import ROOM_TOML, lelight, write_room

from lelight import memory
from lelight.calculation import calculate
from lelight.errors import SceneError
from lelight.memory import allowed_memory, memory_at_rest, require_fitting, room_of_blocks
from lelight.reading.loading import load
from lelight.reading.quantities import memory_size
from lelight.settings import Settings


@pytest.mark.parametrize(
    ("given", "size"), [(2e9, 2e9), ("4GB", 4e9), (" 500 MB ", 5e8), ("1.5GiB", 1.5 * 2**30), ("3e9", 3e9)]
)
def test_sizes(given, size):
    assert memory_size(given) == size


@pytest.mark.parametrize("given", ["", "4 GByte", "-1GB", "0", "nan", 0, -5, True, None])
def test_what_is_no_size(given):
    with pytest.raises(ValueError, match="allowed is a size like"):
        memory_size(given)


def test_free_memory_is_that_of_machine_and_control_group(monkeypatch, tmp_path):
    (tmp_path / "meminfo").write_text("MemTotal: 100 kB\nMemAvailable:     50 kB\n")
    (tmp_path / "max").write_text("max\n")
    monkeypatch.setattr(memory, "MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(memory, "GROUP_LIMITS", (tmp_path / "max", tmp_path / "missing"))
    assert memory.free_memory() == 51200.0
    (tmp_path / "max").write_text("20480\n")
    assert memory.free_memory() == 20480.0
    assert allowed_memory(None) == pytest.approx(0.7 * 20480.0)
    assert allowed_memory(1e9) == 1e9


def test_what_does_not_fit_is_refused_with_what_would():
    needed = memory_at_rest(100_000, 80_000, degree=13, channels=3)
    options = {"degree": 13, "channels": 3, "edge": 0.1}
    assert require_fitting("hall", 100_000, 80_000, **options, allowed=needed + 1e8) == needed
    with pytest.raises(
        SceneError, match=r"hall: 100000 places, 80000 of them .* --edge 0.\d+ would fit"
    ) as refused:
        require_fitting("hall", 100_000, 80_000, **options, allowed=1e9)
    edge = float(str(refused.value).split("--edge ")[1].split()[0])
    fewer = int(100_000 * (0.1 / edge) ** 2)
    require_fitting("hall", fewer, int(0.8 * fewer), **options, allowed=1.02e9)
    with pytest.raises(SceneError, match="raise --memory"):
        require_fitting("hall", 10, 0, **options, allowed=1e8)


def test_triangles_and_a_base_on_very_many_nodes_take_memory_too():
    """The base is gone before the run is at its height: the larger of the two counts."""
    few = memory_at_rest(1_000, 0, degree=0, channels=1, triangles=1_000)
    assert memory_at_rest(1_000, 0, degree=0, channels=1, triangles=300_000) == few + 2.99e8
    large = memory_at_rest(450_000, 0, degree=0, channels=1, base_nodes=450_000)
    assert large == memory_at_rest(0, 0, degree=0, channels=1, base_nodes=450_000) > 2e9
    # 256 rays and 24 x 24 cells a node: 22.7 kB, 21.7 kB of which were found as they were made.
    small = memory_at_rest(0, 0, degree=0, channels=1, base_nodes=4_576) - memory.AT_REST
    assert small == pytest.approx(4_576 * 21.7e3, rel=0.06)
    whole = {"degree": 0, "channels": 1, "edge": 1.0, "triangles": 300_000, "base_nodes": 450_000}
    with pytest.raises(SceneError, match=r"450000 places take 2\.4 GB of memory, 2 GB are allowed"):
        require_fitting("hall", 450_000, 0, **whole, allowed=2e9)


def test_less_room_changes_no_bit(tmp_path, monkeypatch):
    scene = load(write_room(tmp_path, toml=ROOM_TOML))
    settings = Settings(edge=0.25, target=0.2, batches=8, threads=2)
    wide = calculate(scene, settings)
    rooms = []
    monkeypatch.setattr(
        "lelight.calculation.room_of_blocks", lambda *given: rooms.append(room_of_blocks(*given)) or 1.0
    )
    narrow = calculate(scene, replace(settings, memory=2e9))
    assert len(rooms) == 1 and rooms[0] > memory.LEAST_ROOM
    for name, values in vars(wide.field.values).items():
        np.testing.assert_array_equal(values, getattr(narrow.field.values, name), err_msg=name)


def test_a_base_that_cannot_fit_is_refused_before_it_is_solved(tmp_path, monkeypatch):
    """Where the scene's own triangles ask for nodes, only the mesh tells how many there are."""
    monkeypatch.setattr("lelight.placement.solve_base", lambda *_, **__: pytest.fail("was solved"))
    scene = load(write_room(tmp_path, toml=ROOM_TOML))
    allowed = memory.AT_REST + memory.LEAST_ROOM + 2e6
    with pytest.raises(SceneError, match=r"places take .* of memory"):
        calculate(scene, Settings(edge=0.15, target=0.2, threads=1, memory=allowed))


def test_a_mesh_that_cannot_fit_is_refused_before_it_is_made(tmp_path):
    outcome = lelight("calc", write_room(tmp_path), "--edge", "0.003", "--memory", "1GB", "--quiet")
    assert outcome.status == 1
    assert "GB of memory, 1 GB are allowed; --edge" in outcome.stderr
    assert outcome.stderr.count("\n") == 1
    assert not (tmp_path / "room.lelight" / "field.vtp").exists()
