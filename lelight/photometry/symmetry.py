"""Planes that a file leaves out because they mirror others, and which ones can be left out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lelight.scene import FloatArray

#: Angles closer than this in degrees are the same plane.
SAME = 1e-6
#: Intensities that differ by less than this share of the largest are the same.
SAME_INTENSITY = 1e-9

Symmetry = Literal["none", "rotational", "c0-c180", "c90-c270", "both"]
#: Names in the order of EULUMDAT's symmetry indicator, 0 to 4.
SYMMETRIES: tuple[Symmetry, ...] = ("none", "rotational", "c0-c180", "c90-c270", "both")


@dataclass(frozen=True)
class Planes:
    """Half-planes ``c`` (n_c,) in degrees with what each holds, ``candela`` (n_c, n_g)."""

    c: FloatArray
    candela: FloatArray


def mirrored(planes: Planes, axis: float) -> Planes:
    """Add the mirror images of planes at the vertical plane through C = ``axis``."""
    c = np.concatenate([planes.c, 2.0 * axis - planes.c])
    return in_order(Planes(c, np.concatenate([planes.candela, planes.candela])))


def in_order(planes: Planes) -> Planes:
    """Sort planes into one turn from 0 and drop those that come twice, keeping the first named."""
    c = planes.c % 360.0
    c = np.where(360.0 - c < SAME, 0.0, c)
    order = np.argsort(c, kind="stable")
    c, candela = c[order], planes.candela[order]
    kept = np.concatenate([[True], np.diff(c) > SAME])
    return Planes(c[kept], candela[kept])


def unfolded(planes: Planes, symmetry: Symmetry) -> Planes:
    """Complete planes of which a file gives the part that its symmetry needs."""
    if symmetry == "rotational":
        return Planes(np.zeros(1), planes.candela[:1])
    if symmetry in {"c0-c180", "both"}:
        planes = mirrored(planes, 0.0)
    if symmetry in {"c90-c270", "both"}:
        planes = mirrored(planes, 90.0)
    planes = in_order(planes)
    return planes if len(planes.c) > 1 else Planes(np.zeros(1), planes.candela)


def symmetry_of(planes: Planes) -> Symmetry:
    """Find the most that planes of a whole turn have in common."""
    if len(planes.c) == 1:
        return "rotational"
    tolerance = SAME_INTENSITY * float(np.abs(planes.candela).max(initial=0.0))
    if np.all(np.abs(planes.candela - planes.candela[:1]) <= tolerance):
        return "rotational"
    across, along = _mirrors(planes, 0.0, tolerance), _mirrors(planes, 90.0, tolerance)
    if across and along:
        return "both"
    return "c0-c180" if across else ("c90-c270" if along else "none")


def _mirrors(planes: Planes, axis: float, tolerance: float) -> bool:
    images = in_order(Planes(2.0 * axis - planes.c, planes.candela))
    alike = np.all(np.abs(images.c - planes.c) < 1e-4)
    return bool(alike and np.all(np.abs(images.candela - planes.candela) <= tolerance))


def sector(symmetry: Symmetry) -> tuple[float, float]:
    """First and last plane in degrees that a file with this symmetry gives; -90 stands for 270."""
    return {
        "none": (0.0, 360.0),
        "rotational": (0.0, 0.0),
        "c0-c180": (0.0, 180.0),
        "c90-c270": (-90.0, 90.0),
        "both": (0.0, 90.0),
    }[symmetry]
