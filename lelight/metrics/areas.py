"""Bands around a task area: immediate surrounding and background, EN 12464-1.

Widths and ratios from memory of the standard and a companion text; not verified against it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lelight.metrics.grid import grid_spacing
from lelight.scene import FloatArray, MeasuringPlane

#: Maintained illuminance (lx) of the task, from the largest down, and what its surrounding then needs.
SURROUNDING = ((750.0, 500.0), (500.0, 300.0), (300.0, 200.0), (200.0, 150.0))
SURROUNDING_UNIFORMITY, BACKGROUND_UNIFORMITY = 0.40, 0.10
#: Share of the surrounding's illuminance that the background needs.
BACKGROUND_SHARE = 1 / 3

AreaKind = Literal["surrounding", "background"]


@dataclass(frozen=True)
class Area:
    """Points of a band in the plane of a task area.

    Attributes
    ----------
    points : (k, 3) float, m
    anchors : (k, 3) float, m; for each the nearest point of the task area
    """

    kind: AreaKind
    points: FloatArray
    anchors: FloatArray


def required_illuminance(task: float, kind: AreaKind) -> float:
    """Maintained illuminance (lx) of a band around a task area of ``task`` lx."""
    around = next((needed for least, needed in SURROUNDING if task >= least), task)
    return around if kind == "surrounding" else BACKGROUND_SHARE * around


def surrounding_areas(plane: MeasuringPlane) -> tuple[Area, ...]:
    """Bands that a plane asks for, the background outside the surrounding."""
    found = []
    if plane.surrounding > 0:
        found.append(_area(plane, "surrounding", 0.0, plane.surrounding))
    if plane.background > 0:
        found.append(_area(plane, "background", plane.surrounding, plane.surrounding + plane.background))
    return tuple(found)


def _area(plane: MeasuringPlane, kind: AreaKind, inner: float, outer: float) -> Area:
    """Cells no larger than the task's in a frame from ``inner`` to ``outer`` m around its rectangle."""
    length_u, length_v = float(np.linalg.norm(plane.u)), float(np.linalg.norm(plane.v))
    spacing = grid_spacing(
        max(length_u, length_v) if _compact(length_u, length_v) else min(length_u, length_v)
    )
    a, b = length_u + inner, length_v + inner
    strips = [
        ((-outer, length_u + outer), (-outer, -inner)),
        ((-outer, length_u + outer), (b, length_v + outer)),
        ((-outer, -inner), (-inner, b)),
        ((a, length_u + outer), (-inner, b)),
    ]
    places = np.concatenate([_cells(along_u, along_v, spacing) for along_u, along_v in strips])
    nearest = np.clip(places, 0.0, [length_u, length_v])
    axes = np.stack([plane.u / length_u, plane.v / length_v])
    return Area(kind, plane.origin + places @ axes, plane.origin + nearest @ axes)


def _compact(length_u: float, length_v: float) -> bool:
    return max(length_u, length_v) < 2 * min(length_u, length_v)


def _cells(along_u: tuple[float, float], along_v: tuple[float, float], spacing: float) -> FloatArray:
    """Middles (k, 2) of the cells of a rectangle."""
    u, v = (_middles(*ends, spacing) for ends in (along_u, along_v))
    return np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)


def _middles(start: float, end: float, spacing: float) -> FloatArray:
    count = max(1, int(np.ceil((end - start) / spacing - 1e-9)))
    return np.asarray(start + (np.arange(count) + 0.5) * (end - start) / count)
