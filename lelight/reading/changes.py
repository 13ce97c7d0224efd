"""Materials that are changed after a run: lines as in the ``[materials]`` table of a scene file."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import Any

from pydantic import ValidationError

from lelight.errors import InputError, SceneError
from lelight.reading.inputfile import quoted
from lelight.reading.palette import check_material, overridden
from lelight.reading.scenefile import complaint
from lelight.reading.scenetables import MaterialTable
from lelight.scene import Material, Scene

#: Keys that say how a surface reflects; light that it emits has been sent out already.
REFLECTION = ("reflectance", "specular", "exponent")


def read_changes(lines: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Read ``PATTERN = { reflectance = 0.3, specular = 0.1, exponent = 64 }``; tables by pattern.

    Raises
    ------
    InputError
        where a line is not of that form, or has other keys
    """
    changes: dict[str, dict[str, Any]] = {}
    for line in lines:
        pattern, _, text = line.partition("=")
        pattern = pattern.strip().strip("\"'")
        try:
            table = tomllib.loads(f"table = {text}")["table"]
        except (tomllib.TOMLDecodeError, KeyError) as error:
            raise _wrong(
                line, "allowed is NAME={ reflectance = 0.3, specular = 0.1, exponent = 64 }"
            ) from error
        if not isinstance(table, dict) or not table or not pattern:
            raise _wrong(line, "allowed is NAME={ reflectance = 0.3, specular = 0.1, exponent = 64 }")
        if other := [key for key in table if key not in REFLECTION]:
            raise _wrong(
                line, f"{quoted(other[0])} cannot be changed after a run; allowed are {', '.join(REFLECTION)}"
            )
        if isinstance(table.get("reflectance"), str):
            raise _wrong(line, "a spectrum cannot be given after a run; give numbers")
        _validated(table, line)
        changes[pattern] = table
    return changes


def changed(scene: Scene, changes: Mapping[str, Mapping[str, Any]]) -> Scene:
    """Give a scene other materials; of several patterns that match a name the last wins.

    Raises
    ------
    SceneError
        where a pattern matches no material, or a material would reflect more than it receives
    """
    for pattern in changes:
        if not any(fnmatchcase(material.name, pattern) for material in scene.materials):
            known = ", ".join(quoted(material.name) for material in scene.materials[:20])
            raise SceneError(f"--material {quoted(pattern)} matches no material; there are {known}")
    return replace(scene, materials=tuple(_changed(material, changes) for material in scene.materials))


def _changed(material: Material, changes: Mapping[str, Mapping[str, Any]]) -> Material:
    for pattern, given in changes.items():
        if fnmatchcase(material.name, pattern):
            table = _validated(given, pattern)
            spectrum = material.reflectance_spectrum if table.reflectance is None else None
            material = replace(
                overridden(material, table), reflectance_spectrum=spectrum, origin=f"relit {quoted(pattern)}"
            )
    check_material(material)
    return material


def _validated(table: Mapping[str, Any], line: str) -> MaterialTable:
    try:
        return MaterialTable.model_validate(dict(table))
    except ValidationError as error:
        raise InputError(f"--material {quoted(line)}: {complaint(error)}") from error


def _wrong(line: str, message: str) -> InputError:
    return InputError(f"--material: found {quoted(line)}; {message}")
