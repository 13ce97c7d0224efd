"""EULUMDAT files (.ldt): all symmetries, all lamp sets, decimal commas.

The format has one field a line in a fixed order (A. Stockmar, Licht 1990). Files with blank lines to spare are
read by leaving blank lines out where a number is due. Intensities are in cd/klm of the lamps' flux.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from lelight.errors import InputError
from lelight.photometry.eulumdatplanes import Declared, read_planes
from lelight.photometry.opening import Opening
from lelight.photometry.photometry import Finding, LampSet, Photometry
from lelight.photometry.symmetry import SYMMETRIES
from lelight.photometry.textfile import (
    LARGEST,
    MOST_INTENSITIES,
    SIZE_DECIMALS,
    Numbers,
    TextFile,
    parse_number,
)
from lelight.reading.inputfile import quoted

#: Utilisation factors for room indices 0.6 to 5 that close the header.
DIRECT_RATIOS = 10
#: Most planes, angles in a plane, and lamp sets.
MOST_PLANES, MOST_ANGLES, MOST_LAMP_SETS = 3601, 18_001, 100
#: Longest side of a luminaire in mm.
LONGEST = 1e6

#: A number, and what may stand behind it: a blank, a remark, or its unit.
_LEADING_NUMBER = re.compile(
    r"([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d{1,3})?)(?=(?:mm|lm|W|°|%)?(?:[\s;]|$))"
)


class _Lines:
    """Fields of the header, one a line.

    Parameters
    ----------
    skip_blank : True where blank lines are left out when a number is due
    """

    def __init__(self, text: TextFile, lines: list[tuple[int, str]], *, skip_blank: bool) -> None:
        self.text = text
        self.lines = lines
        self.skip_blank = skip_blank
        self.position = 0

    @property
    def line(self) -> int:
        """Line of the field that was taken last, counted from 1."""
        return self.lines[max(0, min(self.position, len(self.lines)) - 1)][0]

    def words(self) -> str:
        """Take a text; past the end there is none."""
        if self.position >= len(self.lines):
            raise self.text.error(len(self.text.lines), "the file ends within its header; it may be cut off")
        self.position += 1
        return self.lines[self.position - 1][1].strip().strip("\x00").strip()

    def number(self, what: str, *, default: float | None = None) -> float:
        """Take a number; a blank line is ``default`` where there is one."""
        words = self.words()
        while self.skip_blank and not words and self.position < len(self.lines):
            words = self.words()
        if not words and default is not None:
            return default
        match = _LEADING_NUMBER.match(words)
        found = parse_number(match[1].replace(",", ".")) if match else None
        if found is None or abs(found) > LARGEST:
            raise self.text.error(self.line, f"{what}: found {quoted(words)}; expected a number")
        return found

    def upcoming(self) -> str:
        """Text of the field that comes next, not taken."""
        return self.lines[self.position][1].strip() if self.position < len(self.lines) else ""

    def unused(self) -> None:
        """Take a field that nothing depends on, whatever it holds."""
        words = self.words()
        while self.skip_blank and not words and self.position < len(self.lines):
            words = self.words()

    def count(self, what: str, *, least: int, most: int) -> int:
        """Take a whole number."""
        found = self.number(what)
        if found != int(found) or not least <= found <= most:
            raise self.text.error(
                self.line, f"{what}: found {found:.10g}; expected a whole number from {least} to {most}"
            )
        return int(found)


@dataclass(frozen=True)
class _Header:
    table: Declared
    texts: dict[str, str]
    sizes: tuple[float, ...]
    downward: float
    output_ratio: float
    factor: float
    tilt: float
    lamps: tuple[LampSet, ...]
    absolute: bool
    findings: tuple[Finding, ...]


def read_eulumdat(text: TextFile) -> Photometry:
    """Make sense of an EULUMDAT file.

    Raises
    ------
    InputError
        with file, line, what was found and what is expected
    """
    numbered = [(k + 1, line) for k, line in enumerate(text.lines)]
    first_failure: InputError | None = None
    for lines, skip_blank in _readings(numbered):
        try:
            return _read(text, _Lines(text, lines, skip_blank=skip_blank))
        except InputError as failure:
            first_failure = first_failure or failure
    assert first_failure is not None
    raise first_failure


def _readings(lines: list[tuple[int, str]]) -> list[tuple[list[tuple[int, str]], bool]]:
    """Ways to take blank lines: as empty fields, as nothing before a number, as every second line's end."""
    ways = [(lines, False), (lines, True)]
    head = lines[:60]
    if len(head) > 8 and not any(line.strip() for _, line in head[1::2]):
        ways.insert(0, (lines[::2], False))
    leading = next((k for k, (_, line) in enumerate(lines) if line.strip()), 0)
    if leading:
        ways.append((lines[leading:], False))
    return ways


def _read(text: TextFile, lines: _Lines) -> Photometry:
    header = _header(lines)
    numbers = Numbers(text, header.table.line, decimal_comma=True, tails=True)
    findings = list(header.findings)
    gamma, planes = read_planes(text, header.table, numbers, findings)
    flux = header.lamps[0].flux
    candela = planes.candela * header.factor * flux / 1000.0
    if candela.max(initial=0.0) > LARGEST:
        raise text.error(
            header.table.line, f"found an intensity of {candela.max():g} cd; expected at most {LARGEST:g}"
        )
    return Photometry(
        c=planes.c,
        gamma=gamma,
        candela=candela,
        opening=_opening(header.sizes, findings),
        body=(header.sizes[0], header.sizes[1] or header.sizes[0], header.sizes[2]),
        lamps=header.lamps,
        absolute=header.absolute,
        declared_flux=flux * header.output_ratio / 100.0 if header.output_ratio > 0 else None,
        downward_share=header.downward / 100.0 if header.downward > 0 else None,
        power=header.lamps[0].watts,
        symmetry=header.table.symmetry,
        texts=header.texts,
        format="EULUMDAT",
        file=text.path.name,
        sha256=text.sha256,
        findings=tuple(findings),
    )


def _header(lines: _Lines) -> _Header:
    findings: list[Finding] = []
    texts = {"company": lines.words()}
    kind = int(lines.number("type indicator", default=0.0))
    texts["type"] = str(kind)
    symmetry = lines.count("symmetry indicator", least=0, most=4)
    planes = lines.count("number of C planes", least=1, most=MOST_PLANES)
    plane_step = lines.number("distance of C planes", default=0.0)
    angles = lines.count("number of angles in a plane", least=1, most=MOST_ANGLES)
    angle_step = lines.number("distance of angles", default=0.0)
    if planes * angles > MOST_INTENSITIES:
        raise lines.text.error(
            lines.line, f"declares {planes} planes x {angles} angles; expected at most {MOST_INTENSITIES}"
        )
    for key in ("report", "luminaire", "number", "file_name", "date"):
        texts[key] = lines.words()
    sizes = tuple(_size(lines, what) for what in _SIZES)
    downward = lines.number("downward flux fraction", default=0.0)
    output_ratio = lines.number("light output ratio", default=0.0)
    factor = lines.number("conversion factor", default=1.0)
    if not 0 < factor <= 1e6:
        findings.append(Finding("conversion-factor", "warning", f"found {factor:g}; read as 1", lines.line))
        factor = 1.0
    tilt = lines.number("tilt", default=0.0)
    if tilt:
        text = f"measured at a tilt of {tilt:g} degrees; γ is taken as the file counts it"
        findings.append(Finding("tilt", "info", text, lines.line))
    lamps, absolute = _lamps(lines, findings)
    for _ in range(DIRECT_RATIOS):
        lines.unused()
    end = lines.lines[lines.position - 1][0]
    table = Declared(SYMMETRIES[symmetry], planes, plane_step, angles, angle_step, end)
    return _Header(
        table, texts, sizes, downward, output_ratio, factor, tilt, lamps, absolute, tuple(findings)
    )


_SIZES = (
    "length of the luminaire",
    "width of the luminaire",
    "height of the luminaire",
    "length of the luminous area",
    "width of the luminous area",
    "height of the luminous area at C0",
    "height of the luminous area at C90",
    "height of the luminous area at C180",
    "height of the luminous area at C270",
)


def _size(lines: _Lines, what: str) -> float:
    """Length in m of a field in mm."""
    found = lines.number(what, default=0.0)
    if abs(found) > LONGEST:
        raise lines.text.error(lines.line, f"{what}: found {found:g} mm; expected at most {LONGEST:g}")
    return round(found / 1000.0, SIZE_DECIMALS)


def _lamps(lines: _Lines, findings: list[Finding]) -> tuple[tuple[LampSet, ...], bool]:
    """All lamp sets, and whether the photometry is absolute (a negative number of lamps)."""
    count = lines.count("number of lamp sets", least=0, most=MOST_LAMP_SETS)
    line = lines.line
    sets, absolute = [], False
    for index in range(count):
        lamps = lines.number("number of lamps", default=1.0)
        absolute |= index == 0 and lamps < 0
        kind = lines.words()
        flux = lines.number("luminous flux of the lamps", default=0.0)
        if flux < 0:
            raise lines.text.error(
                lines.line, f"luminous flux of the lamps: found {flux:g}; expected 0 or more"
            )
        colour, rendering = lines.words(), lines.words()
        watts = _watts(lines, findings)
        sets.append(LampSet(abs(int(lamps)), flux, max(watts, 0.0), kind, colour, rendering))
    if not sets:
        findings.append(Finding("no-lamps", "error", "no lamp set: read as 1000 lm", line))
        sets.append(LampSet(1, 1000.0, 0.0))
    if not sets[0].flux > 0:
        findings.append(
            Finding("no-flux", "error", "the first lamp set has no flux: the luminaire is dark", line)
        )
    if count > 1:
        others = ", ".join(f"{lamp.flux:g} lm" for lamp in sets[1:])
        findings.append(
            Finding(
                "lamp-sets",
                "info",
                f"{count} lamp sets are alternatives; the first ({sets[0].flux:g} lm) is used, not {others}",
                line,
            )
        )
    return tuple(sets), absolute


def _watts(lines: _Lines, findings: list[Finding]) -> float:
    """Power in W; words in its place are no reason to refuse the light."""
    words = lines.upcoming()
    try:
        return lines.number("watts", default=0.0)
    except InputError:
        findings.append(Finding("watts", "warning", f"found {quoted(words)}; read as 0 W", lines.line))
        return 0.0


def _opening(sizes: tuple[float, ...], findings: list[Finding]) -> Opening:
    """Make the opening of the luminous sizes; length lies along C90, width 0 is a circle."""
    length, width = sizes[3], sizes[4]
    if min(sizes) < 0:
        findings.append(Finding("negative-size", "error", "sizes are negative; their amounts are used"))
    length, width = abs(length), abs(width)
    heights = tuple(abs(size) for size in sizes[5:9])
    if length == 0 and width == 0 and not any(heights):
        return Opening()
    h0, h90, h180, h270 = heights
    if width == 0 and length > 0:
        return Opening("ellipse", length, length, (h0, h90, h180, h270))
    return Opening("rectangle", width, length, (h0, h90, h180, h270))
