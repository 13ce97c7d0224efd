"""Colour and alpha-opic figures of the light at a plane or an eye, from its spectral bands."""

from __future__ import annotations

import numpy as np

from lelight.metrics.figure import Figure, ratio, stated
from lelight.scene import FloatArray, Spectrum

#: Replicates above this number are put together in as many groups: each figure takes milliseconds.
MOST_GROUPS = 12
NEEDS_SPECTRA = "needs spectra: give spectrum to the emitters and reflectance files to the materials"
_METHOD = "spectrum of the light here: lamps' spectrum times the transfer in bands"
_ALPHA = "CIE S 026:2018"


def without_spectra() -> dict[str, Figure]:
    """Say of the alpha-opic light of a scene without spectra what it lacks."""
    return {"melanopic_edi": Figure(None, "lx", None, _METHOD, clause=_ALPHA, note=NEEDS_SPECTRA)}


def colour_figures(
    bands: FloatArray, lamps: Spectrum, *, target_ra: float | None = None
) -> dict[str, Figure]:
    """Rate the colour of light.

    Parameters
    ----------
    bands : (R, C) float, illuminance in channels by batch
    lamps : mixture of the lamps
    target_ra : the least Ra that is required
    """
    groups = _grouped(bands)
    if not np.mean(groups) > 0:
        return {"melanopic_edi": Figure(None, "lx", None, _METHOD, clause=_ALPHA, note="no light")}
    names = _figures_of(groups.mean(axis=0), lamps)
    table = _jackknifed(groups, lamps)
    found = {}
    for number, (name, unit, clause) in enumerate(_QUANTITIES):
        value, std_error = names[number], table[number]
        found[name] = stated(
            value,
            std_error,
            batches=len(groups),
            unit=unit,
            method=_METHOD,
            clause=clause,
            target=target_ra if name == "ra" else None,
            undefined="not defined for this light",
        )
    return found


_QUANTITIES = (
    ("cct", "K", "Ohno 2013"),
    ("duv", "1", "Ohno 2013"),
    ("ra", "1", "CIE 13.3:1995"),
    ("r9", "1", "CIE 13.3:1995"),
    ("rf", "1", "CIE 224:2017"),
    ("rg", "1", "ANSI/IES TM-30-18"),
    ("melanopic_edi", "lx", _ALPHA),
    ("melanopic_der", "1", _ALPHA),
    ("s_cone_opic_edi", "lx", _ALPHA),
    ("m_cone_opic_edi", "lx", _ALPHA),
    ("l_cone_opic_edi", "lx", _ALPHA),
    ("rhodopic_edi", "lx", _ALPHA),
)


def _figures_of(bands: FloatArray, lamps: Spectrum) -> FloatArray:
    """All quantities (12,) of one set of bands (C,)."""
    from lelight.metrics.cie13_3 import rendering_indices
    from lelight.metrics.cie224 import fidelity_and_gamut
    from lelight.metrics.cies026 import equivalent_daylight_illuminance
    from lelight.metrics.ohno2013 import temperature_and_distance
    from lelight.spectral.bands import spectrum_of_bands

    spectrum = spectrum_of_bands(bands, lamps)
    illuminance = float(bands.mean())
    rendering = rendering_indices(spectrum)
    daylight = [
        equivalent_daylight_illuminance(spectrum, illuminance, receptor=receptor)
        for receptor in ("melanopic", "s_cone_opic", "m_cone_opic", "l_cone_opic", "rhodopic")
    ]
    return np.array(
        [
            *temperature_and_distance(spectrum),
            rendering[0],
            rendering[9],
            *fidelity_and_gamut(spectrum),
            daylight[0],
            ratio(daylight[0], illuminance),
            *daylight[1:],
        ]
    )


def _jackknifed(groups: FloatArray, lamps: Spectrum) -> list[float | None]:
    """Find the standard error of each quantity: all of them are found at once for each group left out."""
    count = len(groups)
    if count < 2:
        return [None] * len(_QUANTITIES)
    total = groups.sum(axis=0)
    parts = np.array([_figures_of((total - group) / (count - 1), lamps) for group in groups])
    spread = np.sqrt((count - 1) / count * np.sum((parts - parts.mean(axis=0)) ** 2, axis=0))
    return [float(each) if np.isfinite(each) else None for each in spread]


def _grouped(bands: FloatArray) -> FloatArray:
    """Means (G, C) of at most twelve groups of replicates, of equal size; a remainder joins the last."""
    if len(bands) <= MOST_GROUPS:
        return bands
    size = len(bands) // MOST_GROUPS
    kept = size * MOST_GROUPS
    groups = bands[:kept].reshape(MOST_GROUPS, size, -1).mean(axis=1)
    # Shift all groups so that their mean is that of all batches.
    return np.asarray(groups + (bands.mean(axis=0) - groups.mean(axis=0)))
