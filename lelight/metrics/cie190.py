"""Tabular unified glare rating of a luminaire in standard rooms, CIE 190:2010 on the rule of CIE 117:1995.

Luminaires hang in a regular grid 2 m above the eye of an observer at the middle of a wall who looks
straight across the room. The table serves to compare luminaires; it is not the rating of a real room.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lelight.metrics.cie190_tables import GEOMETRIC, REFLECTANCES, ROOMS, TRANSFER
from lelight.metrics.position import guth_table
from lelight.photometry.opening import LEAST_AREA
from lelight.photometry.photometry import Photometry
from lelight.photometry.zones import luminous_flux, zonal_flux
from lelight.scene import FloatArray

#: Height of the luminaires over the eye, m.
HEIGHT = 2.0
#: Largest angle from nadir at which a luminaire is rated, degrees.
STEEPEST = 85.0
#: Middles of the zones in degrees, and how many of them each cumulative flux takes; CIE 190, zonal fluxes.
ZONES: FloatArray = np.arange(5.0, 180.0, 10.0)
#: Spacings in units of H that tables are made for.
SPACINGS = (0.25, 1.0)
#: Names of the two directions of view.
CROSSWISE, ENDWISE = "crosswise", "endwise"


@dataclass(frozen=True)
class UgrTable:
    """Ratings (19, 5) by room and reflectances, seen across and along the lamp axis; NaN where none counts.

    Attributes
    ----------
    spacing : float, of the luminaires in units of H
    flux : float, lm of one luminaire's lamps, for which the ratings hold
    """

    crosswise: FloatArray
    endwise: FloatArray
    spacing: float
    flux: float

    def to_json(self) -> dict[str, Any]:
        """Plain lists, NaN as None."""
        return {
            "rooms": [f"{x:g}H x {y:g}H" for x, y in ROOMS],
            "reflectances": list(REFLECTANCES),
            "crosswise": _plain(self.crosswise),
            "endwise": _plain(self.endwise),
            "spacing": self.spacing,
            "flux": self.flux,
        }


def _plain(table: FloatArray) -> list[list[float | None]]:
    return [[round(float(u), 3) if math.isfinite(u) else None for u in row] for row in table]


def ugr_table(photometry: Photometry, *, spacing: float = 0.25) -> UgrTable:
    """Rate a luminaire in all standard rooms.

    Parameters
    ----------
    spacing : float, distance of neighbouring luminaires in units of H

    Raises
    ------
    ValueError
        where the luminaire has no luminous opening or gives no light
    """
    if not luminous_flux(photometry) > 0:
        raise ValueError("it gives no light")
    if photometry.opening.size == 0:
        raise ValueError("it has no luminous opening (all sizes are 0), and so no luminance")
    background = background_luminances(photometry, spacing)
    tables = {}
    for direction in (CROSSWISE, ENDWISE):
        sums = np.array([glare_sum(photometry, room, spacing, direction) for room in ROOMS])
        with np.errstate(divide="ignore", invalid="ignore"):
            tables[direction] = np.where(
                sums[:, None] > 0, 8.0 * np.log10(0.25 * sums[:, None] / background), np.nan
            )
    flux = photometry.lamp_flux or luminous_flux(photometry)
    return UgrTable(tables[CROSSWISE], tables[ENDWISE], spacing, flux)


def glare_sum(photometry: Photometry, room: FloatArray, spacing: float, direction: str) -> float:
    """Sum of ``L² ω / p² = I² / (A_p r² p²)`` over the luminaires that an observer in a room sees.

    Luminaires beyond T/R = 3, γ = 85° or the table of position indices do not count.
    """
    step = spacing * HEIGHT
    across = (np.arange(round(room[0] / spacing)) + 0.5) * step - 0.5 * room[0] * HEIGHT
    ahead = (np.arange(round(room[1] / spacing)) + 0.5) * step
    t, r = (grid.ravel() for grid in np.meshgrid(across, ahead))
    index = guth_table(np.stack([r, t, np.full_like(r, HEIGHT)], axis=-1))
    gamma = np.degrees(np.arctan2(np.hypot(r, t), HEIGHT))
    counted = np.isfinite(index) & (gamma <= STEEPEST) & (np.abs(t) <= 3.0 * r * (1 + 1e-9))
    if not counted.any():
        return 0.0
    t, r, index, gamma = t[counted], r[counted], index[counted], gamma[counted]
    aside = np.degrees(np.arctan2(t, r))
    c = aside if direction == CROSSWISE else 90.0 - aside
    area = photometry.opening.projected_area(c, gamma)
    square = t**2 + r**2 + HEIGHT**2
    seen = area > LEAST_AREA
    terms = photometry.intensity(c, gamma)[seen] ** 2 / (area * square * index**2)[seen]
    return float(terms.sum())


def background_luminances(photometry: Photometry, spacing: float) -> FloatArray:
    """Background luminance (19, 5) in cd/m²: indirect illuminance of the walls over π (CIE 190)."""
    number = ROOMS.prod(axis=1) / spacing**2
    walls = 2.0 * HEIGHT * ROOMS.sum(axis=1) * HEIGHT
    floor, wall, ceiling = distribution_factors(photometry)
    to_floor, to_wall, to_ceiling = np.moveaxis(TRANSFER, -1, 0)
    factor = floor * to_floor + wall * to_wall + ceiling * to_ceiling
    return np.asarray((1000.0 * number / walls * factor / math.pi).T)


def distribution_factors(photometry: Photometry) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shares F_DF, F_DW (19,) and F_DC of 1000 lm that go to floor, walls and ceiling; see `zone_sums`."""
    sums, down, up = zone_sums(photometry)
    floor = GEOMETRIC @ sums / 1000.0
    return floor, down / 1000.0 - floor, np.asarray(up / 1000.0)


def zone_sums(photometry: Photometry) -> tuple[FloatArray, float, float]:
    """Cumulative zonal fluxes Φ₁ to Φ₄ of CIE 190, and the flux down and up, in lm.

    They are brought to the flux that the exact integral gives, so that coarse zones lose nothing.
    """
    zones = zonal_flux(photometry, middles=ZONES)
    zones *= luminous_flux(photometry) / zones.sum() if zones.sum() > 0 else 0.0
    cumulative = np.cumsum(zones)
    first = cumulative[3] + 0.130 * zones[4]
    third = cumulative[6] + 0.547 * zones[7]
    sums = np.array([first, cumulative[5], third, cumulative[8]])
    return sums, float(cumulative[8]), float(cumulative[-1] - cumulative[8])
