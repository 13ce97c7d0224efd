"""Glare rating of an outdoor scene at an eye, CIE 112, with the error of the ground's illuminance."""

from __future__ import annotations

import numpy as np

from lelight.metrics.cie112 import environment_veil, glare_rating, looks_down, source_veil
from lelight.metrics.figure import Figure, measured
from lelight.scene import FloatArray, Observer, Outdoor

_CLAUSE = "CIE 112:1994 (constants from memory)"


def outdoor_figures(
    observer: Observer,
    illuminance: FloatArray,
    directions: FloatArray,
    ground: FloatArray,
    outdoor: Outdoor,
) -> dict[str, Figure]:
    """Rate glare outdoors.

    Parameters
    ----------
    illuminance : (n,) float, lx, that each source gives across the line of sight
    directions : (n, 3) float, unit, from the eye to the sources
    ground : (R, k) float, lx, illuminance of the ground by batch
    """
    method = f"27 + 24 log10(Lvl / Lve^0.9), ground {outdoor.plane!r} of reflectance {outdoor.reflectance:g}"
    if not looks_down(observer.direction):
        note = "not defined: the line of sight must fall below the horizon"
        return {"gr": Figure(None, "1", None, method, clause=_CLAUSE, note=note)}
    cosine = np.clip(directions @ observer.direction, -1, 1) if len(directions) else np.zeros(0)
    veil = source_veil(illuminance, np.degrees(np.arccos(cosine)))
    figure = measured(
        lambda mean: glare_rating(veil, environment_veil(float(mean), outdoor.reflectance)),
        ground.mean(axis=1),
        unit="1",
        method=method,
        clause=_CLAUSE,
        undefined="not defined: no source veils the view, or the ground is dark",
    )
    return {"gr": figure, "source_veil": Figure(veil, "cd/m²", None, "10 sum E / θ²", clause=_CLAUSE)}
