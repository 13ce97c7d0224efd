"""What forcing physics on costs: time and memory of runs that the plan would have spared. Not collected by default.

    pytest tests/bench_plan.py -s

Every run is a process of its own; runs of all cases take turns, the median counts.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from pathlib import Path

from commandline import write_room

ROUNDS = 3
#: Diffuse grey room of 4 m by 3 m under a panel; without observers, so that no picture is in the times.
OBJ = """mtllib room.mtl
v 0 0 0
v 4 0 0
v 4 3 0
v 0 3 0
v 0 0 2.5
v 4 0 2.5
v 4 3 2.5
v 0 3 2.5
v 1.4 1.1 2.4
v 2.6 1.1 2.4
v 2.6 1.9 2.4
v 1.4 1.9 2.4
v 0.5 0.5 0.7
v 1.9 0.5 0.7
v 1.9 1.3 0.7
v 0.5 1.3 0.7
usemtl wall
f 1 2 3 4
f 8 7 6 5
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
usemtl panel
f 12 11 10 9
usemtl table
f 13 14 15 16
"""
MTL = "newmtl wall\nKd {0} {0} {0}\nnewmtl table\nKd {0} {0} {0}\nnewmtl panel\nKd {0} {0} {0}\nKe 4000 4000 4000\n"
TARGET = 'target = "3%"\nedge = 0.15\n'
CASES = {
    "by the rules": "",
    "RGB": 'colour = "rgb"\n',
    "40 bands": 'colour = "bands"\n',
    "degree 11": "degree = 11\n",
    "RGB and degree 11": 'colour = "rgb"\ndegree = 11\n',
    "both sides": 'sides = "both"\n',
    "black, by the rules": "",
    "black, indirect light": "indirect = true\n",
}


def measured(arguments: list[str]) -> tuple[float, float, int]:
    """Wall and processor seconds and the most bytes of a process."""
    started = time.perf_counter()
    pid = os.posix_spawn(sys.executable, [sys.executable, *arguments], os.environ)
    _, status, used = os.wait4(pid, 0)
    assert status == 0
    return time.perf_counter() - started, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024


def scene(folder: Path, name: str, asked: str) -> Path:
    grey = 0.0 if name.startswith("black") else 0.6
    return write_room(folder, obj=OBJ, mtl=MTL.format(grey), toml=f"[calc]\n{TARGET}{asked}")


def test_what_forcing_costs(tmp_path):
    found: dict[str, list[tuple[float, float, int]]] = {name: [] for name in CASES}
    for _ in range(ROUNDS):
        for number, (name, asked) in enumerate(CASES.items()):
            room = scene(tmp_path / str(number), name, asked)
            call = "from lelight.cli.main import main; main()"
            found[name].append(measured(["-c", call, "calc", str(room), "--quiet"]))
    least = statistics.median(wall for wall, _, _ in found["by the rules"])
    for name, runs in found.items():
        wall, cpu, memory = (statistics.median(column) for column in zip(*runs, strict=True))
        print(f"{name:24} {wall:6.1f} s {cpu:6.1f} s {memory / 1e6:6.0f} MB  x {wall / least:.2f}")
    at_least, forced = (
        statistics.median(cpu for _, cpu, _ in found[name]) for name in ("by the rules", "RGB and degree 11")
    )
    print(f"RGB and degree 11: x {forced / at_least:.2f} in processor seconds; hoped for 2.5")
    assert forced > at_least
