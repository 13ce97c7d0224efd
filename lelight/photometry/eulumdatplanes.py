"""Planes of an EULUMDAT file: angles, intensities, and what its symmetry indicator leaves out.

The indicator is the field that writers get wrong most often. Planes that are there are believed before it; planes
that are missing are not made up.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lelight.photometry.photometry import Finding
from lelight.photometry.symmetry import SYMMETRIES, Planes, Symmetry, sector, unfolded
from lelight.photometry.textfile import ANGLE_DECIMALS, Numbers, TextFile
from lelight.scene import FloatArray, IntArray

#: Planes that a file of ``n`` all round gives, by symmetry.
COLUMNS: dict[Symmetry, Callable[[int], int]] = {
    "none": lambda n: n,
    "rotational": lambda n: 1,
    "c0-c180": lambda n: n // 2 + 1,
    "c90-c270": lambda n: n // 2 + 1,
    "both": lambda n: n // 4 + 1,
}


@dataclass(frozen=True)
class Declared:
    """What the header says of the table: counts, distances in degrees (0 where uneven), and its last line."""

    symmetry: Symmetry
    planes: int
    plane_step: float
    angles: int
    angle_step: float
    line: int

    @property
    def indicator(self) -> int:
        """Symmetry as the file codes it."""
        return SYMMETRIES.index(self.symmetry)


def read_planes(
    text: TextFile, declared: Declared, numbers: Numbers, findings: list[Finding]
) -> tuple[FloatArray, Planes]:
    """γ (n_g,) in degrees and the planes of a whole turn in cd/klm, negative ones lifted to zero.

    Raises
    ------
    InputError
        where numbers are missing, or angles run where there are none
    """
    n_g = declared.angles
    c = np.round(np.array(numbers.take_many(declared.planes, "C angles")), ANGLE_DECIMALS)
    gamma = np.array(numbers.take_many(n_g, "angles in a plane"))
    line = numbers.line
    symmetry, columns = _present(text, declared, c, numbers, findings)
    shares = np.array(numbers.take_many(columns * n_g, "intensities")).reshape(columns, n_g)
    findings += numbers.trailing()
    if shares.min() < 0:
        findings.append(
            Finding("negative-candela", "error", f"found {shares.min():g} cd/klm; read as 0", line)
        )
        shares = np.maximum(shares, 0.0)
    c = _angles_or_steps(c, declared.plane_step, "C", 360.0, line, findings)
    gamma = _angles_or_steps(gamma, declared.angle_step, "γ", 180.0, line, findings)
    if gamma.min() < -1e-6 or gamma.max() > 180 + 1e-6 or np.abs(c).max() > 720:
        raise text.error(
            line,
            f"angles run to C {np.abs(c).max():g} and γ {gamma.min():g} to {gamma.max():g}; "
            "expected C 0 to 360, γ 0 to 180",
        )
    gamma, order = _ascending(gamma, line, findings)
    return gamma, _whole_turn(declared, symmetry, c, shares[:, order], findings)


def _present(
    text: TextFile, declared: Declared, c: FloatArray, numbers: Numbers, findings: list[Finding]
) -> tuple[Symmetry, int]:
    """Symmetry of the planes that are there, and their number."""
    columns = min(declared.planes, COLUMNS[declared.symmetry](declared.planes))
    held = numbers.left // declared.angles
    if numbers.left % declared.angles or held == columns:
        return declared.symmetry, columns
    fitting = [symmetry for symmetry in SYMMETRIES if COLUMNS[symmetry](declared.planes) == held]
    if held < columns:
        named = " or ".join(str(SYMMETRIES.index(symmetry)) for symmetry in fitting)
        fits = f", as symmetry indicator {named} has" if named else ""
        raise text.error(
            numbers.stopped_at,
            f"holds {held} plane{'s' * (held != 1)}{fits}; indicator {declared.indicator} of {declared.planes} "
            f"planes needs {columns}; it may be cut off",
        )
    if held == declared.planes and _only_sector(c, declared.symmetry):
        words = f"{held} C planes are counted, those of the sector only; the others mirror them"
        findings.append(Finding("symmetry", "warning", words, numbers.line))
        return declared.symmetry, held
    if held != declared.planes and not fitting:
        return declared.symmetry, columns
    words = f"symmetry indicator {declared.indicator} but {held} planes are there; all are used"
    findings.append(Finding("symmetry", "error", words, numbers.line))
    return "none" if held == declared.planes else fitting[0], held


def _angles_or_steps(
    angles: FloatArray, step: float, what: str, most: float, line: int, findings: list[Finding]
) -> FloatArray:
    """Angles as listed, or by their declared distance where the list says nothing."""
    if len(angles) > 1 and np.all(angles == angles[0]) and 0 < step <= most:
        findings.append(
            Finding(
                "missing-angles",
                "error",
                f"{what} angles are all {angles[0]:g}; counted in steps of {step:g}",
                line,
            )
        )
        return np.asarray(np.minimum(np.arange(len(angles)) * step, most))
    return angles


def _ascending(gamma: FloatArray, line: int, findings: list[Finding]) -> tuple[FloatArray, IntArray]:
    sorted_, first = np.unique(np.round(gamma, ANGLE_DECIMALS), return_index=True)
    if len(sorted_) < len(gamma):
        findings.append(Finding("repeated-angles", "error", "γ angles come twice; the first is used", line))
    if np.any(np.diff(first) < 0):
        findings.append(Finding("unsorted-angles", "error", "γ angles are not ascending; sorted", line))
    return np.clip(sorted_, 0.0, 180.0), np.asarray(first, dtype=np.int64)


def _whole_turn(
    declared: Declared, symmetry: Symmetry, c: FloatArray, shares: FloatArray, findings: list[Finding]
) -> Planes:
    """Give each column its C angle and add the planes that mirror them."""
    if len(shares) == 1:
        return Planes(np.zeros(1), shares)
    if symmetry == "none":
        _say_disorder(c, declared.line, findings)
    own = c if len(shares) == len(c) else _sector_angles(c, symmetry, len(shares))
    if own is None:
        own = np.linspace(*sector(symmetry), len(shares))
        text = f"C angles do not fit symmetry indicator {declared.indicator}; spread evenly"
        findings.append(Finding("c-angles", "error", text, declared.line))
    return unfolded(Planes(own, shares), symmetry)


def _only_sector(c: FloatArray, symmetry: Symmetry) -> bool:
    """Tell whether the listed planes run from one border of the symmetry's sector to the other, no farther."""
    if symmetry in {"none", "rotational"}:
        return False
    first, last = sector(symmetry)
    turned = np.where(c > last + 1e-6, c - 360.0, c) if first < 0 else c
    ends = abs(turned.min() - first) < 1e-6 and abs(turned.max() - last) < 1e-6
    return bool(ends and len(np.unique(np.round(turned, ANGLE_DECIMALS))) == len(c))


def _say_disorder(c: FloatArray, line: int, findings: list[Finding]) -> None:
    if len(np.unique(np.round(c % 360.0, 6))) + (abs(c.max() - 360) < 1e-6) < len(c):
        findings.append(Finding("repeated-angles", "error", "C angles come twice; the first is used", line))
    if np.any(np.diff(c) < 0):
        findings.append(Finding("unsorted-angles", "error", "C angles are not ascending; sorted", line))


def _sector_angles(c: FloatArray, symmetry: Symmetry, count: int) -> FloatArray | None:
    """C angles of the columns: those listed within the sector that the file gives."""
    first, last = sector(symmetry)
    turned = np.where(c > last + 1e-6, c - 360.0, c) if first < 0 else c
    inside = np.sort(turned[(turned >= first - 1e-6) & (turned <= last + 1e-6)])
    return inside if len(inside) == count and len(np.unique(inside)) == count else None
