"""Figures of the room as a whole, from the light on its surfaces."""

from __future__ import annotations

import numpy as np

from lelight.metrics.figure import Figure, measured, ratio
from lelight.scene import BoolArray, FloatArray


def room_figures(
    areas: FloatArray,
    illuminance: FloatArray,
    exitance: FloatArray,
    hidden: BoolArray,
    replicates: FloatArray | None = None,
) -> dict[str, Figure]:
    """Average illuminance and reflected exitance over the surfaces that light can reach.

    The mean room surface exitance is the flux that the surfaces reflect over their area (Cuttle 2010,
    Lighting Research & Technology 42; from memory, not verified against the paper's text).

    Parameters
    ----------
    areas : (n,) float, m², of the nodes
    illuminance : (n,) float, lx, luminance-weighted
    exitance : (n,) float, lm/m², luminance-weighted, reflected light only
    hidden : (n,) bool; these nodes do not count
    replicates : (R, n) float, lx: illuminance by each independent batch; without them no figure has an error
    """
    seen = np.flatnonzero(~hidden & (areas > 0))
    batches = illuminance[None] if replicates is None else replicates
    # A surface reflects in proportion to what it receives, so the batches of one are those of the other.
    reflected = np.divide(exitance, illuminance, out=np.zeros_like(exitance), where=illuminance > 0)
    return {
        "mean_surface_illuminance": _mean(areas[seen], batches[:, seen], unit="lx", method="mean by area"),
        "mean_room_surface_exitance": _mean(
            areas[seen], (batches * reflected)[:, seen], unit="lm/m²", method="reflected flux over area"
        ),
    }


def _mean(areas: FloatArray, batches: FloatArray, *, unit: str, method: str) -> Figure:
    return measured(
        lambda light: ratio(float(areas @ light), float(areas.sum())),
        batches,
        unit=unit,
        method=method,
        undefined="not defined: no surface is seen by light",
    )
