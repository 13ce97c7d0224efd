"""One run at a time in a folder."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lelight.errors import OutputError


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold a folder for the length of a block; the system lets go of it however the process ends.

    Raises
    ------
    OutputError
        where another process holds it
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        # File systems without locks do without.
        with suppress(OSError):
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise OutputError(
                    f"{folder}: another run is at work here; wait for it, or choose another folder with -o"
                ) from error
        yield
    finally:
        os.close(descriptor)
