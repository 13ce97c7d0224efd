"""Unified glare rating from known emitters, CIE 117:1995.

``UGR = 8 log10(0.25 / L_b · sum L² ω / p²)``: luminance L, solid angle ω and position index p of each
luminous opening, background luminance ``L_b = E_indirect / π``. The size limits (solid angle 3·10⁻⁴ to
10⁻¹ sr, CIE 117; luminous area 0.005 to 1.5 m², CIE 147:2002) are not verified against the reports' text:
they are flagged, not applied.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lelight.metrics.opening import Cells, EmitterPatch, cells
from lelight.metrics.position import guth, inside_table, sight_coordinates, sight_frame, table_ratios
from lelight.scene import BoolArray, FloatArray, Observer, PointLuminaire

__all__ = ["EmitterPatch", "GlareSource", "glare_sources", "glare_sum", "point_source", "ugr", "ugr_of_sum"]

#: ``visible(origins (m, 3), targets (m, 3)) -> (m,) bool``; True where nothing stands between, ends excluded.
Visible = Callable[[FloatArray, FloatArray], BoolArray]
#: ``index(coordinates (..., 3)) -> (...)``, see `lelight.metrics.position`.
PositionIndex = Callable[[FloatArray], FloatArray]

SOLID_ANGLE_RANGE = (3e-4, 1e-1)
AREA_RANGE = (0.005, 1.5)
#: Reason given where the table of CIE 117 has no index.
OUTSIDE = "outside the field of the position table (T/R <= 3, H/R <= 1.9)"


@dataclass(frozen=True)
class GlareSource:
    """One luminous opening as an eye sees it; what is hidden does not count.

    Attributes
    ----------
    luminance : float, cd/m², mean of the visible part
    solid_angle : float, sr, of the visible part
    direction : (3,) float, unit, from the eye to the centroid of luminance times solid angle
    visible_fraction : float, visible part of the solid angle that shines into the view hemisphere
    t_over_r, h_over_r : float, table coordinates of the direction; None behind the eye
    position_index : float, None where the source is excluded
    excluded : why the source does not count; empty where it does
    flags : doubts that do not exclude it
    projected_area : float, m², of the visible part across the direction of view
    """

    name: str
    luminance: float
    solid_angle: float
    direction: FloatArray
    visible_fraction: float
    t_over_r: float | None
    h_over_r: float | None
    position_index: float | None
    excluded: str = ""
    flags: tuple[str, ...] = ()
    projected_area: float = 0.0

    @property
    def glare(self) -> float:
        """Its term ``L² ω / p²`` of the rating, 0 where it is excluded."""
        if self.position_index is None or self.excluded:
            return 0.0
        return self.luminance**2 * self.solid_angle / self.position_index**2

    def to_json(self) -> dict[str, Any]:
        """Row of the table of glare sources."""
        return {
            "name": self.name,
            "luminance": self.luminance,
            "solid_angle": self.solid_angle,
            "direction": [float(part) for part in self.direction],
            "visible_fraction": self.visible_fraction,
            "t_over_r": self.t_over_r,
            "h_over_r": self.h_over_r,
            "position_index": self.position_index,
            "excluded": self.excluded,
            "flags": list(self.flags),
            "projected_area": self.projected_area,
        }


def glare_sum(sources: Sequence[GlareSource]) -> float:
    """Add ``L² ω / p²`` (cd²/m⁴ sr) over the sources that count."""
    return math.fsum(source.glare for source in sources)


def ugr_of_sum(total: float, background_luminance: float) -> float:
    """UGR of a glare sum, both positive; NaN where it is not defined."""
    if not (total > 0 and background_luminance > 0):
        return math.nan
    return 8 * math.log10(0.25 * total / background_luminance)


def ugr(sources: Sequence[GlareSource], background_luminance: float) -> float | None:
    """Unified glare rating; None where no source counts.

    Parameters
    ----------
    background_luminance : float, cd/m², positive; indirect illuminance at the eye over π
    """
    if not background_luminance > 0:
        raise ValueError(f"background_luminance must be positive, found {background_luminance}")
    total = glare_sum(sources)
    return ugr_of_sum(total, background_luminance) if total > 0 else None


def glare_sources(
    emitters: Sequence[EmitterPatch],
    observer: Observer,
    visible: Visible,
    *,
    position_index: PositionIndex = guth,
) -> tuple[GlareSource, ...]:
    """See each luminous opening from an eye, the excluded ones with their reason.

    Parameters
    ----------
    position_index : closed form, or `guth_table`; the field is the table's in either case, since the field
        matters more than the form (up to 6 UGR against 0.7)
    """
    return tuple(_seen(emitter, observer, visible, position_index) for emitter in emitters)


def point_source(luminaire: PointLuminaire, observer: Observer) -> GlareSource:
    """Stand in for a luminaire without an opening: it has no solid angle, so no luminance and no rating."""
    direction = _unit(luminaire.position - observer.position)
    return _excluded(luminaire.name, direction, observer, "point source: no luminous opening, no luminance")


def _seen(
    emitter: EmitterPatch, observer: Observer, visible: Visible, position_index: PositionIndex
) -> GlareSource:
    shining = cells(emitter, observer.position, forward=sight_frame(observer)[0])
    towards = _unit(np.mean(emitter.corners, axis=(0, 1)) - observer.position)
    if shining.solid_angle == 0:
        return _excluded(emitter.name, towards, observer, "behind the observer, or seen from its dark side")
    seen = shining[_visible_cells(shining, observer, visible)]
    if seen.solid_angle == 0:
        return _excluded(emitter.name, towards, observer, "not visible")
    return _rated(emitter, observer, seen, seen.solid_angle / shining.solid_angle, position_index)


def _visible_cells(shining: Cells, observer: Observer, visible: Visible) -> BoolArray:
    origins = np.broadcast_to(observer.position, shining.centres.shape)
    return np.asarray(visible(origins, shining.centres), dtype=np.bool_)


def _rated(
    emitter: EmitterPatch,
    observer: Observer,
    seen: Cells,
    visible_fraction: float,
    position_index: PositionIndex,
) -> GlareSource:
    rays = seen.centres - observer.position
    distances = np.linalg.norm(rays, axis=1, keepdims=True)
    direction = _unit(seen.solid_angles @ (rays / distances))
    coordinates = sight_coordinates(direction, observer)
    t_over_r, h_over_r = table_ratios(coordinates)
    excluded = _exclusion(coordinates)
    area = float(seen.solid_angles @ distances[:, 0] ** 2)
    return GlareSource(
        name=emitter.name,
        luminance=float(emitter.luminance),
        solid_angle=seen.solid_angle,
        direction=direction,
        visible_fraction=visible_fraction,
        t_over_r=float(t_over_r),
        h_over_r=float(h_over_r),
        position_index=None if excluded else float(position_index(coordinates)),
        excluded=excluded,
        flags=_flags(seen.solid_angle, area),
        projected_area=area,
    )


def _exclusion(coordinates: FloatArray) -> str:
    if coordinates[2] < 0:
        return "below the line of sight"
    return "" if inside_table(coordinates) else OUTSIDE


def _flags(solid_angle: float, area: float) -> tuple[str, ...]:
    flags = []
    if not SOLID_ANGLE_RANGE[0] <= solid_angle <= SOLID_ANGLE_RANGE[1]:
        flags.append(f"solid angle {solid_angle:.2g} sr outside 3e-4 to 0.1 sr (CIE 117)")
    if area < AREA_RANGE[0]:
        flags.append(f"luminous area {area:.2g} m² below 0.005 m²: rated too severely (CIE 147)")
    if area > AREA_RANGE[1]:
        flags.append(f"luminous area {area:.2g} m² above 1.5 m²: rated too leniently (CIE 147)")
    return tuple(flags)


def _excluded(name: str, direction: FloatArray, observer: Observer, reason: str) -> GlareSource:
    t_over_r, h_over_r = table_ratios(sight_coordinates(direction, observer))
    return GlareSource(
        name=name,
        luminance=0.0,
        solid_angle=0.0,
        direction=direction,
        visible_fraction=0.0,
        t_over_r=float(t_over_r) if np.isfinite(t_over_r) else None,
        h_over_r=float(h_over_r) if np.isfinite(h_over_r) else None,
        position_index=None,
        excluded=reason,
    )


def rated_source(
    name: str,
    luminance: float,
    solid_angle: float,
    direction: FloatArray,
    visible_fraction: float,
    area: float,
    observer: Observer,
    position_index: PositionIndex = guth,
) -> GlareSource:
    """Rate a source whose luminance (cd/m²), solid angle (sr) and projected area (m²) are known."""
    coordinates = sight_coordinates(direction, observer)
    t_over_r, h_over_r = table_ratios(coordinates)
    excluded = _exclusion(coordinates)
    return GlareSource(
        name=name,
        luminance=luminance,
        solid_angle=solid_angle,
        direction=direction,
        visible_fraction=visible_fraction,
        t_over_r=float(t_over_r) if np.isfinite(t_over_r) else None,
        h_over_r=float(h_over_r) if np.isfinite(h_over_r) else None,
        position_index=None if excluded else float(position_index(coordinates)),
        excluded=excluded,
        flags=_flags(solid_angle, area),
        projected_area=area,
    )


def excluded_source(name: str, direction: FloatArray, observer: Observer, reason: str) -> GlareSource:
    """Name a source that does not count, and why."""
    return _excluded(name, direction, observer, reason)


def _unit(vector: FloatArray) -> FloatArray:
    length = np.linalg.norm(vector)
    return np.asarray(vector / length) if length > 0 else np.zeros(3)
