"""Spectra as a scene file names them: a table of two columns, IES TM-27 (``.spdx``), or a CIE illuminant."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from lelight.errors import InputError
from lelight.reading.confinement import confined
from lelight.reading.inputfile import file_contents, quoted
from lelight.scene import Spectrum

#: A spectrum must say something about this much of the visible range, nm.
_SHORTEST, _LONGEST = 400.0, 700.0
_ENDINGS = (".csv", ".txt", ".spdx")


@dataclass
class SpectrumFiles:
    """Spectra read so far; owns them, so that a file is read once and its hash can be kept.

    Attributes
    ----------
    scene_path : names are relative to its folder
    """

    scene_path: Path
    _known: dict[tuple[str, bool], Spectrum] = field(default_factory=dict)
    paths: list[Path] = field(default_factory=list)

    def emission(self, name: str, key: str) -> Spectrum:
        """Spectral power of a lamp by the name of a file or a CIE illuminant; ``key`` is where it stands."""
        return self._read(name, key, _checked_emission, illuminants=True)

    def reflectance(self, name: str, key: str) -> Spectrum:
        """Spectral reflectance by the name of a file, 0 to 1."""
        return self._read(name, key, _checked_reflectance, illuminants=False)

    def _read(self, name: str, key: str, check: Callable[[Spectrum], str], *, illuminants: bool) -> Spectrum:
        known = self._known.get((name, illuminants))
        if known is not None:
            return known
        spectrum = self._named(name, key, illuminants=illuminants)
        complaint = check(spectrum)
        if complaint:
            raise InputError(f"{self.scene_path}: {key}: {quoted(name)}: {complaint}")
        self._known[name, illuminants] = spectrum
        return spectrum

    def _named(self, name: str, key: str, *, illuminants: bool) -> Spectrum:
        if name.lower().endswith(_ENDINGS):
            path = confined(self.scene_path.parent, name)
            if path is None:
                raise InputError(
                    f"{self.scene_path}: {key}: {quoted(name)} leads out of the folder of the scene; put it there"
                )
            spectrum = read_spdx(path) if path.suffix.lower() == ".spdx" else read_table(path)
            if path not in self.paths:
                self.paths.append(path)
            return spectrum
        found = _illuminant(name) if illuminants else None
        if found is None:
            allowed = f"a file ending in {', '.join(_ENDINGS)}"
            allowed += " or a CIE illuminant such as D65, F11, LED-B3" if illuminants else ""
            raise InputError(f"{self.scene_path}: {key}: found {quoted(name)}; allowed is {allowed}")
        return found


def _illuminant(name: str) -> Spectrum | None:
    from lelight.spectral.colorimetry import illuminant

    return illuminant(name)


def read_table(path: Path) -> Spectrum:
    """Read wavelength in nm and amount from two columns; lines before the numbers and after # are passed over.

    Raises
    ------
    InputError
        where a line has no two numbers, or wavelengths do not ascend
    """
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(_text(path).splitlines(), start=1):
        content = line.partition("#")[0].strip()
        if not content:
            continue
        parts = [part for part in re.split(r"[,;\s]+", content) if part]
        try:
            rows.append((float(parts[0]), float(parts[1])))
        except (ValueError, IndexError):
            if rows:
                raise InputError.at(
                    path, number, f"found {quoted(content)}; allowed are two numbers, nm and amount"
                ) from None
    return _spectrum(path, rows)


def read_spdx(path: Path) -> Spectrum:
    """Read the spectral data of an IES TM-27 file, ``<SpectralData wavelength="380">0.1</SpectralData>``."""
    try:
        tree = ElementTree.fromstring(_text(path))
    except ElementTree.ParseError as error:
        raise InputError.at(path, error.position[0], f"is not XML: {error}; give an IES TM-27 file") from None
    rows = []
    for element in tree.iter():
        if element.tag.rpartition("}")[2] == "SpectralData":
            try:
                rows.append((float(element.get("wavelength", "")), float(element.text or "")))
            except ValueError:
                raise InputError.at(
                    path, None, f"SpectralData: found {quoted(str(element.attrib))}; allowed are numbers"
                ) from None
    return _spectrum(path, rows)


def _text(path: Path) -> str:
    try:
        return file_contents(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError.at(path, None, "is not UTF-8 text; save the file as UTF-8") from None


def _spectrum(path: Path, rows: list[tuple[float, float]]) -> Spectrum:
    table = np.array(rows, dtype=np.float64).reshape(-1, 2)
    if len(table) < 2:
        raise InputError.at(path, None, f"found {len(table)} samples; allowed are two or more")
    if not np.all(np.isfinite(table)) or np.any(np.diff(table[:, 0]) <= 0):
        raise InputError.at(
            path, None, "wavelengths must ascend and all numbers must be finite; sort the table"
        )
    if np.any(table[:, 1] < 0):
        raise InputError.at(path, None, f"found the amount {table[:, 1].min():g}; allowed is 0 or more")
    if table[0, 0] > _SHORTEST or table[-1, 0] < _LONGEST:
        raise InputError.at(
            path,
            None,
            f"found {table[0, 0]:g} to {table[-1, 0]:g} nm; allowed is what covers 400 to 700 nm; give nm",
        )
    return Spectrum(path.name, table[:, 0], table[:, 1])


def _checked_emission(spectrum: Spectrum) -> str:
    inside = (spectrum.wavelengths > _SHORTEST) & (spectrum.wavelengths < _LONGEST)
    return "" if np.any(spectrum.amounts[inside] > 0) else "it emits nothing visible; allowed is any power"


def _checked_reflectance(spectrum: Spectrum) -> str:
    largest = float(spectrum.amounts.max())
    return f"found reflectance {largest:g}; allowed is at most 1" if largest > 1 else ""
