"""Wavefront MTL files: the four keys that mean something for light, kept as written.

Format: Wavefront Technologies, "MTL material format", version 4.2. ``Kd`` is read as diffuse reflectance,
``Ks`` as specular reflectance, ``Ns`` as exponent, ``Ke`` as luminance in cd/m².
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from lelight.errors import InputError
from lelight.reading.inputfile import decoded, quoted
from lelight.reading.wavefront import finite_numbers, keyword_and_rest, wavefront_lines
from lelight.scene import FloatArray

_COLOURS = {b"Kd": "diffuse", b"Ks": "specular", b"Ke": "luminance"}


@dataclass(frozen=True)
class MtlMaterial:
    """What a file says about a material; None where it says nothing.

    Attributes
    ----------
    line : where its ``newmtl`` stands
    diffuse, specular : (3,) float, reflectance; not yet checked to be at most 1
    exponent : float, of the Phong lobe
    luminance : (3,) float, cd/m²
    """

    name: str
    path: Path
    line: int
    diffuse: FloatArray | None = None
    specular: FloatArray | None = None
    exponent: float | None = None
    luminance: FloatArray | None = None


@dataclass(frozen=True)
class MtlLibrary:
    """Materials of a file by name, and what had to be passed over."""

    materials: dict[str, MtlMaterial]
    warnings: tuple[str, ...] = ()


@dataclass
class _Reading:
    path: Path
    materials: dict[str, MtlMaterial] = field(default_factory=dict)
    current: MtlMaterial | None = None
    ignored: dict[bytes, None] = field(default_factory=dict)
    repeated: list[str] = field(default_factory=list)


def read_mtl(path: Path) -> MtlLibrary:
    """Read the materials of an MTL file.

    Raises
    ------
    InputError
        with the line, what was found and what is allowed
    """
    reading = _Reading(path)
    for number, line in wavefront_lines(path):
        keyword, rest = keyword_and_rest(line)
        try:
            _read_line(reading, keyword, rest, number)
        except ValueError as error:
            raise InputError.at(path, number, f"{decoded(keyword)}: {error}") from None
    return MtlLibrary(reading.materials, _warnings(reading))


def _read_line(reading: _Reading, keyword: bytes, rest: bytes, number: int) -> None:
    if keyword == b"newmtl":
        _begin(reading, rest, number)
    elif keyword in _COLOURS:
        _complete(reading, **{_COLOURS[keyword]: _colour(rest)})
    elif keyword == b"Ns":
        _complete(reading, exponent=_exponent(rest))
    elif len(reading.ignored) < 12:
        reading.ignored[keyword] = None


def _begin(reading: _Reading, rest: bytes, number: int) -> None:
    name = decoded(rest)
    if not name:
        raise ValueError("found no name; allowed is the name that usemtl gives")
    if name in reading.materials:
        reading.repeated.append(
            f"{reading.path.name}:{number}: newmtl {quoted(name)} again; the last one counts"
        )
    reading.current = MtlMaterial(name, reading.path, number)
    reading.materials[name] = reading.current


def _complete(reading: _Reading, **values: Any) -> None:
    if reading.current is None:
        raise ValueError("found before any newmtl; allowed is a newmtl line first")
    reading.current = replace(reading.current, **values)
    reading.materials[reading.current.name] = reading.current


def _colour(rest: bytes) -> FloatArray:
    components = finite_numbers(rest)
    if len(components) not in {1, 3} or min(components) < 0:
        raise ValueError(f"found {quoted(rest)}; allowed are one or three numbers, 0 or more")
    return np.broadcast_to(np.array(components, dtype=np.float64), (3,)).copy()


def _exponent(rest: bytes) -> float:
    components = finite_numbers(rest)
    if len(components) != 1 or components[0] < 0:
        raise ValueError(f"found {quoted(rest)}; allowed is one number, 0 or more")
    return components[0]


def _warnings(reading: _Reading) -> tuple[str, ...]:
    ignored: tuple[str, ...] = ()
    if reading.ignored:
        keywords = ", ".join(quoted(keyword)[1:-1] for keyword in reading.ignored)
        ignored = (f"{reading.path.name}: {keywords} carry no photometric meaning here and are ignored",)
    return (*ignored, *reading.repeated[:3])
