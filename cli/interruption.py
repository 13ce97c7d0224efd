"""SIGINT and SIGTERM: the run keeps what it has and ends in time, even where a compiled loop does not let go.

Python runs a signal's handler only between two steps of its own. The system's, which writes a byte into a pipe, comes
at once, whatever is being computed; a thread that reads the pipe sees to the end.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

from lelight.checkpoint.stop import Stop
from lelight.writing.files import discard_unfinished

#: Seconds that a run may take to write what it has and to unwind.
PATIENCE = 1.6

INTERRUPTED = 130
SIGNALS = (signal.SIGINT, signal.SIGTERM)

#: Whether this process was asked to stop.
STOP = Stop()


@contextmanager
def end_in_time() -> Iterator[None]:
    """Have the first signal end this process within `PATIENCE` and a little, and a second one at once."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    STOP.reset()
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    threading.Thread(target=_watch, args=(reading,), daemon=True).start()
    before = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    handlers = {number: signal.signal(number, _interrupt) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(before)
        os.close(writing)


def end() -> NoReturn:
    """Say in one line that the run was interrupted and leave, not waiting for threads that compute."""
    remark = f"; {STOP.remark}" if STOP.remark else ""
    sys.stderr.write(f"lelight: interrupted{remark}\n")
    sys.stderr.flush()
    discard_unfinished()
    os._exit(INTERRUPTED)


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    STOP.ask()


def _watch(pipe: int) -> None:
    """End the process after the first signal in time, after the second at once; end with the pipe's other end."""
    come = 0
    while numbers := os.read(pipe, 64):
        come += sum(number in SIGNALS for number in numbers)
        if come > 1:
            end()
        if come == 1:
            timer = threading.Timer(PATIENCE, end)
            timer.daemon = True
            timer.start()
    os.close(pipe)
