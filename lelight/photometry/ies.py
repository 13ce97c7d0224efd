"""IES LM-63 files, editions 1986 to 2019, photometry of types C and B.

What can be understood in one way only is put right and reported as a finding; what cannot is refused.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from lelight.errors import InputError
from lelight.photometry.iesopening import opening_of
from lelight.photometry.photometry import Finding, LampSet, Photometry
from lelight.photometry.symmetry import Planes, in_order, mirrored
from lelight.photometry.textfile import (
    ANGLE_DECIMALS,
    LARGEST,
    MOST_INTENSITIES,
    SIZE_DECIMALS,
    Numbers,
    TextFile,
)
from lelight.photometry.typeb import complete, to_c_gamma
from lelight.reading.inputfile import quoted
from lelight.scene import FloatArray

#: Metres in the file's two units of length.
FEET, METRES = 0.3048, 1.0
#: Keywords by the names under which `Photometry.texts` keeps them.
TEXT_KEYS = {
    "MANUFAC": "company",
    "LUMINAIRE": "luminaire",
    "LUMCAT": "number",
    "TEST": "report",
    "ISSUEDATE": "date",
    "DATE": "date",
    "TESTLAB": "laboratory",
    "LAMP": "lamp",
    "LAMPCAT": "lamp_number",
}
#: Keywords that LM-63-2002 requires.
REQUIRED = ("TEST", "TESTLAB", "ISSUEDATE", "MANUFAC")
MOST_ANGLES = 100_000

_KEYWORD = re.compile(r"\s*\[([^\]]*)\]\s*(.*)")
TILT_LINE = re.compile(r"\s*TILT\s*=\s*(.*?)\s*$", re.IGNORECASE)
_EDITION = re.compile(r"\s*(?:IESNA|IES)\s*:?\s*(?:LM-63-|LM63-)?\s*(\d{4}|\d{2})", re.IGNORECASE)


@dataclass(frozen=True)
class _Header:
    edition: int
    texts: dict[str, str]
    tilt_line: int
    tilt: str
    findings: tuple[Finding, ...]


@dataclass(frozen=True)
class _Table:
    """Angles in degrees and intensities (n_h, n_v) as the file lists them, every factor applied."""

    vertical: FloatArray
    horizontal: FloatArray
    candela: FloatArray
    line: int


def read_ies(text: TextFile) -> Photometry:
    """Make sense of an LM-63 file.

    Raises
    ------
    InputError
        with file, line, what was found and what is expected
    """
    header = _header(text)
    try:
        read = _read_numbers(text, header, decimal_comma=False)
        doubtful = any(finding.rule == "trailing-data" for finding in read.findings)
    except InputError as failure:
        if not _commas_in_numbers(text, header):
            raise
        try:
            return _read_numbers(text, header, decimal_comma=True)
        except InputError:
            raise failure from None
    return _without_rest(text, header, read) if doubtful and _commas_in_numbers(text, header) else read


def _commas_in_numbers(text: TextFile, header: _Header) -> bool:
    return any(re.search(r"\d,\d", line) for line in text.lines[header.tilt_line :])


def _without_rest(text: TextFile, header: _Header, read: Photometry) -> Photometry:
    """Read with decimal commas where that leaves nothing over, else keep what was read."""
    try:
        other = _read_numbers(text, header, decimal_comma=True)
    except InputError:
        return read
    return read if any(finding.rule == "trailing-data" for finding in other.findings) else other


def _header(text: TextFile) -> _Header:
    """Read everything down to the TILT line."""
    findings: list[Finding] = []
    found = next(((k, m) for k, line in enumerate(text.lines) if (m := TILT_LINE.match(line))), None)
    if found is None:
        raise text.error(
            len(text.lines), "no line TILT=; expected one before the numbers of an IES LM-63 file"
        )
    index, match = found
    edition = _edition(text.lines[:index])
    if edition == 1986 and not any(_KEYWORD.match(line) for line in text.lines[:index]):
        findings.append(Finding("edition", "info", "no format line: read as LM-63-1986", 1))
    texts = _keywords(text.lines[:index], edition)
    missing = [key for key in REQUIRED if edition >= 2002 and key not in texts["keywords"].split()]
    if missing:
        named = ", ".join(f"[{key}]" for key in missing)
        findings.append(Finding("missing-keywords", "info", f"LM-63-{edition} asks for {named}", 1))
    first_word = (re.split(r"[\s;,]", match[1].upper()) or [""])[0]
    tilt = first_word if first_word in {"NONE", "INCLUDE"} else match[1].upper()
    return _Header(edition, texts, index + 1, tilt, tuple(findings))


def _edition(lines: tuple[str, ...]) -> int:
    for line in [line for line in lines if line.strip()][:3]:
        match = _EDITION.match(line)
        if match:
            year = int(match[1])
            return year if year > 99 else 1900 + year if year > 50 else 2000 + year
    return 1986


def _keywords(lines: tuple[str, ...], edition: int) -> dict[str, str]:
    """Texts by name; keywords that lelight has no name for keep their own."""
    texts: dict[str, str] = {}
    seen: list[str] = []
    last = ""
    for line in lines:
        match = _KEYWORD.match(line)
        if match and match[1].strip().upper() == "MORE" and last:
            texts[last] = f"{texts[last]} {match[2].strip()}".strip()
        elif match:
            key = match[1].strip().upper()
            seen.append(key)
            last = TEXT_KEYS.get(key, key.lower().lstrip("_"))
            texts.setdefault(last, match[2].strip())
        elif edition == 1986 and line.strip() and not _EDITION.match(line):
            texts["luminaire"] = f"{texts.get('luminaire', '')} {line.strip()}".strip()
    texts["keywords"] = " ".join(seen)
    return texts


def _read_numbers(text: TextFile, header: _Header, *, decimal_comma: bool) -> Photometry:
    numbers = Numbers(text, header.tilt_line, decimal_comma=decimal_comma)
    findings = list(header.findings)
    tilt = _tilt(text, header, numbers, findings)
    lamps = numbers.take("number of lamps")
    lumens = _bounded(numbers, numbers.take("lumens per lamp"), "lumens per lamp", lowest=-1.0)
    multiplier = _bounded(numbers, numbers.take("candela multiplier"), "candela multiplier", lowest=0.0)
    n_vertical, n_horizontal = _counts(text, numbers)
    kind = int(numbers.take("photometric type"))
    kind_line = numbers.line
    if kind not in (1, 2):
        raise text.error(
            kind_line, f"photometric type: found {_kind(kind)}; expected 1 (type C) or 2 (type B)"
        )
    unit = _unit(numbers, findings)
    sizes = [
        round(_bounded(numbers, numbers.take(what), what, lowest=-1e6) * unit, SIZE_DECIMALS)
        for what in ("width", "length", "height")
    ]
    ballast = _bounded(numbers, numbers.take("ballast factor"), "ballast factor", lowest=0.0)
    photometric = _bounded(numbers, numbers.take("ballast-lamp photometric factor"), "factor", lowest=0.0)
    watts = numbers.take("input watts")
    multiplier = _one_for_zero(multiplier, "candela multiplier", findings)
    ballast = _one_for_zero(ballast, "ballast factor", findings)
    factor = multiplier * ballast * _photometric_factor(header.edition, photometric, numbers.line, findings)
    if not 0 < factor < LARGEST:
        raise text.error(
            numbers.line, f"multiplier times factors: found {factor:g}; expected a number above 0"
        )
    table = _table(numbers, n_vertical, n_horizontal, factor)
    findings += numbers.trailing()
    table = _sane(text, table, findings)
    c, gamma, candela = _directions(text, kind, table, findings)
    absolute = lumens < 0
    count = abs(int(lamps)) if abs(lamps) < 1e6 else 0
    flux = 0.0 if absolute else max(count, 1) * lumens
    return Photometry(
        c=c,
        gamma=gamma,
        candela=candela,
        opening=opening_of(*sizes, edition=header.edition),
        lamps=(LampSet(count, flux, max(watts, 0.0), header.texts.get("lamp", "")),),
        absolute=absolute,
        power=max(watts, 0.0),
        symmetry=_symmetry_words(table.horizontal) if kind == 1 else "type B",
        texts={key: words for key, words in header.texts.items() if key != "keywords"},
        tilt=tilt,
        format=f"IES LM-63-{header.edition}",
        file=text.path.name,
        sha256=text.sha256,
        findings=tuple(findings),
    )


def _bounded(numbers: Numbers, found: float, what: str, *, lowest: float) -> float:
    if not lowest <= found <= LARGEST:
        raise numbers.text.error(
            numbers.line, f"{what}: found {found:.6g}; expected a number from {lowest:g} to {LARGEST:g}"
        )
    return found


def _one_for_zero(found: float, what: str, findings: list[Finding]) -> float:
    """Take a factor of zero, which a careless form leaves, for one."""
    if found == 0:
        findings.append(Finding("zero-factor", "error", f"the {what} is 0; read as 1"))
    return found or 1.0


def _kind(kind: int) -> str:
    return "3 (type A)" if kind == 3 else str(kind)


def _tilt(text: TextFile, header: _Header, numbers: Numbers, findings: list[Finding]) -> FloatArray:
    """Angles and factors of lamps whose light depends on tilt (n, 2)."""
    if header.tilt in {"NONE", ""}:
        if not header.tilt:
            findings.append(Finding("tilt", "warning", "TILT= is empty: read as NONE", header.tilt_line))
        return np.empty((0, 2))
    if header.tilt != "INCLUDE":
        raise text.error(
            header.tilt_line,
            f"TILT: found {quoted(header.tilt)}; expected NONE or INCLUDE; put that file's table after TILT=INCLUDE",
        )
    numbers.take("lamp-to-luminaire geometry")
    count = numbers.take_count("number of tilt angles", most=MOST_ANGLES)
    pairs = np.array([numbers.take_many(count, "tilt angles"), numbers.take_many(count, "tilt factors")]).T
    if np.any(pairs[:, 1] < 0) or np.any(np.abs(pairs) > 1e4):
        raise text.error(numbers.line, "tilt factors: expected numbers from 0 to 10000")
    return np.asarray(pairs[np.argsort(pairs[:, 0], kind="stable")])


def _counts(text: TextFile, numbers: Numbers) -> tuple[int, int]:
    vertical = numbers.take_count("number of vertical angles", most=2**40)
    line = numbers.line
    horizontal = numbers.take_count("number of horizontal angles", most=2**40)
    if vertical * horizontal > MOST_INTENSITIES or vertical * horizontal > numbers.left:
        raise text.error(
            line,
            f"declares {vertical} vertical x {horizontal} horizontal angles; the file holds "
            f"{numbers.left} more numbers"
            + ("" if numbers.stopped_by is None else f" before {quoted(numbers.stopped_by)}")
            + "; it may be cut off",
        )
    return vertical, horizontal


def _unit(numbers: Numbers, findings: list[Finding]) -> float:
    code = numbers.take("units type")
    if code not in (1, 2):
        findings.append(
            Finding(
                "unit",
                "warning",
                f"units type: found {code:g}, allowed are 1 (feet) and 2 (metres); read as metres",
                numbers.line,
            )
        )
    if code == 1:
        findings.append(Finding("unit-feet", "info", "sizes are in feet; shown in metres", numbers.line))
    return FEET if code == 1 else METRES


def _photometric_factor(edition: int, found: float, line: int, findings: list[Finding]) -> float:
    """Factor of the editions up to 1995; later ones keep the field for other uses."""
    if edition < 2002:
        return found if found > 0 else 1.0
    if edition < 2019 and found not in (0.0, 1.0):
        findings.append(
            Finding(
                "reserved-field",
                "warning",
                f"found {found:g} in the field kept for future use; not applied",
                line,
            )
        )
    return 1.0


def _table(numbers: Numbers, n_vertical: int, n_horizontal: int, factor: float) -> _Table:
    vertical = np.array(numbers.take_many(n_vertical, "vertical angles"))
    horizontal = np.array(numbers.take_many(n_horizontal, "horizontal angles"))
    line = numbers.line
    candela = np.array(numbers.take_many(n_vertical * n_horizontal, "candela"))
    return _Table(vertical, horizontal, factor * candela.reshape(n_horizontal, n_vertical), line)


def _sane(text: TextFile, table: _Table, findings: list[Finding]) -> _Table:
    """Sort angles, drop repeated ones and lift negative intensities to zero, all of it reported."""
    angles = np.concatenate([table.vertical, table.horizontal])
    if np.abs(angles).max() > 720.0:
        raise text.error(
            table.line, f"found an angle of {angles[np.abs(angles).argmax()]:g} degrees; expected -180 to 360"
        )
    if np.abs(table.candela).max() > LARGEST:
        raise text.error(
            table.line,
            f"found an intensity of {np.abs(table.candela).max():g} cd; expected at most {LARGEST:g}",
        )
    if table.candela.min() < 0:
        findings.append(
            Finding("negative-candela", "error", f"found {table.candela.min():g} cd; read as 0", table.line)
        )
    vertical, rows = _sorted_angles(table.vertical, "vertical", table.line, findings)
    horizontal, columns = _sorted_angles(table.horizontal, "horizontal", table.line, findings)
    candela = np.maximum(table.candela[np.ix_(columns, rows)], 0.0)
    return _Table(vertical, horizontal, candela, table.line)


def _sorted_angles(
    angles: FloatArray, what: str, line: int, findings: list[Finding]
) -> tuple[FloatArray, np.ndarray[tuple[int], np.dtype[np.int64]]]:
    sorted_, first = np.unique(np.round(angles, ANGLE_DECIMALS), return_index=True)
    if len(sorted_) < len(angles):
        findings.append(
            Finding("repeated-angles", "error", f"{what} angles come twice; the first is used", line)
        )
    if np.any(np.diff(first) < 0):
        findings.append(Finding("unsorted-angles", "error", f"{what} angles are not ascending; sorted", line))
    return sorted_, np.asarray(first, dtype=np.int64)


def _directions(
    text: TextFile, kind: int, table: _Table, findings: list[Finding]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """C planes of a whole turn, γ and candela."""
    if kind == 2:
        if table.vertical[0] < -180 or table.vertical[-1] > 180 or np.abs(table.horizontal).max() > 90 + 1e-6:
            raise text.error(table.line, "type B angles: expected -90 to 90")
        findings.append(Finding("type-b", "info", "type B is resampled to C and γ planes", table.line))
        return to_c_gamma(*_completed(table))
    if table.vertical[0] < -1e-6 or table.vertical[-1] > 180.0 + 1e-6:
        raise text.error(
            table.line,
            f"vertical angles run from {table.vertical[0]:g} to {table.vertical[-1]:g}; expected 0 to 180 (type C)",
        )
    planes = _whole_turn(table, findings)
    return planes.c, np.clip(table.vertical, 0.0, 180.0), planes.candela


def _completed(table: _Table) -> tuple[FloatArray, FloatArray, FloatArray]:
    horizontal, candela = complete(table.horizontal, table.candela)
    return horizontal, table.vertical, candela


def _whole_turn(table: _Table, findings: list[Finding]) -> Planes:
    """Mirror what the range of horizontal angles leaves out (LM-63-2002, clause on horizontal angles)."""
    planes = Planes(table.horizontal, table.candela)
    first, last = float(table.horizontal[0]), float(table.horizontal[-1])
    if len(table.horizontal) == 1:
        return Planes(np.zeros(1), table.candela)
    if abs(last - first - 360.0) < 1e-6:
        return in_order(planes)
    borders = abs(first / 90.0 - round(first / 90.0)) < 1e-6
    if borders and abs(last - first - 180.0) < 1e-6:
        return mirrored(planes, first)
    if borders and abs(last - first - 90.0) < 1e-6:
        return mirrored(mirrored(planes, first), last)
    step = float(np.max(np.diff(table.horizontal)))
    closes = 360.0 - (last - first) <= step + 1e-6
    findings.append(
        Finding(
            "open-planes",
            "info" if closes else "error",
            f"horizontal angles run from {first:g} to {last:g}, allowed ends are 0, 90, 180 and 360; "
            + ("the last plane joins the first" if closes else "the gap is interpolated"),
            table.line,
        )
    )
    return in_order(planes)


def _symmetry_words(horizontal: FloatArray) -> str:
    if len(horizontal) == 1:
        return "rotational"
    span = round(float(horizontal[-1] - horizontal[0]))
    if span == 180:
        return "c90-c270" if round(float(horizontal[0])) in {90, -90, 270} else "c0-c180"
    return "both" if span == 90 else "none"
