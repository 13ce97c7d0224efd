"""Input files before they mean anything: their bytes, their hash, and pieces of them fit for a message."""

from __future__ import annotations

import hashlib
from pathlib import Path

from lelight.errors import InputError

#: Longest piece of a file that an error message repeats.
LONGEST_QUOTE = 60


def file_contents(path: Path) -> bytes:
    """Read a regular file whole; folders, pipes, missing and unreadable files are one-line errors."""
    try:
        if not path.is_file():
            raise InputError.at(path, None, _absence(path))
        return path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError.at(path, None, f"cannot be read: {reason}") from error


def _absence(path: Path) -> str:
    if path.is_dir():
        return "is a folder; give the file itself"
    if path.exists():
        return "is not a regular file"
    return "no such file; check the name and the folder"


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes in hexadecimal."""
    return hashlib.sha256(file_contents(path)).hexdigest()


def decoded(text: bytes) -> str:
    """Text of a name: UTF-8 where it is that, else Latin-1, which reads any byte.

    Decided name by name, so that an OBJ in UTF-8 and its MTL in Latin-1 still agree on ``Möbel``.
    """
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")


def quoted(found: object) -> str:
    """Piece of a file between quotes, cut and escaped so that a message stays one readable line."""
    text = decoded(found) if isinstance(found, bytes) else str(found)
    if len(text) > LONGEST_QUOTE:
        text = text[: LONGEST_QUOTE - 3] + "..."
    printable = (letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)
    return f'"{"".join(printable)}"'
