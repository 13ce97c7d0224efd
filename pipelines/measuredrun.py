"""A run in a process of its own, so that its time and memory are its own: wall and processor seconds, most bytes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lelight.errors import LelightError

#: What the process does.
CALL = "from lelight.pipelines.measuredrun import serve; serve()"


@dataclass(frozen=True)
class Usage:
    """What a run took, from its start to its last file.

    Attributes
    ----------
    seconds, cpu_seconds : float, by the clock, and of all threads together
    memory : int, bytes at the most
    size : int, bytes of its result folder
    """

    seconds: float
    cpu_seconds: float
    memory: int
    size: int


def run_measured(scene: Path, out: Path, settings: dict[str, Any]) -> Usage:
    """Compute a scene into a folder with these settings and measure what that takes.

    Raises
    ------
    LelightError
        where the run fails, in its words
    """
    order = json.dumps({"scene": str(scene), "out": str(out), "settings": settings})
    started = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-c", CALL, order], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    try:
        told = process.stderr.read() if process.stderr else ""
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    except BaseException:
        process.send_signal(signal.SIGTERM)
        process.wait()
        raise
    finally:
        if process.stderr:
            process.stderr.close()
    if process.returncode:
        raise LelightError(told.strip().splitlines()[-1] if told.strip() else f"{scene}: the run was ended")
    size = sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    seconds = time.perf_counter() - started
    return Usage(seconds, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024, size)


def serve() -> None:
    """Do what the order on the command line says."""
    from lelight.pipelines.calc import run_calc
    from lelight.settings import Settings

    order = json.loads(sys.argv[1])
    given = order["settings"]
    try:
        run_calc(Path(order["scene"]), Path(order["out"]), settings=Settings(**given), given=given)
    except (LelightError, OSError, MemoryError) as error:
        sys.exit(" ".join(str(error).split()) or type(error).__name__)
