"""Cumulative distribution of luminance over the solid angle in view."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from lelight.reports.figures.drawing import ACCENT, FAINT, axes_in, drawing, plain_axes
from lelight.reports.figures.scales import LogScale, plain_number
from lelight.reports.pictures import LuminancePicture
from lelight.reports.texts import Texts

WIDTH, HEIGHT = 104.0, 44.0
POINTS = 400


def cumulative_distribution(picture: LuminancePicture, scale: LogScale, texts: Texts) -> bytes:
    """Draw the share of the view in per cent that is not brighter than a luminance."""
    luminance, shares = picture.distribution()
    # Where the curve is read off: evenly along the axis, not along the pixels.
    largest = max(scale.largest, float(luminance[-1]))
    at = np.geomspace(scale.smallest, largest, POINTS)
    places = np.searchsorted(luminance, at, side="right")
    reached = np.concatenate([[0.0], shares])[places]

    def paint(figure: Figure) -> None:
        axes = axes_in(figure, left=14.0, bottom=11.0, width=WIDTH - 20.0, height=HEIGHT - 14.0)
        plain_axes(axes)
        axes.fill_between(at, 100.0 * reached, color=ACCENT, alpha=0.12, linewidth=0)
        axes.plot(at, 100.0 * reached, color=ACCENT, linewidth=1.0)
        axes.set(xscale="log", xlim=(scale.smallest, largest), ylim=(0, 100))
        axes.set(xlabel=texts["axis_luminance"], ylabel=texts["axis_share"], yticks=[0, 25, 50, 75, 100])
        axes.xaxis.set_major_formatter(FuncFormatter(lambda tick, _: plain_number(tick)))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(color=FAINT, linewidth=0.3, alpha=0.5)

    return drawing(WIDTH, HEIGHT, paint=paint)
