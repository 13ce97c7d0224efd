"""What ``lelight photometry info`` tells about a luminaire, as a table for programs and as lines for people."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from lelight.photometry.photometry import Photometry
from lelight.photometry.zones import (
    downward_fraction,
    flux_code,
    light_output_ratio,
    luminous_flux,
    spread,
)
from lelight.scene import FloatArray

#: Directions of the luminance table in degrees (EN 12464-1, luminaires at display screens, starts at 65).
LUMINANCE_GAMMA: FloatArray = np.array([65.0, 70.0, 75.0, 80.0, 85.0])
LUMINANCE_C: FloatArray = np.arange(0.0, 360.0, 15.0)


def facts(photometry: Photometry) -> dict[str, Any]:
    """Everything about a luminaire, ready for JSON: SI units, degrees, lm, cd, cd/m²."""
    opening = photometry.opening
    flux = luminous_flux(photometry)
    peak = np.unravel_index(int(photometry.candela.argmax()), photometry.candela.shape)
    return {
        "file": photometry.file,
        "sha256": photometry.sha256,
        "format": photometry.format,
        "name": photometry.name,
        "texts": photometry.texts,
        "symmetry": photometry.symmetry,
        "c_planes": len(photometry.c),
        "gamma_angles": len(photometry.gamma),
        "gamma_range": [float(photometry.gamma[0]), float(photometry.gamma[-1])],
        "absolute": photometry.absolute,
        "flux": flux,
        "declared_flux": photometry.declared_flux,
        "lamp_flux": photometry.lamp_flux or None,
        "light_output_ratio": light_output_ratio(photometry),
        "downward_fraction": downward_fraction(photometry),
        "power": photometry.power,
        "efficacy": flux / photometry.power if photometry.power > 0 else None,
        "lamps": [vars(lamp) for lamp in photometry.lamps],
        "opening": {
            "shape": opening.shape,
            "along_c0": opening.along_c0,
            "along_c90": opening.along_c90,
            "heights": list(opening.heights),
        },
        "body": list(photometry.body),
        "peak": {
            "intensity": float(photometry.candela.max()),
            "c": float(photometry.c[peak[0]]),
            "gamma": float(photometry.gamma[peak[1]]),
        },
        "spread": [vars(spread(photometry, c)) for c in (0.0, 90.0)],
        "flux_code": list(flux_code(photometry)),
        "luminance": {
            "c": LUMINANCE_C.tolist(),
            "gamma": LUMINANCE_GAMMA.tolist(),
            "cd_m2": _luminances(photometry),
        },
    }


def _luminances(photometry: Photometry) -> list[list[float | None]]:
    """Rows by C, columns by γ; None where the opening has no area."""
    table = photometry.luminance(LUMINANCE_C[:, None], LUMINANCE_GAMMA[None])
    return [[float(L) if math.isfinite(L) else None for L in row] for row in table]


def fact_lines(photometry: Photometry) -> Iterator[str]:
    """Lines for people."""
    known = facts(photometry)
    yield f"{known['name']} ({known['format']}, {photometry.file})"
    yield f"SHA-256            {photometry.sha256}"
    low, high = known["gamma_range"]
    grid = f"{known['c_planes']} C x {known['gamma_angles']} γ, γ {low:g} to {high:g}"
    yield f"planes             {grid}, symmetry {photometry.symmetry}"
    yield f"flux               {known['flux']:.1f} lm by integration" + _declared(known)
    yield from _lamp_lines(photometry)
    ratio = known["light_output_ratio"]
    yield "light output ratio " + (f"{ratio:.1%}" if ratio is not None else "absolute photometry: none")
    yield f"downward           {known['downward_fraction']:.1%}"
    yield f"power              {photometry.power:g} W" + (
        f", {known['efficacy']:.0f} lm/W" if known["efficacy"] else ""
    )
    peak = known["peak"]
    yield f"peak               {peak['intensity']:.1f} cd at C {peak['c']:g}, γ {peak['gamma']:g}"
    for plane in known["spread"]:
        title = f"C {plane['c']:.0f} - C {plane['c'] + 180:.0f}"
        yield f"{title:18} beam {_degrees(plane['beam'])}, field {_degrees(plane['field'])}"
    yield f"CIE flux code      {' '.join(map(str, known['flux_code']))}"
    yield f"opening            {_opening(photometry)}"
    yield from _luminance_lines(known["luminance"])


def _declared(known: dict[str, Any]) -> str:
    declared = known["declared_flux"]
    return f", declared {declared:.1f} lm ({known['flux'] / declared - 1:+.2%})" if declared else ""


def _lamp_lines(photometry: Photometry) -> Iterator[str]:
    for number, lamp in enumerate(photometry.lamps):
        flux = "absolute" if photometry.absolute and not lamp.flux else f"{lamp.flux:g} lm"
        words = ", ".join(word for word in (lamp.kind, lamp.colour, lamp.rendering) if word)
        alternative = " (alternative, not used)" if number else ""
        yield f"lamps              {lamp.count} x {words or 'lamp'}: {flux}, {lamp.watts:g} W{alternative}"


def _degrees(angle: float | None) -> str:
    return "none" if angle is None else f"{angle:.1f}°"


def _opening(photometry: Photometry) -> str:
    opening = photometry.opening
    if opening.shape == "point":
        return "none (point)"
    heights = " / ".join(f"{h:g}" for h in opening.heights) if opening.height else "0"
    return f"{opening.shape}, {opening.along_c0:g} m along C0, {opening.along_c90:g} m along C90, sides {heights} m"


def _luminance_lines(table: dict[str, Any]) -> Iterator[str]:
    yield "luminance in cd/m²"
    yield "       C \\ γ" + "".join(f"{gamma:9g}°" for gamma in table["gamma"])
    for c, row in zip(table["c"], table["cd_m2"], strict=True):
        yield f"  {c:9g}°" + "".join(f"{'-' if L is None else format(L, '.0f'):>10}" for L in row)
