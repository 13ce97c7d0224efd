"""Segments: files of records, with a checksum over all of it.

A line that says what it is, a line of JSON with the table of records, the arrays' bytes one after the other, and the
SHA-256 of all that as the last line. A reader believes nothing before the checksum has been compared.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from lelight.checkpoint.records import Record
from lelight.errors import OutputError
from lelight.writing.files import whole

MAGIC = b"lelight checkpoint 1\n"
#: Bytes of the last line.
CHECKSUM = 65
#: Types of numbers that a segment holds.
TYPES = ("<f8", "<f4", "<i8", "<i4", "|u1", "|b1")
#: Bytes read at once.
PIECE = 1 << 20


@dataclass(frozen=True)
class Entry:
    """Where a record lies in its segment: values, and type, shape and first byte of its arrays."""

    values: dict[str, Any]
    arrays: dict[str, tuple[str, tuple[int, ...], int]]


@dataclass(frozen=True)
class Segment:
    """A segment that was found to be sound.

    Attributes
    ----------
    head : what the writer said of all of it
    entries : by the records' keys
    """

    path: Path
    head: dict[str, Any]
    entries: dict[str, Entry]

    def read(self, key: str) -> Record:
        """Read one record back."""
        entry = self.entries[key]
        arrays = {name: self._array(*place) for name, place in entry.arrays.items()}
        return Record(entry.values, arrays)

    def _array(self, kind: str, shape: tuple[int, ...], first: int) -> NDArray[Any]:
        count = math.prod(shape)
        try:
            found = np.fromfile(self.path, dtype=np.dtype(kind), count=count, offset=first)
        except OSError as error:
            raise OutputError(f"{self.path}: cannot be read: {error.strerror or error}") from error
        if len(found) != count:
            raise damaged(self.path)
        return found.reshape(shape)


def damaged(path: Path, what: str = "damaged") -> OutputError:
    """Error of a file that is not what was written."""
    return OutputError(
        f"{path}: {what}; restore it, or run without --resume, which starts from the beginning"
    )


def write_segment(path: Path, head: Mapping[str, Any], records: Mapping[str, Record]) -> Segment:
    """Write records, whole and safely on the disk or not at all."""
    table: list[tuple[str, dict[str, Any], dict[str, Any]]] = []
    contents: list[NDArray[Any]] = []
    first = 0
    for key, record in records.items():
        places = {}
        for name, array in record.arrays.items():
            content = _stored(array)
            places[name] = (content.dtype.str, content.shape, first)
            contents.append(content)
            first += content.nbytes
        table.append((key, record.values, places))
    lead = MAGIC + json.dumps({**head, "bytes": first, "records": table}).encode() + b"\n"
    with whole(path) as beside, beside.open("wb") as stream:
        checksum = hashlib.sha256(lead)
        stream.write(lead)
        for content in contents:
            _write_array(stream, content, checksum)
        stream.write(checksum.hexdigest().encode() + b"\n")
    entries = {key: _entry(values, places, len(lead), first) for key, values, places in table}
    return Segment(path, dict(head), entries)


def _write_array(stream: BinaryIO, content: NDArray[Any], checksum: Any) -> None:
    """Write an array's bytes a piece at a time."""
    flat = content.reshape(-1).view(np.uint8)
    for first in range(0, len(flat), PIECE):
        piece = flat[first : first + PIECE].data
        checksum.update(piece)
        stream.write(piece)


def _stored(array: NDArray[Any]) -> NDArray[Any]:
    """Array in the order of bytes and elements that files have."""
    kind = array.dtype.newbyteorder("<")
    if kind.str not in TYPES:
        raise ValueError(f"array: {array.dtype} is no type that a checkpoint holds")
    return np.ascontiguousarray(array, dtype=kind)


def read_segment(path: Path) -> Segment:
    """Check a segment and read its table; arrays stay on the disk until they are asked for.

    Raises
    ------
    OutputError
        where it is missing, cut off, changed, or not a segment
    """
    try:
        with path.open("rb") as stream:
            size = path.stat().st_size
            _require_checksum(path, stream, size)
            stream.seek(len(MAGIC))
            line = stream.readline()
            begin = stream.tell()
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error.strerror or error}") from error
    try:
        head = json.loads(line)
        entries = {
            str(key): _entry(values, places, begin, head["bytes"])
            for key, values, places in head.pop("records")
        }
        if begin + head.pop("bytes") + CHECKSUM != size:
            raise ValueError("bytes")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise damaged(path) from error
    return Segment(path, head, entries)


def _require_checksum(path: Path, stream: BinaryIO, size: int) -> None:
    """Compare the checksum in the last line with that of everything before it."""
    if size < len(MAGIC) + CHECKSUM or stream.read(len(MAGIC)) != MAGIC:
        raise damaged(path, "cut off, or not a checkpoint of this version")
    checksum = hashlib.sha256(MAGIC)
    left = size - len(MAGIC) - CHECKSUM
    while left > 0:
        piece = stream.read(min(left, PIECE))
        if not piece:
            raise damaged(path)
        checksum.update(piece)
        left -= len(piece)
    if stream.read(CHECKSUM) != checksum.hexdigest().encode() + b"\n":
        raise damaged(path, "damaged: its checksum does not hold")


def _entry(values: Any, places: Any, begin: int, room: Any) -> Entry:
    """Check a row of the table; every array has to lie within the ``room`` bytes after ``begin``."""
    arrays = {}
    for name, (kind, shape, first) in places.items():
        numbers = [first, room, *shape]
        if kind not in TYPES or any(type(number) is not int or number < 0 for number in numbers):
            raise ValueError(name)
        if first + math.prod(shape) * np.dtype(kind).itemsize > room:
            raise ValueError(name)
        arrays[str(name)] = (str(kind), tuple(shape), begin + first)
    if not isinstance(values, dict):
        raise TypeError("values")
    return Entry(values, arrays)
