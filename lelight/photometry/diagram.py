"""Polar diagram of a luminous intensity distribution: nadir down, C0 to the right, C180 to the left."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lelight.errors import OutputError
from lelight.photometry.photometry import Photometry
from lelight.scene import FloatArray
from lelight.writing.files import whole

#: Planes drawn, each with the opposite one to its left.
DRAWN = (0.0, 90.0)
#: Line and colour of each; told apart in grey print too.
LINES = ({"linestyle": "-", "color": "#12436d"}, {"linestyle": "--", "color": "#c05a00"})
FORMATS = (".png", ".svg", ".pdf")
#: Degrees from nadir: of the curves, to the left and to the right, and of the rays of the grid.
ANGLES: FloatArray = np.linspace(-180.0, 180.0, 361)
RAYS: FloatArray = np.arange(0.0, 360.0, 30.0)


def polar_curves(photometry: Photometry) -> dict[str, FloatArray]:
    """Intensities (361,) in cd at `ANGLES` by the name of the pair of planes."""
    gamma = np.abs(ANGLES)
    return {
        f"C{c:.0f} – C{c + 180:.0f}": np.where(
            ANGLES < 0, photometry.intensity(c + 180.0, gamma), photometry.intensity(c, gamma)
        )
        for c in DRAWN
    }


def paint_polar(axes: Any, curves: Mapping[str, FloatArray], *, angles: FloatArray = ANGLES) -> None:
    """Fill polar axes with curves in cd against degrees from nadir, positive to the right."""
    axes.set_theta_zero_location("S")
    for (label, candela), line in zip(curves.items(), LINES, strict=False):
        axes.plot(np.radians(angles), candela, label=label, **line)
    axes.set(xlim=(0.0, 2.0 * np.pi), ylim=(0.0, None))
    axes.set_thetagrids(RAYS, [f"{min(ray, 360.0 - ray):g}°" for ray in RAYS])
    # Between two rays, on the side where the least light goes.
    axes.set_rlabel_position(165 if _mostly_down(angles, curves) else 15)


def _mostly_down(angles: FloatArray, curves: Mapping[str, FloatArray]) -> bool:
    down = np.abs(angles) <= 90.0
    return sum(float(candela[down].sum() - candela[~down].sum()) for candela in curves.values()) >= 0


def write_polar_diagram(path: Path, photometry: Photometry) -> None:
    """Draw two planes through the axis in cd; the ending of ``path`` names the format.

    Raises
    ------
    OutputError
        where the ending names none
    """
    if path.suffix.lower() not in FORMATS:
        raise OutputError(f'{path}: found the ending "{path.suffix}"; allowed are {", ".join(FORMATS)}')
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 5.4), layout="constrained")
    axes = figure.add_subplot(projection="polar")
    paint_polar(axes, polar_curves(photometry))
    axes.set_title(f"{_plain(photometry.name)}\nluminous intensity in cd", fontsize=10)
    figure.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    with whole(path) as part:
        figure.savefig(part, format=path.suffix.lower()[1:], dpi=150)


def _plain(name: str) -> str:
    """Name that the drawing library does not take for a formula, cut to fit."""
    return name[:60].replace("$", r"\$")
