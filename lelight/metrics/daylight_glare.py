"""Glare ratings of a picture's sources as evalglare 3.05 and 3.06 define them: DGI, CGI, VCP, UGP, veils.

Formulas were read off the program's documentation and source and checked against its output; nothing of its
code is used. Each takes a `View`: sums over the sources and what the eye receives in all.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lelight.scene import FloatArray

#: Degrees; nearer to the line of sight the CIE veil would grow without end.
CLOSEST = 0.1


@dataclass(frozen=True)
class View:
    """What an eye sees, as the ratings need it.

    Attributes
    ----------
    luminance, solid_angle, position : (n,) float; cd/m², sr and position index of each source
    theta : (n,) float, rad off the line of sight
    vertical, direct : float, lx, on the plane across the line of sight: all light, and that of the sources
    background : float, cd/m², the rest of the illuminance over π
    mean : float, cd/m², mean luminance of the whole view
    """

    luminance: FloatArray
    solid_angle: FloatArray
    position: FloatArray
    theta: FloatArray
    vertical: float
    direct: float
    background: float
    mean: float

    @cached_property
    def glare_sum(self) -> float:
        """``sum L² ω / P²``."""
        return math.fsum(self.luminance**2 * self.solid_angle / self.position**2)

    @cached_property
    def linear_sum(self) -> float:
        """``sum L ω / P²``."""
        return math.fsum(self.luminance * self.solid_angle / self.position**2)

    def with_background(self, share: float) -> View:
        """Scale what is not of the sources, to carry the error of the indirect light over."""
        rest = math.pi * self.background * share
        sources = math.fsum(self.luminance * self.solid_angle)
        mean = (sources + (2 * math.pi * self.mean - sources) * share) / (2 * math.pi)
        return replace(
            self, background=self.background * share, vertical=self.direct + rest, mean=max(mean, 0.0)
        )


def ugr(view: View) -> float:
    """``8 log10(0.25 / L_b sum L² ω / P²)``, CIE 117:1995."""
    return _log(8, 0.25 * view.glare_sum, view.background)


def dgp(view: View) -> float:
    """Daylight glare probability, `lelight.metrics.picture.daylight_glare_probability`."""
    from lelight.metrics.picture import daylight_glare_probability

    return daylight_glare_probability(view.glare_sum, view.vertical)


def dgi(view: View) -> float:
    """``10 log10 sum 0.478 L^1.6 (ω/P²)^0.8 / (L_b + 0.07 ω^0.5 L)`` (Hopkinson 1972, as evalglare has it)."""
    return _dgi(view, view.background)


def dgi_modified(view: View) -> float:
    """DGI with ``(E_v / π)^0.85`` for the background (Fisekis et al. 2003, as evalglare has it)."""
    return _dgi(view, (view.vertical / math.pi) ** 0.85)


def _dgi(view: View, background: float) -> float:
    omega = view.solid_angle
    shaped = 0.478 * view.luminance**1.6 * (omega / view.position**2) ** 0.8
    return _log(10, math.fsum(shaped / (background + 0.07 * np.sqrt(omega) * view.luminance)), 1.0)


def cgi(view: View) -> float:
    """``8 log10(2 (1 + E_d/500) / E_v sum L² ω / P²)`` (CIE glare index, Einhorn 1979)."""
    return _log(8, 2 * (1 + view.direct / 500) * view.glare_sum, view.vertical)


def vcp(view: View) -> float:
    """Visual comfort probability in % (IESNA), from DGR = (sum M)^(n^-0.0914); 100 without a source."""
    count = len(view.luminance)
    if count == 0 or view.mean <= 0:
        return 100.0 if count == 0 else math.nan
    omega = view.solid_angle
    shape = 20.4 * omega + 1.52 * omega**0.2 - 0.075
    total = math.fsum(0.5 * view.luminance * shape / (view.position * view.mean**0.44))
    if total <= 0:
        return 100.0
    rating = total ** (count**-0.0914)
    if rating > 750:
        return 0.0
    return 100.0 if rating < 20 else 50 * math.erf((6.374 - 1.3227 * math.log(rating)) / math.sqrt(2)) + 50


def ugp(view: View) -> float:
    """Unified glare probability ``0.26 log10(0.25 / L_b sum L² ω / P²)`` (Hirning et al. 2014)."""
    return _log(0.26, 0.25 * view.glare_sum, view.background)


def ugp2(view: View) -> float:
    """``[1 + 2/7 (sum L² ω / P² / L_b)^-0.2]^-10`` (Hirning et al. 2017)."""
    if not (view.glare_sum > 0 and view.background > 0):
        return math.nan
    return float((1 + 2 / 7 * (view.glare_sum / view.background) ** -0.2) ** -10)


def ugr_experimental(view: View) -> float:
    """``8 log10(E_v/π) + 8 log10(sum L ω / P² / L_b)`` (UGR_exp of evalglare)."""
    return _log(8, view.vertical / math.pi * view.linear_sum, view.background)


def veiling_poynter(view: View) -> float:
    """Veiling luminance (cd/m²) ``5 sum L ω cos θ / θ``, θ in degrees (Poynter, as evalglare has it)."""
    degrees = np.maximum(np.degrees(view.theta), CLOSEST)
    return 5 * math.fsum(view.luminance * view.solid_angle * np.cos(view.theta) / degrees)


def veiling_cie(view: View) -> float:
    """Veiling luminance (cd/m²) ``10 sum E_i / θ²``, θ in degrees and at least 0.1 (CIE 146:2002)."""
    degrees = np.maximum(np.degrees(view.theta), CLOSEST)
    illuminance = view.luminance * view.solid_angle * np.cos(view.theta)
    return 10 * math.fsum(illuminance / degrees**2)


def pgsv_contrast(window: float, background: float, solid_angle: float) -> float:
    """PGSV by contrast of a window (cd/m², cd/m², sr): Tokura & Iwata, as evalglare has it."""
    lg = math.log10
    omega = lg(solid_angle)
    return 3.2 * lg(window) - 0.64 * omega + (0.79 * omega - 0.61) * lg(background) - 8.2


def pgsv_saturation(vertical: float) -> float:
    """PGSV by saturation ``3.3 - 3.87 / (1 + (E_v/π/1250)^1.7)``."""
    return float(3.3 - 3.87 / (1 + (vertical / math.pi / 1250) ** 1.7))


def _log(factor: float, numerator: float, denominator: float) -> float:
    if not (numerator > 0 and denominator > 0):
        return math.nan
    return factor * math.log10(numerator / denominator)


#: Ratings beside UGR and DGP: key, unit, function and source.
RATINGS: tuple[tuple[str, str, Callable[[View], float], str], ...] = (
    ("dgi", "1", dgi, "Hopkinson 1972"),
    ("dgi_modified", "1", dgi_modified, "Fisekis et al. 2003"),
    ("cgi", "1", cgi, "CIE glare index, Einhorn 1979"),
    ("vcp", "%", vcp, "IESNA visual comfort probability"),
    ("ugp", "1", ugp, "Hirning et al. 2014"),
    ("ugp2", "1", ugp2, "Hirning et al. 2017"),
    ("ugr_experimental", "1", ugr_experimental, "UGR_exp of evalglare"),
    ("veiling_luminance", "cd/m²", veiling_poynter, "Poynter, as evalglare has it"),
    ("veiling_luminance_cie", "cd/m²", veiling_cie, "CIE 146:2002"),
)
