"""Polar diagram of a luminous intensity distribution."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from lelight.errors import OutputError
from lelight.photometry.photometry import Photometry
from lelight.writing.files import whole

#: Planes drawn, with the opposite one to the left, and the style of each.
DRAWN = ((0.0, "C0 - C180", "-"), (90.0, "C90 - C270", "--"))
FORMATS = (".png", ".svg", ".pdf")


def write_polar_diagram(path: Path, photometry: Photometry) -> None:
    """Draw two planes through the axis, nadir down, in cd; the ending of ``path`` names the format.

    Raises
    ------
    OutputError
        where the ending names none
    """
    if path.suffix.lower() not in FORMATS:
        raise OutputError(f'{path}: found the ending "{path.suffix}"; allowed are {", ".join(FORMATS)}')
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 5), layout="constrained")
    axes: Any = figure.add_subplot(projection="polar")
    axes.set_theta_zero_location("S")
    gamma = np.linspace(0.0, 180.0, 361)
    for c, label, style in DRAWN:
        angle = np.concatenate([-gamma[::-1], gamma])
        light = np.concatenate([photometry.intensity(c + 180.0, gamma)[::-1], photometry.intensity(c, gamma)])
        axes.plot(np.radians(angle), light, style, label=label)
    axes.set_rlabel_position(135)
    axes.set_xticks(np.radians(np.arange(-150, 181, 30)))
    axes.set_xticklabels([f"{abs(a):g}°" for a in np.arange(-150, 181, 30)])
    axes.set_title(f"{_plain(photometry.name)}\nluminous intensity, cd", fontsize=10)
    axes.legend(loc="upper right", fontsize=8)
    with whole(path) as part:
        figure.savefig(part, format=path.suffix.lower()[1:], dpi=150)


def _plain(name: str) -> str:
    """Name that the drawing library does not take for a formula, cut to fit."""
    return name[:60].replace("$", r"\$")
