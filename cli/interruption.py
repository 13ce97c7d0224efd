"""Ctrl-C: the run unwinds and cleans up, and ends in time even where a compiled loop does not let go."""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType
from typing import NoReturn

#: Seconds that a run may take to unwind.
PATIENCE = 1.0

INTERRUPTED = 130


def end_in_time() -> None:
    """Have SIGINT end this process within `PATIENCE` and a little, whatever its threads are doing."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, _interrupt)


def end() -> NoReturn:
    """Say in one line that the run was interrupted and leave, not waiting for threads that compute."""
    sys.stderr.write("lelight: interrupted\n")
    sys.stderr.flush()
    os._exit(INTERRUPTED)


def _interrupt(_number: int, _frame: FrameType | None) -> NoReturn:
    timer = threading.Timer(PATIENCE, end)
    timer.daemon = True
    timer.start()
    raise KeyboardInterrupt
