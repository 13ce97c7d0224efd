"""Colour scales: one for luminance over a whole report, one for illuminance in steps of EN 12464-1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from lelight.scene import FloatArray

LUMINANCE_COLOURS = "inferno"
ILLUMINANCE_COLOURS = "viridis"

#: Steps of illuminance within a decade (EN 12464-1:2021, 5.3.1: 20, 30, 50, 75, 100, 150, 200, ... lx).
STEPS_IN_DECADE = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5)
#: A scale of luminance never spans more decades than this; what is darker takes the darkest colour.
MOST_DECADES = 5


@dataclass(frozen=True)
class LogScale:
    """A logarithmic colour scale between two values, with the ticks of its legend."""

    smallest: float
    largest: float
    ticks: tuple[float, ...]

    @property
    def norm(self) -> LogNorm:
        """Matplotlib's view of the scale; values beyond either end take the colour of that end."""
        return LogNorm(self.smallest, self.largest, clip=True)


def luminance_scale(pictures: Sequence[FloatArray]) -> LogScale:
    """Choose steps 1, 3, 10 that hold all pictures but their darkest per mille, over five decades at most.

    Parameters
    ----------
    pictures : arrays of luminance in view, cd/m²
    """
    positive = [luminance[luminance > 0] for luminance in pictures]
    lit = np.concatenate(positive) if positive else np.empty(0)
    if not lit.size:
        return LogScale(1.0, 10.0, (1.0, 3.0, 10.0))
    largest = float(lit.max())
    smallest = max(float(np.quantile(lit, 0.001)), largest * 10.0**-MOST_DECADES)
    steps = _steps_around(smallest, largest, (1.0, 3.0))
    return LogScale(steps[0], steps[-1], steps)


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
    """Fill narrow axes with a logarithmic scale: its colours, its ticks and the unit as title."""
    limits = float(np.log10(scale.smallest)), float(np.log10(scale.largest))
    colour_bar(axes, limits, colours=colours, title=title)
    axes.yaxis.set_major_locator(FixedLocator([float(np.log10(tick)) for tick in scale.ticks]))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda exponent, _: plain_number(10.0**exponent)))


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
