"""``incident.npz``: light that arrives at nodes by direction, from which `lelight relight` makes other materials."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lelight.errors import OutputError
from lelight.harmonics.basis import MAX_DEGREE
from lelight.incident import IncidentLight
from lelight.writing.files import whole

#: Bytes of all arrays together: at most so many times those of the file, and so many more.
MOST_TIMES, MOST_MORE = 64, 1 << 24


def write_incident(path: Path, light: IncidentLight) -> None:
    """Write nodes, degrees and coefficients, of each node only those that it keeps; float32, compressed."""
    with whole(path) as beside, beside.open("wb") as file:
        np.savez_compressed(
            file,
            allow_pickle=False,
            node=light.nodes.astype(np.int32),
            degree=light.degrees.astype(np.int16),
            mirrored_lx=light.packed,
        )


def read_incident(path: Path) -> IncidentLight:
    """Read back what `write_incident` wrote.

    Raises
    ------
    OutputError
        where the file is missing or damaged
    """
    try:
        with zipfile.ZipFile(path) as members:
            unpacked = sum(member.file_size for member in members.infolist())
        if unpacked > MOST_TIMES * path.stat().st_size + MOST_MORE:
            raise ValueError("its arrays are larger than the file can hold")
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            return _light(file["node"], file["degree"], file["mirrored_lx"])
    except OSError as error:
        raise OutputError(f"{path}: {error.strerror or error}; run `lelight calc` again") from error
    except KeyError as missing:
        raise OutputError(f"{path}: damaged: {missing} is missing; run `lelight calc` again") from missing
    except (ValueError, TypeError, EOFError, MemoryError, zipfile.BadZipFile, zlib.error) as error:
        told = " ".join(str(error).split())[:150]
        raise OutputError(f"{path}: damaged ({told}); run `lelight calc` again") from error


def _light(nodes: NDArray[Any], degrees: NDArray[Any], packed: NDArray[Any]) -> IncidentLight:
    """Check that the arrays fit together."""
    if nodes.ndim != 1 or degrees.shape != nodes.shape or packed.ndim != 2:
        raise ValueError("its arrays have no common length")
    if nodes.dtype != np.int32 or degrees.dtype != np.int16 or packed.dtype != np.float32:
        raise ValueError("its arrays are not of their types")
    if len(nodes) and (nodes[0] < 0 or np.any(np.diff(nodes) <= 0)):
        raise ValueError("its nodes do not rise")
    if np.any(degrees < 1) or np.any(degrees > MAX_DEGREE):
        raise ValueError("its degrees are none")
    wide = degrees.astype(np.int64)
    if len(packed) != int(np.sum((wide + 1) ** 2)) or not np.isfinite(packed).all():
        raise ValueError("its coefficients are not those of its degrees")
    return IncidentLight.of_packed(nodes.astype(np.int64), wide, packed)
