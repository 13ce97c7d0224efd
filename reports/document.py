"""From content to PDF: the one place that knows Typst.

Everything that comes from users is data: it reaches the templates as JSON, never as code.
"""

from __future__ import annotations

import json
import re
import tempfile
import unicodedata
import warnings
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

import typst

from lelight.errors import OutputError
from lelight.reports.texts import Texts, read_texts
from lelight.writing.files import whole

#: Endings of pictures that may be a logo.
LOGOS = (".svg", ".png", ".jpg", ".jpeg")
PAPERS = ("a3", "a4", "us-letter", "us-legal")
#: What Typst says where PDF/A forbids a letter that no font can draw.
NO_GLYPH = "could not be displayed"
MISSING_LETTER = re.compile(r'the text `"(.+?)"` could not be displayed')
#: Unicode categories without a shape, and bidirectional classes that override the direction of what follows.
UNDRAWN = frozenset({"Cc", "Cn", "Cs"})
TURNS = frozenset({"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"})


class MissingGlyphWarning(UserWarning):
    """A letter in a name is in no font of this machine: its number stands in for it."""


def write_document(
    path: Path,
    *,
    template: str,
    content: Mapping[str, Any],
    figures: Mapping[str, bytes],
    date: str | None,
    texts: Texts | None = None,
) -> Path:
    """Set a report and write it, whole or not at all.

    Parameters
    ----------
    template : name of the file in ``templates``
    content : what the template prints; strings, lists and objects of strings, no numbers to format
    figures : pictures by file name
    date : ISO date and time of the run, which becomes the date of the PDF
    """
    if content["paper"] not in PAPERS:
        raise ValueError(f"paper: {content['paper']!r} is none of {', '.join(PAPERS)}")
    texts = texts or read_texts()
    worded = {**content, "labels": texts.labels, "language": texts.language}
    with tempfile.TemporaryDirectory(prefix="lelight-report-") as folder:
        root = Path(folder)
        _lay_out(root, figures)
        pdf = _set(root, printable(worded), template, path, timestamp=timestamp_of(date))
    with whole(path) as beside:
        beside.write_bytes(pdf)
    return path


def read_logo(path: Path) -> dict[str, bytes]:
    """Picture for the cover under the name that templates know it by.

    Raises
    ------
    OutputError
        where it is missing or no picture that can be set
    """
    if path.suffix.lower() not in LOGOS:
        raise OutputError(f'{path}: found the ending "{path.suffix}"; a logo is one of {", ".join(LOGOS)}')
    try:
        picture = path.read_bytes()
    except OSError as error:
        raise OutputError(f"{path}: {error.strerror}; give a logo that is there") from error
    name = f"logo{path.suffix.lower()}"
    with tempfile.TemporaryDirectory(prefix="lelight-logo-") as folder:
        (Path(folder) / name).write_bytes(picture)
        (Path(folder) / "main.typ").write_text(f'#image("{name}")', encoding="utf-8")
        try:
            _compile(Path(folder) / "main.typ", system_fonts=False, archive=False, timestamp=0)
        except typst.TypstError as error:
            told = " ".join(error.message.split())
            raise OutputError(f"{path}: is no picture that can be set: {told}") from error
    return {name: picture}


def timestamp_of(date: str | None) -> int:
    """Seconds since 1970 of an ISO date; UTC where it names no zone, 0 where it is no date."""
    try:
        moment = datetime.fromisoformat(date or "")
        return int((moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp())
    except (ValueError, OverflowError, OSError):
        return 0


def printable(content: Any) -> Any:
    """Replace by spaces what no font draws: control characters, lone surrogates, turns of direction."""
    if isinstance(content, str):
        return "".join(" " if _unprintable(letter) else letter for letter in content)
    if isinstance(content, Mapping):
        return {key: printable(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [printable(item) for item in content]
    return content


def _unprintable(letter: str) -> bool:
    """Tell what has no shape, or would turn the letters that follow a name around."""
    return unicodedata.category(letter) in UNDRAWN or unicodedata.bidirectional(letter) in TURNS


def _lay_out(root: Path, figures: Mapping[str, bytes]) -> None:
    """Put the templates and the figures into one private folder, Typst's root."""
    for template in files("lelight.reports").joinpath("templates").iterdir():
        if template.name.endswith(".typ"):
            (root / template.name).write_bytes(template.read_bytes())
    for name, svg in figures.items():
        (root / name).write_bytes(svg)


def _write_content(root: Path, content: Mapping[str, Any]) -> None:
    text = json.dumps(content, ensure_ascii=False, allow_nan=False)
    (root / "content.json").write_text(text, encoding="utf-8")


def _set(root: Path, content: Mapping[str, Any], main: str, path: Path, *, timestamp: int) -> bytes:
    """Compile as PDF/A: with Typst's own fonts, else with the machine's, else with stand-ins for what no font has."""
    letters: frozenset[str] = frozenset()
    for system_fonts, archive in ((False, True), (True, True), (True, True), (True, False)):
        _write_content(root, _standing_in(content, letters))
        try:
            pdf = _compile(root / main, system_fonts=system_fonts, archive=archive, timestamp=timestamp)
        except typst.TypstError as error:
            if NO_GLYPH not in error.message:
                raise OutputError(f"{path}: cannot be set: {error.message}") from error
            letters = frozenset(MISSING_LETTER.findall(error.diagnostic)) if system_fonts else letters
            continue
        if letters or not archive:
            _warn_of(path, letters, archive=archive)
        return pdf
    raise OutputError(f"{path}: cannot be set: no font can draw its letters")


def _warn_of(path: Path, letters: frozenset[str], *, archive: bool) -> None:
    shown = ", ".join(sorted(map(stand_in, letters))[:5]) + (", ..." if len(letters) > 5 else "")
    text = f"{path}: no font here has the letters {shown}; they are written by their numbers"
    warnings.warn(text + ("" if archive else "; not PDF/A"), MissingGlyphWarning, stacklevel=5)


def stand_in(letters: str) -> str:
    """Write letters that no font has by their numbers in Unicode.

    >>> stand_in("\u6f22")
    '[U+6F22]'
    """
    return "[" + " ".join(f"U+{ord(letter):04X}" for letter in letters) + "]"


def _standing_in(content: Any, letters: frozenset[str]) -> Any:
    """Put stand-ins for these letters into all strings."""
    if isinstance(content, str):
        run = "|".join(map(re.escape, sorted(letters, key=len, reverse=True)))
        return re.sub(f"(?:{run})+", lambda found: stand_in(found[0]), content) if letters else content
    if isinstance(content, Mapping):
        return {key: _standing_in(value, letters) for key, value in content.items()}
    if isinstance(content, list):
        return [_standing_in(item, letters) for item in content]
    return content


def _compile(main: Path, *, system_fonts: bool, archive: bool, timestamp: int) -> bytes:
    pdf: bytes = typst.compile(
        main,
        root=main.parent,
        font_paths=typst.Fonts(include_system_fonts=system_fonts),
        pdf_standards=["a-2b"] if archive else [],
        timestamp=timestamp,
    )
    return pdf
