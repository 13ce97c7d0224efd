"""Error against time as a run goes on."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from lelight.reports.figures.drawing import ACCENT, FAINT, axes_in, drawing, plain_axes
from lelight.reports.figures.scales import plain_number
from lelight.scene import FloatArray

WIDTH, HEIGHT = 112.0, 58.0


def convergence_curve(seconds: FloatArray, errors: FloatArray, *, target: float | None) -> bytes:
    """Draw relative errors (k,) against seconds (k,), both positive, beside the slope of plain Monte Carlo.

    The dashed line falls with the square root of time through the first point; a dotted one is the target.
    """

    def paint(figure: Figure) -> None:
        axes = axes_in(figure, left=15.0, bottom=11.0, width=WIDTH - 19.0, height=HEIGHT - 14.0)
        plain_axes(axes)
        axes.set(xscale="log", yscale="log", xlabel="time in s", ylabel="rms error in %")
        slope = 100.0 * errors[0] * (seconds / seconds[0]) ** -0.5
        axes.plot(seconds, slope, color=FAINT, linewidth=0.8, linestyle=(0, (5, 3)), label="slope −1/2")
        axes.plot(
            seconds, 100.0 * errors, color=ACCENT, linewidth=1.0, marker="o", markersize=3, label="reached"
        )
        if target is not None:
            axes.axhline(100.0 * target, color="#b3261e", linewidth=0.8, linestyle=":", label="target")
        _round_ticks(axes)
        axes.legend(frameon=False, fontsize=7.5)

    return drawing(WIDTH, HEIGHT, paint=paint)


def _round_ticks(axes: Axes) -> None:
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda tick, _: plain_number(tick)))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(color=FAINT, linewidth=0.3, alpha=0.5)
