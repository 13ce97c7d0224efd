"""What is odd about a photometric file: named rules, each with a severity.

Rules of the readers (line known): ``unsorted-angles``, ``repeated-angles``, ``missing-angles``, ``c-angles``,
``open-planes``, ``negative-candela``, ``negative-size``, ``symmetry``, ``unit``, ``unit-feet``, ``no-lamps``,
``no-flux``, ``lamp-sets``, ``tilt``, ``trailing-data`` and others. The rules here look at the value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from lelight.photometry.photometry import Finding, Photometry, Severity
from lelight.photometry.symmetry import SYMMETRIES, Planes, symmetry_of
from lelight.photometry.zones import downward_fraction, luminous_flux

#: Largest difference of declared and integrated flux, as a share.
FLUX_TOLERANCE = 0.05
#: Spread of the intensities at nadir, one direction, as a share of their mean.
NADIR_ERROR, NADIR_WARNING = 0.02, 0.002
#: Uplight below this share of the flux is more often a rounding than a luminaire's property.
STRAY, FALSE_UPLIGHT = 1e-5, 0.005
#: Difference of declared and integrated downward share.
DOWNWARD_TOLERANCE = 0.02
#: An opening this many times longer than wide has a direction.
ELONGATED = 1.5
#: Sizes in m between which luminaires lie.
SMALLEST, LARGEST_SIZE = 0.002, 10.0
#: Intensity over flux in cd/lm of a beam of one degree; luminance in cd/m² and efficacy in lm/W that no lamp has.
PEAKED, DAZZLING, EFFICIENT = 4000.0, 1e9, 300.0
#: Steps in degrees beyond which detail is lost.
COARSE_GAMMA, COARSE_C = 10.0, 45.0


def findings(photometry: Photometry) -> tuple[Finding, ...]:
    """Everything odd, the reader's findings first, errors before the rest."""
    found = [*photometry.findings, *(finding for rule in RULES for finding in rule(photometry))]
    order = ("error", "warning", "info")
    return tuple(sorted(found, key=lambda finding: order.index(finding.severity)))


def _flux(photometry: Photometry) -> Iterator[Finding]:
    flux = luminous_flux(photometry)
    if not flux > 0:
        yield Finding("dark", "error", "no direction has any intensity")
        return
    declared = photometry.declared_flux
    if declared and abs(flux / declared - 1) > FLUX_TOLERANCE:
        yield Finding(
            "flux",
            "error",
            f"declared {declared:.4g} lm leave the luminaire, integrated {flux:.4g} lm ({flux / declared - 1:+.1%})",
        )
    lamps = photometry.lamp_flux
    if declared is None and not photometry.absolute and lamps > 0 and flux > (1 + FLUX_TOLERANCE) * lamps:
        yield Finding(
            "flux", "error", f"lamps give {lamps:.4g} lm, integrated {flux:.4g} lm leave the luminaire"
        )
    if not photometry.absolute and not lamps > 0:
        yield Finding("no-flux", "warning", "no lamp flux is given; intensities are taken as they stand")


def _nadir(photometry: Photometry) -> Iterator[Finding]:
    if photometry.gamma[0] > 1e-6 or photometry.rotational:
        return
    nadir = photometry.candela[:, 0]
    mean = float(nadir.mean())
    difference = float(np.ptp(nadir)) / mean if mean > 0 else 0.0
    if difference > NADIR_WARNING:
        severity: Severity = "error" if difference > NADIR_ERROR else "warning"
        text = f"intensities at γ = 0, one direction, run from {nadir.min():.4g} to {nadir.max():.4g} cd"
        yield Finding("nadir", severity, text)


def _angles(photometry: Photometry) -> Iterator[Finding]:
    gamma, c = photometry.gamma, photometry.closed()[0]
    if gamma[0] > 1e-6 and abs(gamma[0] - 90.0) > 1e-6:
        yield Finding("missing-angles", "warning", f"γ starts at {gamma[0]:g}; expected 0 or 90")
    if min(abs(gamma[-1] - end) for end in (90.0, 180.0)) > 1e-6:
        yield Finding("missing-angles", "warning", f"γ ends at {gamma[-1]:g}; expected 90 or 180")
    if len(gamma) > 1 and np.diff(gamma).max() > COARSE_GAMMA + 1e-6:
        yield Finding("coarse-angles", "warning", f"a step of {np.diff(gamma).max():g} degrees in γ")
    if not photometry.rotational:
        steps = np.diff(c)
        if steps.max() > COARSE_C + 1e-6:
            yield Finding("coarse-angles", "warning", f"a step of {steps.max():g} degrees in C")
        usual = float(np.median(steps))
        if steps.max() > 1.9 * usual and np.mean(np.isclose(steps, usual)) > 0.8:
            at = c[int(steps.argmax())]
            yield Finding(
                "missing-angles",
                "warning",
                f"planes are missing after C {at:g} (step {steps.max():g}, else {usual:g})",
            )


def _sizes(photometry: Photometry) -> Iterator[Finding]:
    opening = photometry.opening
    if opening.size == 0:
        yield Finding("zero-size", "warning", "the luminous opening has no size: no luminance, no UGR")
        return
    flat = [opening.along_c0 > 0, opening.along_c90 > 0, opening.height > 0]
    if sum(flat) == 1 or (opening.shape == "rectangle" and flat[0] != flat[1] and not flat[2]):
        yield Finding(
            "one-sided-size",
            "error",
            f"the luminous opening is {opening.along_c0:g} m along C0 and {opening.along_c90:g} m along C90: no area",
        )
    if not SMALLEST <= opening.size <= LARGEST_SIZE:
        yield Finding("size", "warning", f"the luminous opening is {opening.size:g} m long; check the unit")


def _across(photometry: Photometry) -> Iterator[Finding]:
    """C0 against the opening: both formats have a plane along the length, LM-63 the zero plane, EULUMDAT C90."""
    a, b = photometry.opening.along_c0, photometry.opening.along_c90
    if min(a, b) <= 0:
        return
    if photometry.format == "EULUMDAT":
        if a > ELONGATED * b:
            yield Finding(
                "c0-opening",
                "warning",
                f"the width of the luminous area ({a:g} m) exceeds its length ({b:g} m): in EULUMDAT the length "
                "lies along C90; length and width may be exchanged",
            )
        length, width, _ = photometry.body
        if min(length, width) > 0:
            if (length > ELONGATED * width and a > b) or (width > ELONGATED * length and b > a):
                yield Finding(
                    "c0-opening", "error", "luminaire and luminous area are long in different directions"
                )
            if b > 1.01 * length or a > 1.01 * width:
                yield Finding(
                    "opening-body",
                    "warning",
                    f"the luminous area ({b:g} x {a:g} m) exceeds the luminaire ({length:g} x {width:g} m)",
                )
    elif b > ELONGATED * a:
        yield Finding(
            "c0-opening",
            "info",
            f"the width ({b:g} m) exceeds the length ({a:g} m): in LM-63 the length lies along the zero plane; "
            "they may be exchanged",
        )


def _uplight(photometry: Photometry) -> Iterator[Finding]:
    if not luminous_flux(photometry) > 0:
        return
    up = 1.0 - downward_fraction(photometry)
    declared = photometry.downward_share
    if declared is not None and abs(1.0 - up - declared) > DOWNWARD_TOLERANCE:
        severity: Severity = "warning" if up else "info"
        yield Finding(
            "uplight", severity, f"declared {declared:.1%} of the flux go down, integrated {1 - up:.1%}"
        )
    if STRAY < up < FALSE_UPLIGHT:
        yield Finding(
            "false-uplight",
            "warning",
            f"{100 * up:.2g} % of the flux go up; usually stray light or interpolation at 90°",
        )


def _absurd(photometry: Photometry) -> Iterator[Finding]:
    flux, peak = luminous_flux(photometry), float(photometry.candela.max())
    if not flux > 0:
        return
    if peak > PEAKED * flux:
        yield Finding("absurd-candela", "error", f"{peak:.4g} cd from {flux:.4g} lm: a beam below a degree")
    area = float(photometry.opening.projected_area(0.0, 0.0))
    if area > 0 and peak / area > DAZZLING:
        yield Finding("absurd-candela", "warning", f"{peak:.4g} cd from {area:.3g} m²: brighter than the sun")
    if photometry.power > 0 and flux > EFFICIENT * photometry.power:
        yield Finding("efficacy", "warning", f"{flux / photometry.power:.0f} lm/W; check power and flux")
    if photometry.power == 0:
        yield Finding("power", "info", "no power is given")


def _symmetry(photometry: Photometry) -> Iterator[Finding]:
    kind = photometry.texts.get("type")
    if photometry.format == "EULUMDAT" and kind == "1" and photometry.symmetry != "rotational":
        yield Finding(
            "symmetry",
            "warning",
            f"type 1 (symmetry about the axis), but symmetry indicator {photometry.symmetry}",
        )
    found = symmetry_of(Planes(photometry.c, photometry.candela))
    if photometry.symmetry in SYMMETRIES and found not in {photometry.symmetry, "none"}:
        yield Finding("symmetry", "info", f"declared {photometry.symmetry}, the intensities have {found}")


#: Rules in the order in which a reader of the list wants them.
RULES: tuple[Callable[[Photometry], Iterator[Finding]], ...] = (
    _flux, _nadir, _angles, _sizes, _across, _uplight, _absurd, _symmetry,
)  # fmt: skip
