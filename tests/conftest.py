"""One run of ``lelight calc`` that many tests look at."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
from commandline import QUICK, Outcome, lelight, write_room


@dataclass(frozen=True)
class Run:
    """A scene, the folder of its results, and what the command said."""

    scene: Path
    out: Path
    outcome: Outcome


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    scene = write_room(tmp_path_factory.mktemp("work") / "Büro 1 ☀")
    outcome = lelight("calc", scene, *QUICK, "--threads", "2")
    assert outcome.status == 0, outcome.stderr
    return Run(scene, scene.with_name("room.lelight"), outcome)
