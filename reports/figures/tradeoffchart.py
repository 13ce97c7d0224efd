"""Charts of a sweep: time against error with the front, slopes by knob, and predicted against reached error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator

from lelight.reports.figures.drawing import ACCENT, FAINT, INK, axes_in, drawing, plain_axes
from lelight.reports.figures.scales import plain_number

WIDTH, HEIGHT = 88.0, 74.0
#: Marks and colours of knobs, told apart by both.
MARKS = ("o", "s", "^", "D", "v", "P")
COLOURS = (ACCENT, "#b3261e", "#3a7d44", "#8a5a00", "#6a3d9a", "#4d4d4d")

Runs = Sequence[Mapping[str, Any]]


def time_error_chart(runs: Runs, slopes: Mapping[str, float]) -> bytes:
    """Draw error in % over processor seconds: a mark a run, the front as a line, the slope in each knob's name."""

    def paint(figure: Figure) -> None:
        axes = _axes(figure, "processor seconds", "error in %")
        front = sorted((row["cpu_seconds"], 100 * row["error"]) for row in runs if row["front"])
        axes.plot(*zip(*front, strict=True), color=FAINT, linewidth=1.2, label="front", zorder=1)
        for knob, mark, colour in _styles(runs):
            own = [row for row in runs if row["knob"] == knob]
            fall = f" (slope {slopes[knob]:.2f})" if knob in slopes else ""
            style: Any = {"color": colour, "marker": mark, "s": 16, "label": f"{knob}{fall}", "zorder": 2}
            axes.scatter([r["cpu_seconds"] for r in own], [100 * r["error"] for r in own], **style)
        _named(axes, runs)
        _finish(axes)

    return drawing(WIDTH, HEIGHT, paint=paint)


def predicted_chart(runs: Runs) -> bytes:
    """Draw reached over predicted error in %, beside the line where both are equal and a factor of 1.5 around it."""

    def paint(figure: Figure) -> None:
        axes = _axes(figure, "error stated by the run in %", "error found in %")
        every = np.array([100 * row[key] for row in runs for key in ("predicted_error", "error")])
        ends = np.array([every.min() / 1.5, every.max() * 1.5])
        axes.plot(ends, ends, color=FAINT, linewidth=1.0, label="equal")
        axes.fill_between(ends, ends / 1.5, ends * 1.5, color=FAINT, alpha=0.15, linewidth=0)
        for knob, mark, colour in _styles(runs):
            own = [row for row in runs if row["knob"] == knob]
            style: Any = {"color": colour, "marker": mark, "s": 16, "label": knob}
            axes.scatter([100 * r["predicted_error"] for r in own], [100 * r["error"] for r in own], **style)
        _finish(axes)

    return drawing(WIDTH, HEIGHT, paint=paint)


def _styles(runs: Runs) -> list[tuple[str, str, str]]:
    knobs = dict.fromkeys(row["knob"] for row in runs)
    return [(k, MARKS[n % len(MARKS)], COLOURS[n % len(COLOURS)]) for n, k in enumerate(knobs)]


def _named(axes: Axes, runs: Runs) -> None:
    """Write the names of the presets beside their marks."""
    for row in runs:
        if row["knob"] == "preset":
            at = (row["cpu_seconds"], 100 * row["error"])
            axes.annotate(row["value"], at, xytext=(4, 3), textcoords="offset points", fontsize=7, color=INK)


def _axes(figure: Figure, across: str, up: str) -> Axes:
    axes = axes_in(figure, left=14.0, bottom=11.0, width=WIDTH - 18.0, height=HEIGHT - 14.0)
    plain_axes(axes)
    axes.set(xscale="log", yscale="log", xlabel=across, ylabel=up)
    return axes


def _finish(axes: Axes) -> None:
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        ticks = [t for t in LogLocator(subs=(1.0, 2.0, 5.0)).tick_values(low, high) if low <= t <= high]
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter(FuncFormatter(lambda tick, _: plain_number(tick)))
        axis.set_minor_locator(NullLocator())
    axes.grid(color=FAINT, linewidth=0.3, alpha=0.5)
    axes.legend(frameon=False, fontsize=6.5)
