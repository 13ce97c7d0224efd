"""Observers and measuring planes out of a scene file's tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from lelight.metrics.en12464_tasks import TASKS
from lelight.scene import FloatArray, MeasuringPlane, Observer, Threshold

if TYPE_CHECKING:
    from lelight.reading.quantities import Triple
    from lelight.reading.scenetables import PlaneTable, SceneTables


def observers(tables: SceneTables) -> tuple[Observer, ...]:
    """Eyes, their directions brought to unit length."""
    return tuple(
        Observer(
            table.name,
            np.array(table.position),
            _unit(table.direction),
            task=None if table.task is None else np.array(table.task),
            threshold=_threshold(table.threshold),
        )
        for table in tables.observers
    )


def _threshold(spelled: str | None) -> Threshold | None:
    if spelled is None:
        return None
    number, kind = spelled.split()
    return Threshold(float(number), cast("Literal['absolute', 'task', 'picture']", kind))


def measuring_planes(tables: SceneTables) -> tuple[MeasuringPlane, ...]:
    """Planes to measure on, each with the requirements that are given."""
    return tuple(_plane(table) for table in tables.planes)


def _plane(table: PlaneTable) -> MeasuringPlane:
    """Take the wall band off a plane, and put a task's requirements under those that are given."""
    u, v = np.array(table.u), np.array(table.v)
    off_u, off_v = (table.wall_band * edge / np.linalg.norm(edge) for edge in (u, v))
    given = table.target.model_dump(exclude_none=True)
    task = given.pop("task", None)
    return MeasuringPlane(
        name=table.name,
        origin=np.array(table.origin) + off_u + off_v,
        u=u - 2 * off_u,
        v=v - 2 * off_v,
        target=(TASKS[task] if task else {}) | given,
        wall_band=table.wall_band,
        surrounding=table.surrounding,
        background=table.background,
    )


def _unit(direction: Triple) -> FloatArray:
    """Scale to unit length, by the largest component first so that no square underflows."""
    scaled = np.array(direction) / np.max(np.abs(direction))
    return np.asarray(scaled / np.linalg.norm(scaled))
