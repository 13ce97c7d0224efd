"""Luminaires out of a scene file's tables: isotropic points, photometric files, and arrays of either."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lelight.errors import InputError
from lelight.luminaires import Luminaire, PhotometricLuminaire, moved, placed_axes, tilt_factor
from lelight.reading.confinement import confined
from lelight.reading.inputfile import quoted
from lelight.reading.spectra import SpectrumFiles
from lelight.scene import FloatArray, PointLuminaire

if TYPE_CHECKING:
    from lelight.photometry.photometry import Photometry
    from lelight.reading.scenetables import LuminaireTable, SceneTables


@dataclass(frozen=True)
class ReadLuminaires:
    """Luminaires of a scene, the photometric files they took, and what those files had to say."""

    luminaires: tuple[Luminaire, ...] = ()
    files: tuple[Path, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass
class _Photometries:
    """Photometric files by path, each read once."""

    scene_path: Path | None
    read: dict[Path, Photometry] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

    def of(self, named: str, key: str) -> Photometry:
        """Read the file that ``key`` names, relative to the scene file."""
        folder = self.scene_path.parent if self.scene_path is not None else Path()
        path = confined(folder, named)
        if path is None:
            raise InputError(
                f"{self.scene_path}: {key}: {quoted(named)} leads out of the folder of the scene; put it there"
            )
        if path not in self.read:
            self.read[path] = self._opened(path, named, key, folder)
        return self.read[path]

    def _opened(self, path: Path, named: str, key: str, folder: Path) -> Photometry:
        from lelight.photometry.findings import findings
        from lelight.photometry.reading import read_photometry

        if not _exists(path):
            raise InputError(
                f"{self.scene_path}: {key}: found {quoted(named)}, which is not there; searched the folder "
                f"{quoted(str(folder.resolve()))}; name a file relative to the scene file"
            )
        try:
            photometry = read_photometry(path)
        except InputError as failure:
            raise InputError(f"{self.scene_path}: {key}: {failure}") from failure
        for finding in findings(photometry):
            if finding.severity == "error":
                self.warnings.append(f"{named}: {finding.rule}: {finding.text}")
        return photometry


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def read_luminaires(tables: SceneTables, scene_path: Path | None, spectra: SpectrumFiles) -> ReadLuminaires:
    """Place all luminaires, dimming and maintenance applied, and give them their spectra.

    Raises
    ------
    InputError
        where a photometric file is missing or cannot be read, or c0 says nothing; names the key
    """
    photometries = _Photometries(scene_path)
    luminaires: list[Luminaire] = []
    for index, table in enumerate(tables.luminaires):
        key = f"luminaires[{index}]"
        spectrum = spectra.emission(table.spectrum, f"{key}.spectrum") if table.spectrum else None
        one = replace(
            _luminaire(table, key, scene_path, photometries), maintenance=table.maintenance, spectrum=spectrum
        )
        luminaires += _array(one, table)
    return ReadLuminaires(tuple(luminaires), tuple(photometries.read), tuple(photometries.warnings))


def _luminaire(
    table: LuminaireTable, key: str, scene_path: Path | None, photometries: _Photometries
) -> Luminaire:
    factor = table.dimming * table.maintenance
    position = np.array(table.position)
    if table.photometry is None:
        return PointLuminaire(table.name, position, factor * np.array(table.intensity))
    photometry = photometries.of(table.photometry, f"{key}.photometry")
    return PhotometricLuminaire(
        name=table.name,
        position=position,
        axes=_axes(table, key, scene_path),
        photometry=photometry,
        factor=factor * tilt_factor(photometry, np.array(table.aim)),
        housing=table.housing or "",
        path=table.photometry,
    )


def _axes(table: LuminaireTable, key: str, scene_path: Path | None) -> FloatArray:
    """Axes of the luminaire; where c0 is not given and would lie along the aim, y takes its place."""
    try:
        return placed_axes(np.array(table.aim), np.array(table.c0))
    except ValueError:
        if "c0" not in table.model_fields_set:
            return placed_axes(np.array(table.aim), np.array([0.0, 1.0, 0.0]))
        raise InputError(
            f"{scene_path}: {key}.c0: found {list(table.c0)}, parallel to aim; give a direction across the aim"
        ) from None


def _array(one: Luminaire, table: LuminaireTable) -> Iterator[Luminaire]:
    """Repeat a luminaire: columns along x, rows along y, from the place of the first."""
    if table.rows * table.columns == 1:
        yield one
        return
    along_x, along_y = table.spacings
    for row in range(table.rows):
        for column in range(table.columns):
            step = np.array([column * along_x, row * along_y, 0.0])
            yield moved(one, name=f"{table.name} {row + 1}.{column + 1}", by=step)
