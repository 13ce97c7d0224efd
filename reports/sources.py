"""Glare sources of an observer: rows of their table and outlines on the picture."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lelight.camera import Fisheye, view_axes
from lelight.reports.figures.fisheye import Outline, cone_border
from lelight.reports.folder import Subject
from lelight.reports.rounding import MISSING, percent, significant
from lelight.reports.texts import Texts
from lelight.reports.viewpoints import direction_of
from lelight.scene import FloatArray


@dataclass(frozen=True)
class Source:
    """A glare source as ``metrics.json`` lists it.

    Attributes
    ----------
    luminance : float, cd/m²
    solid_angle : float, sr
    direction : (3,) float, in the eye's axes: right, up, forward; None where it is not known
    excluded : why it does not count; empty where it does
    """

    number: int
    name: str
    luminance: float
    solid_angle: float
    direction: FloatArray | None
    t_over_r: float | None
    h_over_r: float | None
    position_index: float | None
    visible_fraction: float | None
    excluded: str
    flags: tuple[str, ...]

    @property
    def glare(self) -> float:
        """Its term L² ω / p² of the rating (CIE 117), 0 where it is excluded."""
        if self.excluded or not self.position_index:
            return 0.0
        return self.luminance**2 * self.solid_angle / self.position_index**2

    @property
    def in_view(self) -> bool:
        """True before the eye, with some size, counted or not."""
        ahead = self.direction is None or self.direction[2] > 0
        return ahead and self.solid_angle > 0

    @property
    def outline(self) -> Outline | None:
        """Cone of the same solid angle on the picture; None behind the eye or without size."""
        if self.direction is None or not self.in_view:
            return None
        right, up, forward = self.direction
        border = cone_border(right, up, forward, self.solid_angle)
        return Outline(border, str(self.number), counted=not self.excluded)


def sources_of(observer: Subject) -> list[Source]:
    """Read an observer's list of sources, those that count most first."""
    axes = view_axes(direction_of(observer), Fisheye(np.zeros(3), np.zeros(3)).up)
    found = [_source(entry, axes) for entry in observer.entry.get("sources") or [] if isinstance(entry, dict)]
    ranked = sorted(found, key=lambda source: -source.glare)
    return [replace(source, number=number) for number, source in enumerate(ranked, start=1)]


def source_rows(sources: Sequence[Source], texts: Texts) -> list[dict[str, str]]:
    """Rows of the table of sources; shares are of the sum of L² ω / p²."""
    total = math.fsum(source.glare for source in sources)
    return [_row(source, total, texts) for source in sources]


def _row(source: Source, total: float, texts: Texts) -> dict[str, str]:
    excluded = [texts.filled("not_counted", reason=source.excluded)] if source.excluded else []
    return {
        "number": str(source.number),
        "name": source.name,
        "luminance": significant(source.luminance) if source.solid_angle else MISSING,
        "solid_angle": significant(source.solid_angle) if source.solid_angle else MISSING,
        "t_over_r": _ratio(source.t_over_r),
        "h_over_r": _ratio(source.h_over_r),
        "position_index": _ratio(source.position_index),
        "visible": MISSING if source.visible_fraction is None else percent(source.visible_fraction),
        "share": percent(source.glare / total) if source.glare else MISSING,
        "remark": "; ".join([*excluded, *source.flags]),
    }


def _ratio(ratio: float | None) -> str:
    return MISSING if ratio is None else significant(ratio)


def _source(entry: Mapping[str, Any], axes: FloatArray) -> Source:
    return Source(
        number=0,
        name=str(entry.get("name", MISSING)),
        luminance=float(entry.get("luminance_cd_m2", entry.get("luminance")) or 0.0),
        solid_angle=float(entry.get("solid_angle_sr", entry.get("solid_angle")) or 0.0),
        direction=_eye_direction(entry, axes),
        t_over_r=entry.get("t_over_r"),
        h_over_r=entry.get("h_over_r"),
        position_index=entry.get("position_index"),
        visible_fraction=entry.get("visible_fraction"),
        excluded=_reason(entry.get("excluded")),
        flags=tuple(str(flag) for flag in entry.get("flags") or ()),
    )


def _eye_direction(entry: Mapping[str, Any], axes: FloatArray) -> FloatArray | None:
    """Direction in the eye's axes: from the scene's axes, else from the ratios, T counted to the right."""
    if entry.get("direction"):
        return np.asarray(axes @ np.asarray(entry["direction"], dtype=np.float64))
    t_over_r, h_over_r = entry.get("t_over_r"), entry.get("h_over_r")
    return None if t_over_r is None or h_over_r is None else np.array([t_over_r, h_over_r, 1.0])


def _reason(excluded: object) -> str:
    return "excluded" if excluded is True else str(excluded or "")
