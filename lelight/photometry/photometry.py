"""What a photometric file says, in one value whatever the format."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from lelight.photometry.opening import LEAST_AREA, Opening
from lelight.scene import FloatArray

Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True)
class Finding:
    """Something odd about a file: a named rule, how bad it is, the line (None where there is none)."""

    rule: str
    severity: Severity
    text: str
    line: int | None = None


@dataclass(frozen=True)
class LampSet:
    """Lamps that the luminaire may be fitted with.

    Attributes
    ----------
    count : int, number of lamps
    flux : float, lm of all of them together
    watts : float, W including ballast
    """

    count: int
    flux: float
    watts: float
    kind: str = ""
    colour: str = ""
    rendering: str = ""


@dataclass(frozen=True)
class Photometry:
    """A luminous intensity distribution and what belongs to it.

    Directions are CIE's C and γ: γ = 0 straight down, C counted anticlockwise seen from above (from below the
    luminaire, clockwise). C planes of LM-63 are its horizontal angles as they stand.

    Attributes
    ----------
    c : (n_c,) float, degrees, ascending, within one turn; a single plane where the light is the same all round
    gamma : (n_g,) float, degrees, ascending; outside their range no light leaves
    candela : (n_c, n_g) float, cd, every factor of the file applied
    opening : luminous opening
    body : length (along C90), width (along C0) and height of the luminaire in m, 0 where not given
    lamps : sets of lamps; they are alternatives and the first one is in force
    absolute : True where intensities were measured absolutely, without reference to lamps
    declared_flux : float, lm leaving the luminaire as the file states it; None where it does not
    downward_share : float, declared downward flux fraction, None where not declared
    power : float, W
    symmetry : the file's own symmetry code, in words
    texts : header texts by key
    tilt : (n, 2) float, angle in degrees and factor of lamps that depend on tilt; no rows where they do not
    format : name of the format and its edition
    file, sha256 : provenance
    findings : what the reader had to put right
    """

    c: FloatArray
    gamma: FloatArray
    candela: FloatArray
    opening: Opening = field(default_factory=Opening)
    body: tuple[float, float, float] = (0.0, 0.0, 0.0)
    lamps: tuple[LampSet, ...] = ()
    absolute: bool = False
    declared_flux: float | None = None
    downward_share: float | None = None
    power: float = 0.0
    symmetry: str = "none"
    texts: dict[str, str] = field(default_factory=dict)
    tilt: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    format: str = ""
    file: str = ""
    sha256: str = ""
    findings: tuple[Finding, ...] = ()

    @property
    def name(self) -> str:
        """What the file calls the luminaire, else the file's name."""
        return self.texts.get("luminaire") or self.texts.get("number") or self.file

    @property
    def rotational(self) -> bool:
        """True where one plane stands for all."""
        return len(self.c) == 1

    @property
    def lamp_flux(self) -> float:
        """Flux in lm of the lamps in force; 0 where the file gives none."""
        return self.lamps[0].flux if self.lamps else 0.0

    def closed(self) -> tuple[FloatArray, FloatArray]:
        """C angles (n_c + 1,) over a whole turn and candela (n_c + 1, n_g), the first plane repeated."""
        return np.append(self.c, self.c[0] + 360.0), np.concatenate([self.candela, self.candela[:1]])

    def intensity(self, c: ArrayLike, gamma: ArrayLike) -> FloatArray:
        """Luminous intensity in cd, bilinear between the planes; 0 beyond the last γ.

        Parameters
        ----------
        c, gamma : (...) float, degrees
        """
        c, gamma = np.broadcast_arrays(np.asarray(c, dtype=float), np.asarray(gamma, dtype=float))
        angles, table = self.closed()
        turned = (c - angles[0]) % 360.0 + angles[0]
        i, u = _between(angles, turned)
        j, v = _between(self.gamma, gamma)
        low = table[i, j] * (1 - v) + table[i, np.minimum(j + 1, len(self.gamma) - 1)] * v
        high = table[i + 1, j] * (1 - v) + table[i + 1, np.minimum(j + 1, len(self.gamma) - 1)] * v
        inside = (gamma >= self.gamma[0] - 1e-9) & (gamma <= self.gamma[-1] + 1e-9)
        return np.asarray(np.where(inside, low * (1 - u) + high * u, 0.0))

    def luminance(self, c: ArrayLike, gamma: ArrayLike) -> FloatArray:
        """Mean luminance in cd/m², intensity over projected area; NaN where the opening has no area."""
        intensity, area = self.intensity(c, gamma), self.opening.projected_area(c, gamma)
        intensity, area = np.broadcast_arrays(intensity, area)
        return np.asarray(
            np.divide(intensity, area, out=np.full(area.shape, np.nan), where=area > LEAST_AREA)
        )


def _between(
    nodes: FloatArray, at: FloatArray
) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.int64]], FloatArray]:
    """Index of the node below and the share of the one above."""
    if len(nodes) == 1:
        return np.zeros(at.shape, dtype=np.int64), np.zeros(at.shape)
    below = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, len(nodes) - 2)
    return below, np.clip((at - nodes[below]) / (nodes[below + 1] - nodes[below]), 0.0, 1.0)
