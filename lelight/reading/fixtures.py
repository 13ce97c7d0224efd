"""Observers and measuring planes out of a scene file's tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lelight.scene import FloatArray, MeasuringPlane, Observer

if TYPE_CHECKING:
    from lelight.reading.quantities import Triple
    from lelight.reading.scenetables import SceneTables


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
