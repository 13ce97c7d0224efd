"""Everything lelight raises on purpose.

LelightError            what a user can cause; its text is one line: what, where, what to do
├── InputError          a file cannot be read as what it should be
├── SceneError          the files are readable, the scene they describe is not one that can be lit
├── OutputError         a result cannot be written, or a result folder cannot be read
└── NumberError         a stage found no number, or less light than none

A caller's mistake (a wrong shape, a negative count) is a ValueError that names the argument.
"""

from __future__ import annotations

from pathlib import Path


class LelightError(Exception):
    """Root of the errors that the command line turns into one line and exit status 1."""


class InputError(LelightError):
    """A file cannot be read; the text names the file and, where there is one, the line or key."""

    @classmethod
    def at(cls, path: Path, line: int | None, message: str) -> InputError:
        """Build ``path:line: message`` (``path: message`` without a line)."""
        where = str(path) if line is None else f"{path}:{line}"
        return cls(f"{where}: {message}")


class SceneError(LelightError):
    """The scene cannot be lit as described: no light, no surface, impossible material."""


class OutputError(LelightError):
    """A result cannot be written or read back."""


class NumberError(LelightError):
    """A stage found NaN, infinity or negative light; the text names stage and place."""


class ClusterError(LelightError):
    """The cluster that was asked for does not answer, or computes something else."""
