"""From the files a user names to a :class:`lelight.scene.Scene`, every material accounted for."""

from __future__ import annotations

from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lelight.errors import InputError, SceneError
from lelight.luminaires import PhotometricLuminaire
from lelight.mesh.doubles import without_repeated_faces
from lelight.reading.confinement import confined
from lelight.reading.fixtures import measuring_planes, observers
from lelight.reading.inputfile import file_hash, quoted
from lelight.reading.luminaires import ReadLuminaires, read_luminaires
from lelight.reading.mtl import read_mtl
from lelight.reading.obj import ObjGeometry, read_obj
from lelight.reading.palette import Palette
from lelight.reading.spectra import SpectrumFiles
from lelight.reading.surfaces import lit_surfaces
from lelight.scene import Outdoor, Scene

if TYPE_CHECKING:
    from lelight.reading.scenetables import SceneTables


def load(path: str | Path) -> Scene:
    """Read a scene from an ``.obj`` (and the ``.toml`` of its stem) or a ``.toml`` that names its geometry.

    Raises
    ------
    InputError
        where a file cannot be read; one line with file, line or key, what was found and what is allowed
    SceneError
        where the files are readable and what they describe cannot be lit
    """
    given = Path(path)
    scene_path = _scene_path(given)
    tables = _scene_tables(scene_path)
    geometry_path = _geometry_path(given, scene_path, tables)
    geometry = read_obj(geometry_path)
    scene = without_repeated_faces(_scene(given, scene_path, geometry_path, tables, geometry))
    require_light(scene)
    _require_spectra(scene)
    return scene


def require_light(scene: Scene) -> None:
    """Refuse a scene in which everything is dark.

    Raises
    ------
    SceneError
        where no face emits and no luminaire has an intensity
    """
    emitting = any(material.emits for material in scene.materials)
    if not emitting and not any(np.any(luminaire.intensity > 0) for luminaire in scene.luminaires):
        where = scene.path or scene.name
        raise SceneError(
            f"{where}: no light: no material emits and no luminaire has an intensity; give a material "
            "luminance or flux in the TOML (or Ke in the MTL), or add [[luminaires]] to the TOML"
        )


def _require_spectra(scene: Scene) -> None:
    """Refuse a scene of which some lamps have a spectrum and some have none."""
    from lelight.spectral.bands import is_spectral_scene, without_spectrum

    if is_spectral_scene(scene) and (missing := without_spectrum(scene)):
        named = ", ".join(quoted(name) for name in missing[:3])
        raise SceneError(
            f"{scene.path or scene.name}: no spectrum: {named}; where anything has a spectrum every emitter needs "
            'one; give spectrum = "D65", a CIE name or a file, in the TOML'
        )


def _scene_path(given: Path) -> Path | None:
    """Scene file that goes with what was given; an OBJ need not have one."""
    if given.suffix.lower() == ".toml":
        return given
    if given.suffix.lower() != ".obj":
        raise InputError.at(
            given, None, f"found the ending {quoted(given.suffix)}; allowed are .obj and .toml"
        )
    beside = given.with_suffix(".toml")
    return beside if _exists(beside) else None


def _scene_tables(scene_path: Path | None) -> SceneTables:
    """Tables of the scene file, or the defaults; pydantic takes 0.1 s to import, so it waits until here."""
    from lelight.reading.scenefile import read_scene_file
    from lelight.reading.scenetables import SceneTables

    return read_scene_file(scene_path) if scene_path else SceneTables()


def _geometry_path(given: Path, scene_path: Path | None, tables: SceneTables) -> Path:
    """OBJ file to read; asking for one OBJ while the scene file beside it names another is a mistake."""
    if scene_path is None or (scene_path != given and tables.geometry is None):
        return given
    named = scene_path.with_suffix(".obj")
    if tables.geometry:
        within = confined(scene_path.parent, tables.geometry)
        if within is None:
            raise _wrong_geometry(
                scene_path, Path(tables.geometry), "which leads out of the folder of the scene; put it there"
            )
        named = within
    if named.suffix.lower() != ".obj":
        raise _wrong_geometry(scene_path, named, "allowed is an .obj file")
    if given not in {scene_path, named}:
        raise _wrong_geometry(scene_path, named, f"but {quoted(given)} was asked for; give one of the two")
    if not _exists(named):
        raise _wrong_geometry(scene_path, named, "which is not there; name an .obj file relative to this one")
    return named


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def _wrong_geometry(scene_path: Path, named: Path, message: str) -> InputError:
    return InputError.at(scene_path, None, f"geometry: found {quoted(named)}; {message}")


def _scene(
    given: Path, scene_path: Path | None, geometry_path: Path, tables: SceneTables, geometry: ObjGeometry
) -> Scene:
    libraries = tuple(read_mtl(library) for library in geometry.material_libraries)
    surfaces = lit_surfaces(geometry_path, geometry, unit=tables.unit, up=tables.up)
    spectra = SpectrumFiles(scene_path or given)
    palette = Palette(libraries, tables.materials, scene_path, spectra)
    materials = tuple(map(palette.material, surfaces.material_names, surfaces.material_areas))
    lamps = read_luminaires(tables, scene_path, spectra)
    read = [
        geometry_path,
        *geometry.material_libraries,
        *([scene_path] if scene_path else []),
        *lamps.files,
        *spectra.paths,
    ]
    said = (library.warnings for library in libraries)
    return Scene(
        name=given.stem,
        vertices=surfaces.vertices,
        triangles=surfaces.triangles,
        triangle_materials=surfaces.triangle_materials,
        materials=materials,
        luminaires=lamps.luminaires,
        observers=observers(tables),
        planes=measuring_planes(tables),
        settings=tables.calc.model_dump(exclude_none=True),
        unit=tables.unit,
        up=tables.up,
        path=given,
        files=_hashes(read, given.parent),
        warnings=sum(said, geometry.warnings)
        + surfaces.warnings
        + palette.warnings(surfaces.material_names)
        + lamps.warnings
        + _idle_housings(lamps, surfaces.material_names),
        outdoor=Outdoor(tables.outdoor.plane, tables.outdoor.reflectance) if tables.outdoor else None,
    )


def _idle_housings(lamps: ReadLuminaires, names: Iterable[str]) -> tuple[str, ...]:
    """Say which housings no material of the scene belongs to."""
    patterns = {
        lamp.housing for lamp in lamps.luminaires if isinstance(lamp, PhotometricLuminaire) and lamp.housing
    }
    idle = sorted(pattern for pattern in patterns if not any(fnmatchcase(name, pattern) for name in names))
    return tuple(f"luminaires: housing {quoted(pattern)} matches no material" for pattern in idle)


def _hashes(paths: list[Path], folder: Path) -> dict[str, str]:
    """SHA-256 by name relative to the folder, so that two files of one name stay two."""
    names = (path.relative_to(folder) if path.is_relative_to(folder) else path for path in paths)
    return {name.as_posix(): file_hash(path) for name, path in zip(names, paths, strict=True)}
