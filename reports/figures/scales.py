"""Colour scales: one for luminance over a whole report, one for illuminance in steps of EN 12464-1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.patches import Polygon
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from lelight.reports.figures.drawing import MILLIMETRES_PER_INCH
from lelight.scene import FloatArray

LUMINANCE_COLOURS = "inferno"
ILLUMINANCE_COLOURS = "viridis"

#: Steps of illuminance within a decade (EN 12464-1:2021, 5.3.1: 20, 30, 50, 75, 100, 150, 200, ... lx).
STEPS_IN_DECADE = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5)
#: Shares of all pixels in view below and above which the scale of luminance does not reach, and the decades that
#: it spans at most: small bright lamps would else leave the room one colour.
DARKEST, BRIGHTEST, MOST_DECADES = 0.001, 0.99, 4
#: What exceeds the last step by this factor at most is not worth another step.
CLOSE = 1.05
#: Millimetres from one number of a legend to the next at least.
ROOM_OF_TICK = 3.4


@dataclass(frozen=True)
class LogScale:
    """A logarithmic colour scale between two values, with the ticks of its legend.

    Attributes
    ----------
    below, above : True where some of what is shown lies beyond that end
    """

    smallest: float
    largest: float
    ticks: tuple[float, ...]
    below: bool = False
    above: bool = False

    @property
    def norm(self) -> LogNorm:
        """Matplotlib's view of the scale; values beyond either end take the colour of that end."""
        return LogNorm(self.smallest, self.largest, clip=True)


def luminance_scale(pictures: Sequence[FloatArray]) -> LogScale:
    """Choose steps 1, 3, 10 that hold nearly all of all pictures, over four decades at most.

    Parameters
    ----------
    pictures : arrays of luminance in view, cd/m²
    """
    positive = [luminance[luminance > 0] for luminance in pictures]
    lit = np.concatenate(positive) if positive else np.empty(0)
    if not lit.size:
        return LogScale(1.0, 10.0, (1.0, 3.0, 10.0))
    largest = float(np.quantile(lit, BRIGHTEST))
    smallest = max(float(np.quantile(lit, DARKEST)), largest * 10.0**-MOST_DECADES)
    steps = _steps_around(smallest, max(largest / CLOSE, 1.001 * smallest), (1.0, 3.0))
    below, above = bool(lit.min() < steps[0]), bool(lit.max() > CLOSE * steps[-1])
    return LogScale(steps[0], steps[-1], steps, below, above)


def illuminance_scale(illuminance: FloatArray) -> LogScale:
    """Choose steps of EN 12464-1 around illuminances in lx, the darkest 2 % of them left out."""
    lit = illuminance[illuminance > 0]
    if not lit.size:
        return LogScale(1.0, 10.0, (1.0, 10.0))
    steps = en_steps(float(np.quantile(lit, 0.02)), float(lit.max()))
    return LogScale(steps[0], steps[-1], steps)


def en_steps(smallest: float, largest: float) -> tuple[float, ...]:
    """List the steps from the last one not above ``smallest`` to the first one not below ``largest``, in lx.

    >>> en_steps(60, 310)
    (50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 500.0)
    """
    return _steps_around(smallest, largest, STEPS_IN_DECADE)


def legend(axes: Axes, scale: LogScale, *, colours: str, title: str) -> None:
    """Fill narrow axes with a logarithmic scale: its colours, its ticks, the unit as title, points beyond its ends."""
    limits = float(np.log10(scale.smallest)), float(np.log10(scale.largest))
    colour_bar(axes, limits, colours=colours, title=title)
    sheet = axes.get_figure(root=True)
    assert sheet is not None
    height = axes.get_position().height * float(sheet.get_size_inches()[1]) * MILLIMETRES_PER_INCH
    ticks = _told_apart(scale.ticks, height=height)
    axes.yaxis.set_major_locator(FixedLocator([float(np.log10(tick)) for tick in ticks]))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda exponent, _: plain_number(10.0**exponent)))
    for beyond, base, tip, colour in ((scale.below, 0.0, -0.05, 0.0), (scale.above, 1.0, 1.05, 1.0)):
        if beyond:
            corners = [(0.0, base), (1.0, base), (0.5, tip)]
            point = Polygon(corners, transform=axes.transAxes, clip_on=False, linewidth=0.5)
            point.set(facecolor=colormaps[colours](colour), edgecolor=axes.spines["left"].get_edgecolor())
            axes.add_patch(point)
    if scale.above:
        axes.set_title(title, fontsize=8, loc="left", pad=14)


def _told_apart(ticks: Sequence[float], *, height: float) -> list[float]:
    """Leave out ticks within decades until numbers have room on a bar of so many millimetres."""
    for mantissas in ((1.0, 1.5, 2.0, 3.0, 5.0, 7.5), (1.0, 2.0, 5.0), (1.0, 3.0), (1.0,)):
        kept = [tick for tick in ticks if float(f"{tick:e}".split("e")[0]) in mantissas]
        if len(kept) * ROOM_OF_TICK <= height:
            break
    return kept


def colour_bar(axes: Axes, limits: tuple[float, float], *, colours: str, title: str) -> None:
    """Fill narrow axes with the colours between two values, ticks on the right, the unit as title."""
    ramp = np.linspace(0.0, 1.0, 256)[:, None]
    axes.imshow(
        ramp, cmap=colours, extent=(0.0, 1.0, *limits), origin="lower", aspect="auto", interpolation="none"
    )
    axes.xaxis.set_major_locator(NullLocator())
    axes.yaxis.tick_right()
    axes.set_title(title, fontsize=8, loc="left", pad=5)


def plain_number(number: float) -> str:
    """Write a tick without trailing zeros and without powers of ten: 0.01, 7.5, 10 000."""
    text = f"{float(f'{number:.6g}'):,.10f}".rstrip("0").rstrip(".")
    return text.replace(",", "\u202f" if number >= 10_000 else "")


def _steps_around(smallest: float, largest: float, in_decade: Sequence[float]) -> tuple[float, ...]:
    """List two steps at least: the last not above ``smallest`` to the first not below ``largest``."""
    first, last = int(np.floor(np.log10(smallest))) - 1, int(np.ceil(np.log10(largest))) + 1
    steps = np.array([float(f"{step}e{decade}") for decade in range(first, last + 1) for step in in_decade])
    start = int(np.searchsorted(steps, smallest, side="right")) - 1
    end = max(int(np.searchsorted(steps, largest, side="left")), start + 1)
    return tuple(float(step) for step in steps[start : end + 1])
