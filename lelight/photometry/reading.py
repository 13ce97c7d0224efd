"""Any photometric file: which format it is, told by what is in it and not by its name."""

from __future__ import annotations

from pathlib import Path

from lelight.errors import InputError
from lelight.photometry.eulumdat import read_eulumdat
from lelight.photometry.ies import TILT_LINE, read_ies
from lelight.photometry.photometry import Photometry
from lelight.photometry.textfile import TextFile, parse_number, read_text_file

#: Lines of EULUMDAT that hold numbers at the top of every file: symmetry, planes, angles.
_NUMERIC_LINES = (2, 3, 5)
_IES_ENDINGS, _EULUMDAT_ENDINGS = {".ies"}, {".ldt", ".eul", ".eulumdat"}


def read_photometry(path: str | Path) -> Photometry:
    """Read an IES LM-63 or EULUMDAT file.

    Raises
    ------
    InputError
        one line with file, line, what was found and what is expected
    """
    text = read_text_file(Path(path))
    ending = text.path.suffix.lower()
    if any(TILT_LINE.match(line) for line in text.lines) and not _looks_like_eulumdat(text):
        return read_ies(text)
    if _looks_like_eulumdat(text) or ending in _EULUMDAT_ENDINGS:
        return read_eulumdat(text)
    if ending in _IES_ENDINGS:
        return read_ies(text)
    raise InputError.at(
        text.path, 1, "is neither IES LM-63 (no line TILT=) nor EULUMDAT (no numbers in lines 3, 4 and 6)"
    )


def _looks_like_eulumdat(text: TextFile) -> bool:
    lines = text.lines
    if not any(line.strip() for line in lines[1:12:2]):
        lines = lines[::2]
    lines = tuple(lines[next((k for k, line in enumerate(lines) if line.strip()), 0) :])
    fields = [lines[k].strip().replace(",", ".") if k < len(lines) else "" for k in _NUMERIC_LINES]
    return all(parse_number(field) is not None for field in fields)
