"""Photometry written as IES LM-63-2002 or EULUMDAT, and what the format cannot hold."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lelight.errors import InputError
from lelight.photometry.ies import TEXT_KEYS
from lelight.photometry.iesopening import signed_sizes
from lelight.photometry.photometry import LampSet, Photometry
from lelight.photometry.symmetry import SYMMETRIES, Planes, Symmetry, sector, symmetry_of
from lelight.photometry.zones import downward_fraction, luminous_flux
from lelight.scene import FloatArray
from lelight.writing.files import write_text

#: Significant digits of an intensity.
DIGITS = 7
#: Longest text of a line.
LONGEST_TEXT, LONGEST_IES_LINE = 78, 256


@dataclass(frozen=True)
class Written:
    """Text of a file, and sentences about what it leaves out."""

    text: str
    lost: tuple[str, ...]


def convert(photometry: Photometry, out: Path) -> tuple[str, ...]:
    """Write as the format that the ending of ``out`` names; returns what could not be expressed.

    Raises
    ------
    InputError
        where the ending names no format
    """
    writer = {".ies": as_ies, ".ldt": as_eulumdat}.get(out.suffix.lower())
    if writer is None:
        raise InputError.at(out, None, f'found the ending "{out.suffix}"; allowed are .ies and .ldt')
    written = writer(photometry)
    write_text(out, written.text)
    return written.lost


def as_ies(photometry: Photometry) -> Written:
    """Write LM-63-2002, sizes in metres."""
    lost: list[str] = []
    lamps = photometry.lamps or (LampSet(1, 0.0, 0.0),)
    if len(lamps) > 1:
        lost.append(f"{len(lamps) - 1} alternative lamp sets: LM-63 has one")
    if any(photometry.body):
        lost.append("outer sizes of the luminaire: LM-63 has those of the luminous opening only")
    if len(set(photometry.opening.heights)) > 1:
        lost.append("different heights of the luminous sides: the largest is written for all")
    c, candela = _ies_planes(photometry, lost)
    sizes = signed_sizes(photometry.opening) or _with_one_height(photometry)
    absolute = photometry.absolute or not photometry.lamp_flux > 0
    count = max(lamps[0].count, 1)
    lumens = -1.0 if absolute else lamps[0].flux / count
    numbers = [str(count), _number(lumens), "1", str(len(photometry.gamma)), str(len(c)), "1", "2"]
    lines = ["IESNA:LM-63-2002", *_ies_texts(photometry, lost), *_ies_tilt(photometry)]
    lines.append(" ".join([*numbers, *(_number(size) for size in sizes)]))
    lines.append(f"1 1 {_number(photometry.power)}")
    for row in (photometry.gamma, c, *candela):
        lines += _wrapped(row)
    return Written("\r\n".join(lines) + "\r\n", tuple(lost))


def _with_one_height(photometry: Photometry) -> tuple[float, float, float]:
    from dataclasses import replace

    opening = photometry.opening
    signed = signed_sizes(replace(opening, heights=(opening.height,) * 4))
    assert signed is not None
    return signed


def _ies_texts(photometry: Photometry, lost: list[str]) -> list[str]:
    names = {text: key for key, text in reversed(TEXT_KEYS.items())}
    texts = {"report": "", "laboratory": "", "date": "", "company": ""} | photometry.texts
    lines = []
    for name, words in texts.items():
        key = names.get(name)
        if key is None:
            if words and name not in {"type", "file_name"}:
                key = f"_{name.upper().replace(' ', '_')}"
            else:
                continue
        room = LONGEST_IES_LINE - len(key) - 4
        if len(words) > room:
            lost.append(f"the end of [{key}]: a line holds {LONGEST_IES_LINE} characters")
        lines.append(f"[{key}] {' '.join(words[:room].split())}".rstrip())
    return lines


def _ies_tilt(photometry: Photometry) -> list[str]:
    if not len(photometry.tilt):
        return ["TILT=NONE"]
    angles, factors = photometry.tilt.T
    return ["TILT=INCLUDE", "1", str(len(angles)), *_wrapped(angles), *_wrapped(factors)]


def _ies_planes(photometry: Photometry, lost: list[str]) -> tuple[FloatArray, FloatArray]:
    """Horizontal angles and intensities that LM-63 wants for the symmetry of the data."""
    symmetry = writable_symmetry(photometry)
    if symmetry == "rotational":
        return np.zeros(1), photometry.candela[:1]
    if symmetry != "none":
        first, last = (90.0, 270.0) if symmetry == "c90-c270" else sector(symmetry)
        own = (photometry.c >= first - 1e-6) & (photometry.c <= last + 1e-6)
        return photometry.c[own], photometry.candela[own]
    c, candela = photometry.closed()
    if c[0] > 1e-6:
        lost.append("planes that do not start at C 0: the plane at 0 and 360 is interpolated")
        at_zero = photometry.intensity(0.0, photometry.gamma)
        c = np.concatenate([[0.0], photometry.c, [360.0]])
        candela = np.concatenate([at_zero[None], photometry.candela, at_zero[None]])
    return c, candela


def writable_symmetry(photometry: Photometry) -> Symmetry:
    """Symmetry of the data, "none" where the sector that would be written lacks its border planes."""
    found = symmetry_of(Planes(photometry.c, photometry.candela))
    if found in {"none", "rotational"}:
        return found
    first, last = sector(found)
    turned = (
        np.where(photometry.c > 180.0 + 1e-6, photometry.c - 360.0, photometry.c)
        if first < 0
        else photometry.c
    )
    inside = (turned >= first - 1e-6) & (turned <= last + 1e-6)
    borders = all(np.any(np.abs(turned - border) < 1e-6) for border in (first, last))
    parts = 4 if found == "both" else 2
    fits = len(photometry.c) % parts == 0 and int(inside.sum()) == len(photometry.c) // parts + 1
    return found if borders and fits else "none"


def _wrapped(row: FloatArray) -> list[str]:
    """Numbers in lines of ten."""
    words = [_number(number) for number in row]
    return [" ".join(words[k : k + 10]) for k in range(0, len(words), 10)]


def _number(number: float) -> str:
    return f"{number:.{DIGITS}g}"


def as_eulumdat(photometry: Photometry) -> Written:
    """Write EULUMDAT; absolute photometry by a negative number of lamps (Ashdown & DIAL 2009)."""
    lost: list[str] = []
    flux = luminous_flux(photometry)
    absolute = photometry.absolute or not photometry.lamp_flux > 0
    lamps = photometry.lamps or (LampSet(1, 0.0, photometry.power),)
    if absolute and not lamps[0].flux > 0:
        lamps = (LampSet(max(lamps[0].count, 1), float(_number(flux)), photometry.power, lamps[0].kind),)
    if photometry.texts.get("tilt") or len(photometry.tilt):
        lost.append("factors of lamps that depend on tilt: EULUMDAT has none")
    if photometry.opening.shape not in {"point", "rectangle"}:
        _say_opening(photometry, lost)
    symmetry = writable_symmetry(photometry)
    c, columns = _eulumdat_planes(photometry, symmetry)
    scale = 1000.0 / lamps[0].flux if lamps[0].flux > 0 else 0.0
    leaving = photometry.declared_flux or flux
    ratio = (
        100.0 if absolute and not photometry.declared_flux else 100.0 * leaving / max(lamps[0].flux, 1e-300)
    )
    lines = [
        _text(photometry, "company", lost),
        photometry.texts.get("type") or ("1" if symmetry == "rotational" else "3"),
        str(SYMMETRIES.index(symmetry)),
        str(len(c)),
        _number(_step(c)),
        str(len(photometry.gamma)),
        _number(_step(photometry.gamma)),
        *(_text(photometry, key, lost) for key in ("report", "luminaire", "number", "file_name", "date")),
        *(_number(1000.0 * size) for size in _eulumdat_sizes(photometry)),
        _number(
            100.0
            * (
                downward_fraction(photometry)
                if photometry.downward_share is None
                else photometry.downward_share
            )
        ),
        _number(ratio),
        "1",
        "0",
        str(len(lamps)),
    ]
    for lamp in lamps:
        count = max(lamp.count, 1)
        lines += [str(-count if absolute else count), lamp.kind[:24], _number(lamp.flux), lamp.colour[:16]]
        lines += [lamp.rendering[:6], _number(lamp.watts)]
    lines += ["0"] * 10
    for row in (c, photometry.gamma, *(scale * column for column in columns)):
        lines += [_number(number) for number in row]
    return Written("\r\n".join(lines) + "\r\n", tuple(lost))


def _say_opening(photometry: Photometry, lost: list[str]) -> None:
    opening = photometry.opening
    if opening.shape == "ellipse" and opening.along_c0 == opening.along_c90:
        return
    lost.append(f"the shape of the luminous opening ({opening.shape}): EULUMDAT has rectangles and circles")


def _eulumdat_sizes(photometry: Photometry) -> tuple[float, ...]:
    """Lines 13 to 21 in m: luminaire and luminous area; a circle has width 0."""
    opening = photometry.opening
    length, width = opening.along_c90, opening.along_c0
    if opening.shape == "ellipse" and length == width:
        width = 0.0
    body = photometry.body if any(photometry.body) else (length, width, opening.height)
    return (*body, length, width, *opening.heights)


def _text(photometry: Photometry, key: str, lost: list[str]) -> str:
    words = " ".join(photometry.texts.get(key, "").split())
    if len(words) > LONGEST_TEXT:
        lost.append(f"the end of the text {key}: a line holds {LONGEST_TEXT} characters")
    return words[:LONGEST_TEXT]


def _eulumdat_planes(photometry: Photometry, symmetry: Symmetry) -> tuple[FloatArray, FloatArray]:
    """C angles of a whole turn, and the columns of the sector that the symmetry leaves."""
    if symmetry == "rotational":
        return np.arange(0.0, 360.0, 15.0), photometry.candela[:1]
    if symmetry == "none":
        return photometry.c, photometry.candela
    first, last = sector(symmetry)
    turned = (
        np.where(photometry.c > 180.0 + 1e-6, photometry.c - 360.0, photometry.c)
        if first < 0
        else photometry.c
    )
    order = np.argsort(turned, kind="stable")
    own = order[(turned[order] >= first - 1e-6) & (turned[order] <= last + 1e-6)]
    return photometry.c, photometry.candela[own]


def _step(angles: FloatArray) -> float:
    """Distance of angles in degrees, 0 where they are not evenly spread."""
    steps = np.diff(angles)
    if not len(steps) or np.ptp(steps) > 1e-6:
        return 0.0
    return float(steps[0])
