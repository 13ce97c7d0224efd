"""Polar curves: intensities of a luminaire below it, luminances of a surface above it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lelight.photometry.diagram import paint_polar
from lelight.reports.figures.drawing import ACCENT, FAINT, INK, drawing
from lelight.scene import FloatArray

SHEET_SIDE, NODE_WIDTH, NODE_HEIGHT = 72.0, 54.0, 34.0
#: Axes of a half circle in shares of the sheet: the square around the whole circle.
NODE_AXES = (0.1, -0.17, 0.8, 1.27)


def intensity_curves(angles: FloatArray, curves: Mapping[str, FloatArray]) -> bytes:
    """Draw intensities (k,) in cd against degrees from straight down, to the right positive."""

    def paint(figure: Figure) -> None:
        axes: Any = figure.add_axes((0.11, 0.15, 0.78, 0.76), projection="polar")
        paint_polar(axes, curves, angles=angles)
        axes.grid(color=FAINT, linewidth=0.35)
        axes.spines["polar"].set_linewidth(0.4)
        for line in axes.lines:
            line.set_linewidth(1.1)
        axes.tick_params(labelsize=7, pad=0)
        figure.legend(loc="lower center", ncols=2, fontsize=7.5, frameon=False)

    return drawing(SHEET_SIDE, SHEET_SIDE, paint=paint)


def radiance_curves(
    angles: FloatArray, along: FloatArray, across: FloatArray, *, even: float, mark: str
) -> bytes:
    """Draw luminances (k,) in cd/m² in two planes against degrees from the normal, which points up.

    Parameters
    ----------
    even : float, cd/m², luminance of a surface that sends the same flux evenly
    """

    def paint(figure: Figure) -> None:
        axes: Any = figure.add_axes(NODE_AXES, projection="polar")
        axes.set_theta_zero_location("N")
        axes.set_theta_direction(-1)
        axes.set(thetamin=-90.0, thetamax=90.0)
        axes.plot(np.radians(angles), np.full(len(angles), even), color=INK, linewidth=0.8, linestyle=":")
        axes.plot(np.radians(angles), across, color="#c05a00", linewidth=0.9, linestyle="--")
        axes.plot(np.radians(angles), along, color=ACCENT, linewidth=1.1)
        axes.set(ylim=(0.0, 1.08 * max(float(np.max([along, across])), even)))
        axes.set_thetagrids(
            (-90, -60, -30, 0, 30, 60, 90), [f"{abs(a)}°" for a in (90, 60, 30, 0, 30, 60, 90)]
        )
        axes.set_yticks(_round_steps(axes.get_ylim()[1]))
        axes.grid(color=FAINT, linewidth=0.3)
        axes.spines[:].set_linewidth(0.4)
        axes.tick_params(labelsize=6.5, pad=-1)
        figure.text(0.02, 0.88, mark, fontsize=8, fontweight="bold")

    return drawing(NODE_WIDTH, NODE_HEIGHT, paint=paint)


def _round_steps(largest: float) -> list[float]:
    """Three or four round numbers up to the largest."""
    return [float(tick) for tick in MaxNLocator(4).tick_values(0.0, largest) if 0 < tick <= largest]
