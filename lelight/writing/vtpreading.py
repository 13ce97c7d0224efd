"""Reading ``.vtp`` back: the form in which `polydata` has VTK write it, and nothing else.

VTK's own reader trusts what a file says of itself and ends the process where that is wrong. Here every size is
checked against the file before anything is made of it.

The form is that of "VTK XML file formats" (docs.vtk.org): XML with a table of arrays, then ``<AppendedData>`` with
their bytes in blocks of zlib.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from lelight.errors import OutputError
from lelight.scene import IntArray
from lelight.writing.polydata import PolyData

#: Types of numbers by their name in the file.
TYPES = {
    "Float64": "<f8", "Float32": "<f4", "Int64": "<i8", "Int32": "<i4", "Int16": "<i2", "Int8": "i1", "UInt8": "u1",
    "UInt16": "<u2", "UInt32": "<u4", "UInt64": "<u8",
}  # fmt: skip
HEADERS = {"UInt32": "<u4", "UInt64": "<u8"}
#: Bytes of all arrays together: at most so many times those of the file, and so many more.
MOST_TIMES, MOST_MORE = 64, 1 << 24
#: Longest table, and most of what it may count.
LONGEST_TABLE, MOST = 1 << 24, 1 << 40
_APPENDED = b"<AppendedData"


class _DamageError(Exception):
    """Something in the file is not as it says."""


class _ForeignError(Exception):
    """The file is VTK's, and not in the form that lelight gives it."""


@dataclass
class _Appended:
    """Arrays' bytes after the table; counts what has been taken."""

    contents: memoryview
    header: np.dtype[Any]
    room: int

    def array(self, element: ElementTree.Element, kind: str, count: int | None) -> NDArray[Any]:
        """Take an array of ``count`` numbers, or of as many as there are."""
        width = np.dtype(kind).itemsize
        pieces, size = self._blocks(_number(element, "offset"))
        if count is not None and size != count * width:
            raise _DamageError(f"array {element.get('Name')!r} has {size} bytes, not {count * width}")
        self.room -= size
        if self.room < 0 or size % width:
            raise _DamageError(f"array {element.get('Name')!r} is larger than the file can hold")
        found = bytearray(size)
        filled = 0
        for piece, length in pieces:
            unpacker = zlib.decompressobj()
            content = unpacker.decompress(piece, length)
            if len(content) != length or not unpacker.eof or unpacker.unused_data:
                raise _DamageError("a block is not of its length")
            found[filled : filled + length] = content
            filled += length
        return np.frombuffer(found, dtype=kind)

    def _blocks(self, first: int) -> tuple[list[tuple[memoryview, int]], int]:
        """Compressed blocks with the lengths of what is in them, and the length of all of it."""
        count, size, last = (int(n) for n in self._numbers(first, 3))
        if count == 0:
            return [], 0
        width = self.header.itemsize
        if count > len(self.contents) // width:
            raise _DamageError("it counts more blocks than it has bytes")
        begin = first + (3 + count) * width
        pieces = []
        lengths = [size] * count if last == 0 else [size] * (count - 1) + [last]
        for compressed, length in zip(self._numbers(first + 3 * width, count).tolist(), lengths, strict=True):
            piece = self.contents[begin : begin + compressed]
            if len(piece) != compressed:
                raise _DamageError("a block is cut off")
            pieces.append((piece, length))
            begin += compressed
        total = sum(lengths)
        if total > self.room:
            raise _DamageError("arrays are larger than the file can hold")
        return pieces, total

    def _numbers(self, first: int, count: int) -> NDArray[Any]:
        piece = self.contents[first : first + count * self.header.itemsize]
        if len(piece) != count * self.header.itemsize:
            raise _DamageError("it is cut off")
        return np.frombuffer(piece, dtype=self.header)


def read_polydata(path: Path) -> PolyData:
    """Read a ``.vtp`` whose polygons all have as many corners; markers and lines are left out.

    Raises
    ------
    OutputError
        where the file is missing, cut off, damaged or not poly data
    """
    try:
        contents = path.read_bytes()
    except OSError as error:
        raise OutputError(
            f"{path}: cannot be read: {error.strerror}: give the folder that lelight calc wrote"
        ) from error
    if not contents.rstrip().endswith(b"</VTKFile>"):
        raise OutputError(
            f"{path}: cut off or not a VTK file (no closing tag): write it again with lelight calc"
        )
    try:
        return _polydata(contents)
    except _ForeignError as error:
        raise OutputError(
            f"{path}: not a field of lelight: {error}: give field.vtp of a finished run"
        ) from error
    except (_DamageError, ElementTree.ParseError, ValueError, zlib.error, OverflowError) as error:
        told = " ".join(str(error).split())[:150]
        raise OutputError(f"{path}: damaged ({told}): write it again with lelight calc") from error


def _polydata(contents: bytes) -> PolyData:
    table, appended = _parts(contents)
    piece = table.find("PolyData/Piece")
    if piece is None:
        raise _ForeignError("it holds no poly data")
    points = _number(piece, "NumberOfPoints")
    polygons = _number(piece, "NumberOfPolys")
    others = sum(_number(piece, f"NumberOf{kind}") for kind in ("Verts", "Lines", "Strips"))
    place = piece.find("Points/DataArray")
    cell_data, field_data = piece.find("CellData"), table.find("PolyData/FieldData")
    return PolyData(
        points=np.zeros((0, 3))
        if place is None or points == 0
        else _shaped(place, appended, points).astype(np.float64),
        polygons=_polygons(piece, appended, polygons, points),
        point_arrays=_arrays(piece.find("PointData"), appended, points),
        cell_arrays=_arrays(cell_data, appended, others + polygons),
        texts=_texts(field_data, appended),
        cell_texts=_texts(cell_data, appended),
    )


def _parts(contents: bytes) -> tuple[ElementTree.Element, _Appended]:
    """Table of arrays, and their bytes."""
    end = contents.find(_APPENDED)
    if not 0 <= end <= LONGEST_TABLE:
        raise _ForeignError("it has no appended data")
    if b"<!" in contents[:end]:
        raise _DamageError("its table has declarations")
    table = ElementTree.fromstring(contents[:end] + b"</VTKFile>")
    if table.get("type") != "PolyData" or table.get("byte_order") != "LittleEndian":
        raise _ForeignError("it holds no poly data, lowest byte first")
    if table.get("compressor") != "vtkZLibDataCompressor" or table.get("header_type") not in HEADERS:
        raise _ForeignError("it is not compressed by zlib")
    tag_end = contents.find(b">", end)
    first = contents.find(b"_", tag_end) + 1
    if b'encoding="raw"' not in contents[end:tag_end] or first <= 0:
        raise _ForeignError("its appended data are not raw")
    last = contents.rindex(b"</AppendedData>") if b"</AppendedData>" in contents else 0
    if last < first:
        raise _DamageError("its appended data are cut off")
    header = np.dtype(HEADERS[str(table.get("header_type"))])
    return table, _Appended(memoryview(contents)[first:last], header, MOST_TIMES * len(contents) + MOST_MORE)


def _number(element: ElementTree.Element, name: str) -> int:
    found = int(element.get(name, "0"))
    if not 0 <= found <= MOST:
        raise _DamageError(f"{name} is {found}")
    return found


def _shaped(element: ElementTree.Element, appended: _Appended, rows: int) -> NDArray[Any]:
    """Array (rows,) or (rows, components)."""
    components = int(element.get("NumberOfComponents", "1"))
    kind = TYPES.get(str(element.get("type")))
    if kind is None or not 0 < components <= MOST:
        raise _DamageError(f"array {element.get('Name')!r} is of no known type")
    found = appended.array(element, kind, rows * components)
    return found if components == 1 else found.reshape(rows, components)


def _arrays(parent: ElementTree.Element | None, appended: _Appended, rows: int) -> dict[str, NDArray[Any]]:
    elements = [] if parent is None else parent.findall("DataArray")
    return {str(element.get("Name")): _shaped(element, appended, rows) for element in elements}


def _texts(parent: ElementTree.Element | None, appended: _Appended) -> dict[str, tuple[str, ...]]:
    elements = [] if parent is None else parent.findall("Array")
    return {
        str(element.get("Name")): tuple(_strings(appended.array(element, "u1", None)))
        for element in elements
        if element.get("type") == "String"
    }


def _strings(found: NDArray[Any]) -> Iterator[str]:
    """Texts that each end with a zero byte."""
    content = found.tobytes()
    for text in content.split(b"\0")[:-1]:
        yield text.decode("utf-8", errors="surrogateescape")


def _polygons(piece: ElementTree.Element, appended: _Appended, count: int, points: int) -> IntArray:
    """Corners (count, k) of the polygons, all of them points."""
    arrays = {element.get("Name"): element for element in piece.findall("Polys/DataArray")}
    if count == 0:
        return np.zeros((0, 1), dtype=np.int64)
    if not {"connectivity", "offsets"} <= set(arrays):
        raise _DamageError("polygons have no corners")
    ends = appended.array(arrays["offsets"], _kind(arrays["offsets"]), count).astype(np.int64)
    size = int(ends[0])
    if not 0 < size <= MOST or not np.array_equal(ends, size * np.arange(1, count + 1)):
        raise _DamageError("polygons have different numbers of corners")
    corners = appended.array(arrays["connectivity"], _kind(arrays["connectivity"]), math.prod((size, count)))
    if corners.min() < 0 or corners.max() >= points:
        raise _DamageError("polygons have corners that are no points")
    return corners.astype(np.int64).reshape(count, size)


def _kind(element: ElementTree.Element) -> str:
    kind = TYPES.get(str(element.get("type")))
    if kind is None or "f" in kind:
        raise _DamageError(f"array {element.get('Name')!r} holds no whole numbers")
    return kind
