"""An overview of the scene: illuminance in false colour, seen from above into the room.

Drawing needs OpenGL. Where no library for it is installed VTK may end the whole process, so the picture is
drawn by a child process, ``python -m lelight.writing.overview``, and a failure becomes a warning.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from lelight.errors import OutputError
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.writing.files import whole

#: Seconds after which a child that does not draw is given up.
TIME_LIMIT = 120.0

_REMEDY = "install OpenGL off screen, Debian package libegl1 or libosmesa6"


def write_overview(path: Path, field_file: Path) -> str | None:
    """Draw the field to a PNG, or say in one line why there is none.

    Returns
    -------
    None when the picture is there, otherwise a warning; never an exception.
    """
    try:
        with whole(path) as beside:
            reason = _draw_in_child(field_file, beside)
            if reason is not None:
                raise OutputError(f"{path.name}: not drawn: {reason}")
    except OutputError as error:
        return str(error)
    return None


def robust_range(illuminance: FloatArray, hidden: BoolArray) -> tuple[float, float]:
    """5th and 95th percentile of the illuminance (n,) over the nodes that are not hidden, made to differ."""
    seen = illuminance[~hidden & np.isfinite(illuminance)]
    if not seen.size:
        return 0.0, 1.0
    lower, upper = (float(limit) for limit in np.percentile(seen, [5, 95]))
    return (lower, upper) if upper > lower else (lower, lower + max(abs(lower), 1.0) * 1e-3)


def partly_seen(triangles: IntArray, hidden: BoolArray) -> BoolArray:
    """Triangles (m,) of nodes (m, 3) with a corner that is not hidden."""
    return np.asarray(~hidden[triangles].all(axis=1))


def shown_values(triangles: IntArray, values: FloatArray, hidden: BoolArray) -> FloatArray:
    """Values (n,) for pictures: hidden nodes, whose own mean nothing, take the mean of their visible neighbours'.

    Parameters
    ----------
    triangles : (m, 3) int into nodes
    """
    corners = triangles[partly_seen(triangles, hidden)]
    seen = ~hidden[corners]
    found = np.where(seen, values[corners], 0.0)
    count = len(values)
    total = np.bincount(corners.ravel(), np.repeat(found.sum(axis=1), 3), minlength=count)
    number = np.bincount(corners.ravel(), np.repeat(seen.sum(axis=1), 3), minlength=count)
    around = np.divide(total, number, out=np.zeros(count), where=number > 0)
    return np.asarray(np.where(hidden, around, values))


def _draw_in_child(field_file: Path, path: Path) -> str | None:
    try:
        run = subprocess.run(
            _command(field_file, path),
            env=_environment(),
            capture_output=True,
            timeout=TIME_LIMIT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no picture within {TIME_LIMIT:.0f} s: {_REMEDY}"
    except OSError as error:
        return f"Python could not be started: {error.strerror}"
    if run.returncode == 0 and path.stat().st_size > 0:
        return None
    return _told_by(run.stderr.decode(errors="replace")) or f"no picture came out: {_REMEDY}"


def _told_by(stderr: str) -> str | None:
    """Find the message of an error of ours that ended the child."""
    last_line = (stderr.strip().splitlines() or [""])[-1]
    kind, _, message = last_line.partition(": ")
    return message if kind == f"{OutputError.__module__}.{OutputError.__name__}" else None


def _command(field_file: Path, path: Path) -> list[str]:
    # -P keeps the working folder, where anything may lie, off the import path.
    return [sys.executable, "-P", "-m", "lelight.writing.overview", str(field_file), str(path)]


def _environment() -> dict[str, str]:
    """Environment in which the child finds this package and no display, which could be a dead one."""
    environment = {
        name: text for name, text in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")
    }
    package_root = str(Path(__file__).resolve().parents[1])
    paths = [package_root, *filter(None, [environment.get("PYTHONPATH")])]
    return {**environment, "PYTHONPATH": os.pathsep.join(paths)}
