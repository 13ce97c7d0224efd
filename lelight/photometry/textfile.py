"""Photometric files before they mean anything: text, lines and numbers, and where each number stood."""

from __future__ import annotations

import codecs
import hashlib
import re
from array import array
from dataclasses import dataclass
from pathlib import Path

from lelight.errors import InputError
from lelight.photometry.photometry import Finding
from lelight.reading.inputfile import file_contents, quoted

#: Largest file in bytes; the finest goniophotometer tables take a tenth of it.
LARGEST_FILE = 16 << 20
#: Most intensities of one table.
MOST_INTENSITIES = 2_000_000
#: Decimals of a degree that tell two angles apart.
ANGLE_DECIMALS = 6
#: Decimals of a metre that tell two sizes apart.
SIZE_DECIMALS = 7
#: Largest intensity in cd and flux in lm; a lighthouse has 1e8.
LARGEST = 1e12

#: Largest share of control characters in a text.
MOST_CONTROLS = 0.02

_CONTROLS = bytes(k for k in range(32) if k not in b"\t\n\v\f\r")
#: No number of a photometric file is larger.
ABSURD = 1e18

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d{1,3})?")
_SEPARATORS = re.compile(r"[\s,;]+")
_WHITE = re.compile(r"[\s;]+")


@dataclass(frozen=True)
class TextFile:
    """A text file in lines, whatever its encoding and line ends were."""

    path: Path
    lines: tuple[str, ...]
    sha256: str

    def error(self, line: int | None, message: str) -> InputError:
        """One-line error at a line, counted from 1."""
        return InputError.at(self.path, line, message)


def read_text_file(path: Path) -> TextFile:
    """Read UTF-8 (with or without mark), UTF-16 with mark, or else Latin-1.

    Raises
    ------
    InputError
        where the file is binary, empty or larger than any photometric file
    """
    contents = _bounded_contents(path)
    text = _decoded(path, contents)
    # Files that were sent as binary and as text have carriage returns to spare.
    text = re.sub(r"\r+\n|\r", "\n", text)
    # DOS ended text at Ctrl-Z.
    text = text.split("\x1a", 1)[0]
    lines = tuple(line.rstrip("\x00") for line in text.split("\n"))
    if not any(line.strip() for line in lines):
        raise InputError.at(path, 1, "is empty; expected an IES LM-63 or EULUMDAT file")
    return TextFile(path, lines, hashlib.sha256(contents).hexdigest())


def _bounded_contents(path: Path) -> bytes:
    try:
        size = path.stat().st_size if path.is_file() else 0
    except (OSError, ValueError):
        size = 0
    if size > LARGEST_FILE:
        raise InputError.at(
            path, None, f"has {size} bytes; a photometric file has at most {LARGEST_FILE}; check the file"
        )
    return file_contents(path)


def _decoded(path: Path, contents: bytes) -> str:
    if contents.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return contents.decode("utf-16", errors="replace")
    body = contents.rstrip(b"\x00\x1a\r\n \t")
    controls = len(body) - len(body.translate(None, delete=_CONTROLS))
    if b"\x00" in body or controls > MOST_CONTROLS * len(body):
        line = body[: max(0, body.find(b"\x00"))].count(b"\n") + 1
        raise InputError.at(path, line, "is binary; expected the text of an IES LM-63 or EULUMDAT file")
    try:
        return contents.decode("utf-8-sig")
    except UnicodeDecodeError:
        return contents.decode("latin-1")


def parse_number(token: str) -> float | None:
    """Value of one decimal number up to 1e18, None where it is none; ``nan`` and ``1_000`` are none."""
    if not _NUMBER.fullmatch(token):
        return None
    found = float(token.replace("d", "e").replace("D", "e"))
    return found if abs(found) <= ABSURD else None


class Numbers:
    """Numbers of a file from some line on, taken one after the other.

    Parameters
    ----------
    first : index of the first line to read
    decimal_comma : True where a comma inside a number is its decimal sign, not a separator
    tails : True where words behind a line's numbers are remarks; else only those behind a semicolon are
    """

    def __init__(
        self, text: TextFile, first: int, *, decimal_comma: bool = False, tails: bool = False
    ) -> None:
        self.text = text
        self.values = array("d")
        self.line_numbers = array("l")
        self.stopped_by: str | None = None
        self.stopped_at = len(text.lines)
        self.position = 0
        split = _WHITE if decimal_comma else _SEPARATORS
        for index in range(first, len(text.lines)):
            word = self._read_line(split.split(text.lines[index]), index + 1, decimal_comma)
            if word is None:
                continue
            begins = not self.values or self.line_numbers[-1] != index + 1
            if begins or not (tails or ";" in text.lines[index].split(word, 1)[0]):
                self.stopped_by, self.stopped_at = word, index + 1
                break

    def _read_line(self, tokens: list[str], line: int, decimal_comma: bool) -> str | None:
        """Keep the numbers that a line begins with; returns the word after them, None where there is none."""
        for token in tokens:
            plain = token.replace(",", ".") if decimal_comma else token
            found = parse_number(plain) if plain else None
            if found is not None:
                self.values.append(found)
                self.line_numbers.append(line)
            elif plain:
                return token
        return None

    @property
    def left(self) -> int:
        """How many numbers have not been taken."""
        return len(self.values) - self.position

    def trailing(self) -> list[Finding]:
        """Say what stands after the number that was taken last."""
        if self.left:
            text = f"{self.left} numbers after the last intensity; not used"
            return [Finding("trailing-data", "warning", text, self.line)]
        if self.stopped_by is not None:
            text = f"found {quoted(self.stopped_by)} after the last intensity"
            return [Finding("trailing-data", "info", text, self.stopped_at)]
        return []

    @property
    def line(self) -> int:
        """Line of the number that was taken last."""
        return self.line_numbers[max(0, min(self.position, len(self.values)) - 1)] if self.values else 1

    def take(self, what: str) -> float:
        """Take one number; ``what`` names it where it is missing."""
        return float(self.take_many(1, what)[0])

    def take_many(self, count: int, what: str) -> array[float]:
        """Take ``count`` numbers.

        Raises
        ------
        InputError
            where a word stands in their place, or the file ends
        """
        if count > self.left:
            raise self.text.error(self.stopped_at, self._missing(count, what))
        taken = self.values[self.position : self.position + count]
        self.position += count
        return taken

    def _missing(self, count: int, what: str) -> str:
        wanted = what if count == 1 else f"{count} numbers ({what})"
        if self.stopped_by is not None:
            return f"found {quoted(self.stopped_by)} after {self.left} numbers; expected {wanted}"
        return f"the file ends after {self.left} numbers; expected {wanted}; it may be cut off"

    def take_count(self, what: str, *, most: int) -> int:
        """Take a whole number from 1 to ``most``."""
        found = self.take(what)
        if found != int(found) or not 1 <= found <= most:
            raise self.text.error(
                self.line, f"{what}: found {found:.10g}; expected a whole number from 1 to {most}"
            )
        return int(found)
