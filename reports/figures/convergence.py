"""Error against time as a run goes on."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullLocator

from lelight.reports.figures.drawing import ACCENT, FAINT, axes_in, drawing, plain_axes
from lelight.reports.figures.scales import plain_number
from lelight.reports.texts import Texts
from lelight.scene import FloatArray

WIDTH, HEIGHT = 112.0, 58.0
FEWEST_TICKS = 3


def convergence_curve(
    seconds: FloatArray, errors: FloatArray, *, target: float | None, texts: Texts
) -> bytes:
    """Draw relative errors (k,) against seconds (k,), both positive, beside the slope of plain Monte Carlo.

    The dashed line falls with the square root of time through the first point; a dotted one is the target.
    """

    def paint(figure: Figure) -> None:
        axes = axes_in(figure, left=15.0, bottom=11.0, width=WIDTH - 19.0, height=HEIGHT - 14.0)
        plain_axes(axes)
        axes.set(xscale="log", yscale="log", xlabel=texts["axis_time"], ylabel=texts["axis_error"])
        slope = 100.0 * errors[0] * (seconds / seconds[0]) ** -0.5
        dashes: Any = {"color": FAINT, "linewidth": 0.8, "linestyle": (0, (5, 3))}
        axes.plot(seconds, slope, label=texts["legend_slope"], **dashes)
        dots: Any = {"color": ACCENT, "linewidth": 1.0, "marker": "o", "markersize": 3}
        axes.plot(seconds, 100.0 * errors, label=texts["legend_reached"], **dots)
        if target is not None:
            limit: Any = {"color": "#b3261e", "linewidth": 0.8, "linestyle": ":"}
            axes.axhline(100.0 * target, label=texts["legend_target"], **limit)
        _round_ticks(axes)
        axes.legend(frameon=False, fontsize=7.5)

    return drawing(WIDTH, HEIGHT, paint=paint)


def _round_ticks(axes: Axes) -> None:
    """Ticks 1, 2, 5 within decades, or at even steps where the axis spans too little for three of those."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        ticks = [
            tick for tick in LogLocator(subs=(1.0, 2.0, 5.0)).tick_values(low, high) if low <= tick <= high
        ]
        if len(ticks) < FEWEST_TICKS:
            ticks = [tick for tick in MaxNLocator(5).tick_values(low, high) if low <= tick <= high]
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter(FuncFormatter(lambda tick, _: plain_number(tick)))
        axis.set_minor_locator(NullLocator())
    axes.grid(color=FAINT, linewidth=0.3, alpha=0.5)
