"""Materials of a scene, put together from defaults, MTL files and the scene file's overrides.

Every later pattern that matches a name overrides only the keys it gives; ``luminance`` and ``flux`` override
each other. ``reflectance`` is the diffuse albedo Kd, ``specular`` is Ks, ``exponent`` is Ns. Of several
MTL files the first that defines a name counts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lelight.errors import SceneError
from lelight.reading.inputfile import quoted
from lelight.reading.limits import BRIGHTEST, SHARPEST
from lelight.reading.mtl import MtlLibrary, MtlMaterial
from lelight.reading.spectra import SpectrumFiles
from lelight.scene import FloatArray, Material

if TYPE_CHECKING:
    from lelight.reading.scenetables import MaterialTable

#: Diffuse reflectance of what nothing is said about.
GREY = 0.5

#: Kd + Ks may pass 1 by rounding of decimal fractions.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Palette:
    """What the files say about materials.

    Attributes
    ----------
    overrides : tables of the scene file by pattern, in its order
    scene_path : the scene file, to say where an override comes from
    """

    libraries: tuple[MtlLibrary, ...]
    overrides: Mapping[str, MaterialTable]
    scene_path: Path | None
    spectra: SpectrumFiles = field(default_factory=lambda: SpectrumFiles(Path()))

    def material(self, name: str, area: float) -> Material:
        """Put one material together; ``area`` in m² of all its faces turns flux into luminance.

        Raises
        ------
        SceneError
            where it would reflect more than it receives, or is beyond the limits
        """
        written, patterns = self._written(name), self._patterns(name)
        material = Material(name, np.full(3, GREY), origin=self._origin(written, patterns))
        if written is not None:
            material = _as_written(material, written)
        flux: float | None = None
        for pattern in patterns:
            table = self.overrides[pattern]
            material = self._coloured(overridden(material, table), table, pattern)
            flux = table.flux if table.luminance is None and table.flux is not None else flux
            flux = None if table.luminance is not None else flux
        if flux is not None:
            material = replace(material, luminance=_luminance(flux, area, material.emission_sides))
        check_material(material)
        return material

    def warnings(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Names that no file defines, and patterns that no name matches."""
        undefined = [name for name in names if self._written(name) is None and not self._patterns(name)]
        idle = [key for key in self.overrides if not any(fnmatchcase(name, key) for name in names)]
        return (
            *(
                f"material {quoted(name)} is defined nowhere: reflectance {GREY} is assumed"
                for name in undefined
            ),
            *(f"{self._scene_name}: materials.{quoted(key)} matches no material" for key in idle),
        )

    def _coloured(self, material: Material, table: MaterialTable, pattern: str) -> Material:
        """Put spectra on a material; a reflectance without one takes an earlier spectrum away."""
        key = f"materials.{quoted(pattern)}"
        if isinstance(table.reflectance, str):
            spectrum = self.spectra.reflectance(table.reflectance, f"{key}.reflectance")
            grey = float(np.mean(spectrum.amounts))
            material = replace(material, diffuse=np.full(3, grey), reflectance_spectrum=spectrum)
        elif table.reflectance is not None:
            material = replace(material, reflectance_spectrum=None)
        if table.spectrum is not None:
            emission = self.spectra.emission(table.spectrum, f"{key}.spectrum")
            material = replace(material, emission_spectrum=emission)
        return material

    @property
    def _scene_name(self) -> str:
        return self.scene_path.name if self.scene_path else ""

    def _written(self, name: str) -> MtlMaterial | None:
        return next((one.materials[name] for one in self.libraries if name in one.materials), None)

    def _patterns(self, name: str) -> list[str]:
        return [pattern for pattern in self.overrides if fnmatchcase(name, pattern)]

    def _origin(self, written: MtlMaterial | None, patterns: list[str]) -> str:
        places = [f"{written.path.name}:{written.line}"] if written else []
        places += [f"{self._scene_name} {quoted(pattern)}" for pattern in patterns]
        return ", ".join(places) or "default"


def _as_written(material: Material, written: MtlMaterial) -> Material:
    keys = ("diffuse", "specular", "exponent", "luminance")
    given = {key: getattr(written, key) for key in keys if getattr(written, key) is not None}
    return replace(material, **given)


def overridden(material: Material, table: MaterialTable) -> Material:
    """Override what a table gives, but for spectra and flux."""
    diffuse = None if isinstance(table.reflectance, str) else table.reflectance
    colours = {"diffuse": diffuse, "specular": table.specular, "luminance": table.luminance}
    plain = {"exponent": table.exponent, "emission_sides": table.sides}
    given: dict[str, Any] = {key: np.array(colour) for key, colour in colours.items() if colour is not None}
    given |= {key: setting for key, setting in plain.items() if setting is not None}
    return replace(material, **given)


def _luminance(flux: float, area: float, sides: str) -> FloatArray:
    """Luminance (3,) of a Lambertian emitter: its exitance, flux over area, is pi times its luminance."""
    emitting_area = 2 * area if sides == "both" else area
    return np.full(3, flux / (np.pi * emitting_area))


def check_material(material: Material) -> None:
    """Refuse a material that reflects more than it receives, or is beyond the limits.

    Raises
    ------
    SceneError
        with what was found and what is allowed
    """
    where = f"material {quoted(material.name)} ({material.origin})"
    if np.max(material.diffuse + material.specular) > 1 + ROUNDING:
        raise SceneError(
            f"{where}: found reflectance {listed(material.diffuse)} and specular "
            f"{listed(material.specular)}; allowed is a sum of at most 1 in each channel; lower Kd or Ks "
            "in the MTL, or override them in the TOML"
        )
    if np.max(material.luminance) > BRIGHTEST:
        found = listed(material.luminance)
        raise SceneError(
            f"{where}: found luminance {found} cd/m²; allowed is at most {BRIGHTEST:g}; lower it"
        )
    if material.exponent > SHARPEST:
        found = f"{material.exponent:g}"
        raise SceneError(f"{where}: found exponent {found}; allowed is at most {SHARPEST:g}; lower it")


def listed(colour: FloatArray) -> str:
    """Colour as a message shows it: one number where the three are equal."""
    components = [f"{component:.6g}" for component in colour]
    return components[0] if len(set(components)) == 1 else f"({', '.join(components)})"
