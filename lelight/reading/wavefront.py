"""Lines and numbers of Wavefront text, the form that OBJ and MTL files share."""

from __future__ import annotations

import codecs
import io
import math
import re
from collections.abc import Iterator
from pathlib import Path

from lelight.errors import InputError
from lelight.reading.inputfile import file_contents, quoted

#: Bytes in one line, continued lines counted together; longer ones are not written by any exporter.
LONGEST_LINE = 1 << 20

_TOO_LONG = f"found a line of more than {LONGEST_LINE} bytes; allowed is Wavefront text"

_TEXTURE_AND_NORMAL = re.compile(rb"/[-+]?\d*(?:/[-+]?\d*)?(?!\S)")


def wavefront_lines(path: Path) -> Iterator[tuple[int, bytes]]:
    r"""Read logical lines that say something, with the number of the line they begin on.

    Byte order mark, ``\r\n`` and ``\r`` ends, comment lines and lines continued by ``\`` are dealt with.
    """
    contents = _text(path)
    begun: list[bytes] = []
    begun_at = length = 0
    for number, line in enumerate(io.BytesIO(contents), start=1):
        length = len(line) + (length if begun else 0)
        if length > LONGEST_LINE:
            raise InputError.at(path, begun_at if begun else number, _TOO_LONG)
        stripped = line.strip()
        if stripped.startswith(b"#") and not begun:
            continue
        if stripped.endswith(b"\\"):
            begun_at = begun_at if begun else number
            begun.append(stripped[:-1])
        elif begun:
            yield begun_at, b" ".join([*begun, stripped])
            begun = []
        elif stripped:
            yield number, stripped
    if begun:
        yield begun_at, b" ".join(begun)


def _text(path: Path) -> bytes:
    contents = file_contents(path)
    if b"\0" in contents:
        raise InputError.at(path, None, "found zero bytes, so it is binary; allowed is a text file")
    contents = contents.removeprefix(codecs.BOM_UTF8)
    if b"\r" in contents:
        contents = contents.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return contents


def keyword_and_rest(line: bytes) -> tuple[bytes, bytes]:
    """Split ``usemtl red brick`` into ``usemtl`` and ``red brick``; the rest may be empty."""
    cells = line.split(None, 1)
    return (cells[0], cells[1]) if len(cells) == 2 else (line.strip(), b"")


def numbers(text: bytes) -> list[float]:
    """Numbers separated by white space, up to a comment; ValueError names what is not one.

    Python's own number syntax is wider than the format's: ``1_000`` is refused here.
    """
    cells = text.partition(b"#")[0].split()
    if b"_" in text:
        raise ValueError(f"found {quoted(text)}; allowed are numbers like 0.25 or 1e-3")
    try:
        return [float(cell) for cell in cells]
    except ValueError:
        culprit = next(cell for cell in cells if not _is_number(cell))
        raise ValueError(f"found {quoted(culprit)}; allowed are numbers like 0.25 or 1e-3") from None


def finite_numbers(text: bytes) -> list[float]:
    """Like :func:`numbers`, without NaN and infinity."""
    parsed = numbers(text)
    if not all(map(math.isfinite, parsed)):
        raise ValueError(f"found {quoted(text)}; allowed are finite numbers")
    return parsed


def texture_free(text: bytes) -> list[int]:
    """Vertex numbers of ``1/2/3 4/5/6 ...``, as written; ValueError says what is not of that form."""
    cells = text.partition(b"#")[0]
    if b"/" in cells:
        cells = _TEXTURE_AND_NORMAL.sub(b"", cells)
    try:
        if b"_" not in cells:
            return [int(cell) for cell in cells.split()]
    except ValueError:
        pass
    raise ValueError(f"found {quoted(text)}; allowed are corners like 7, 7/2, 7//3 or 7/2/3")


def _is_number(cell: bytes) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
