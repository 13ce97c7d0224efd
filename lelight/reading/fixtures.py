"""Luminaires, observers and measuring planes out of a scene file's tables."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lelight.errors import InputError
from lelight.reading.inputfile import quoted
from lelight.scene import FloatArray, MeasuringPlane, Observer, PointLuminaire

if TYPE_CHECKING:
    from lelight.reading.quantities import Triple
    from lelight.reading.scenetables import LuminaireTable, SceneTables


def point_luminaires(tables: SceneTables, scene_path: Path | None) -> tuple[PointLuminaire, ...]:
    """Isotropic luminaires with dimming and maintenance applied.

    Raises
    ------
    InputError
        where a luminaire is given by a photometry file
    """
    return tuple(_luminaire(table, index, scene_path) for index, table in enumerate(tables.luminaires))


def _luminaire(table: LuminaireTable, index: int, scene_path: Path | None) -> PointLuminaire:
    if table.intensity is None:
        raise InputError(
            f"{scene_path}: luminaires[{index}].photometry: found {quoted(table.photometry)}; "
            "this version reads intensity (cd) only; give it instead"
        )
    intensity = table.dimming * table.maintenance * np.array(table.intensity)
    return PointLuminaire(table.name, np.array(table.position), intensity)


def observers(tables: SceneTables) -> tuple[Observer, ...]:
    """Eyes, their directions brought to unit length."""
    return tuple(
        Observer(table.name, np.array(table.position), _unit(table.direction)) for table in tables.observers
    )


def measuring_planes(tables: SceneTables) -> tuple[MeasuringPlane, ...]:
    """Planes to measure on, each with the requirements that are given."""
    return tuple(
        MeasuringPlane(
            name=table.name,
            origin=np.array(table.origin),
            u=np.array(table.u),
            v=np.array(table.v),
            target=table.target.model_dump(exclude_none=True),
        )
        for table in tables.planes
    )


def _unit(direction: Triple) -> FloatArray:
    """Scale to unit length, by the largest component first so that no square underflows."""
    scaled = np.array(direction) / np.max(np.abs(direction))
    return np.asarray(scaled / np.linalg.norm(scaled))
