"""Illuminance on a measuring plane: numbers in the cells of its grid, and isolines over false colour."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lelight.reports.figures.drawing import axes_in, drawing
from lelight.reports.figures.scales import ILLUMINANCE_COLOURS, colour_bar, en_steps, plain_number
from lelight.reports.planegrid import PlaneGrid
from lelight.reports.texts import Texts
from lelight.scene import FloatArray

LEFT, RIGHT, BOTTOM, TOP = 12.0, 22.0, 10.0, 7.0
POINTS_PER_MILLIMETRE = 72.0 / 25.4
#: Type sizes in points; a number that would need less than the smallest is not written.
SMALLEST_TYPE, LARGEST_TYPE = 4.5, 8.0
#: Share of a cell's width and height that its number may take, and the width of a digit in em.
FILLED_WIDTH, FILLED_HEIGHT, DIGIT_WIDTH = 0.86, 0.7, 0.5
#: Isolines at fewer steps of EN 12464-1 than this tell little; about so many even steps are drawn beside them.
FEWEST_STEPS, EVEN_STEPS = 3, 6
#: Widths in points of lines at steps of the standard and at even steps.
LINE_WIDTHS = (1.2, 0.5)


@dataclass(frozen=True)
class Sheet:
    """Where a plane's chart goes: millimetres of the drawn rectangle, and millimetres for one metre."""

    width: float
    height: float
    scale: float

    @classmethod
    def within(cls, grid: PlaneGrid, *, width: float, height: float) -> Sheet:
        """Fit the grid's rectangle with its axes and legend into so many millimetres."""
        side = _sides(grid)
        scale = min((width - LEFT - RIGHT) / side[0], (height - BOTTOM - TOP) / side[1])
        return cls(side[0] * scale, side[1] * scale, scale)


def value_chart(grid: PlaneGrid, sheet: Sheet, texts: Texts) -> bytes:
    """Draw the grid's cells in false colour with the illuminance in lx written in each."""

    def paint(axes: Axes, norm: Normalize) -> None:
        edges = (np.arange(cells + 1) * step for cells, step in zip(_cells(grid), grid.spacing, strict=True))
        axes.pcolormesh(
            *edges, grid.illuminance, cmap=ILLUMINANCE_COLOURS, norm=norm, edgecolors="white", linewidth=0.3
        )
        _write_numbers(axes, grid, norm, size=number_size(grid, sheet))

    return _chart(grid, sheet, texts, paint)


def isoline_chart(grid: PlaneGrid, sheet: Sheet, texts: Texts) -> bytes:
    """Draw the illuminance between the grid's points in false colour, with isolines in lx."""

    def paint(axes: Axes, norm: Normalize) -> None:
        # Half a cell beyond the outer points the value is taken to stay the same.
        illuminance = np.pad(grid.illuminance, 1, mode="edge")
        x, y = (_centres(cells, step) for cells, step in zip(_cells(grid), grid.spacing, strict=True))
        shades = np.linspace(*_limits(grid.illuminance), 65)
        axes.contourf(x, y, illuminance, levels=shades, cmap=ILLUMINANCE_COLOURS, norm=norm).set_rasterized(
            True
        )
        for levels, width in zip(isolines(grid.illuminance), LINE_WIDTHS, strict=True):
            if not levels:
                continue
            legible = [_legible_on(norm, level) for level in levels]
            lines = axes.contour(x, y, illuminance, levels=levels, colors=legible, linewidths=width)
            axes.clabel(lines, fmt=plain_number, fontsize=7)

    return _chart(grid, sheet, texts, paint)


def number_size(grid: PlaneGrid, sheet: Sheet) -> float:
    """Type size in points at which the longest number fits into a cell; 0 where none is legible."""
    digits = len(_written(float(grid.illuminance.max())))
    cell_width, cell_height = (step * sheet.scale * POINTS_PER_MILLIMETRE for step in grid.spacing)
    size = min(FILLED_WIDTH * cell_width / (DIGIT_WIDTH * digits), FILLED_HEIGHT * cell_height, LARGEST_TYPE)
    return size if size >= SMALLEST_TYPE else 0.0


def isolines(illuminance: FloatArray) -> tuple[list[float], list[float]]:
    """Levels in lx: the steps of EN 12464-1 between the extremes, and even steps where those are too few.

    Both lists are empty where there is nothing to interpolate: one row, one column or one value.
    """
    smallest, largest = float(illuminance.min()), float(illuminance.max())
    if min(illuminance.shape) < 2 or not smallest < largest:
        return [], []
    steps = en_steps(max(smallest, 1e-3 * largest), largest)
    of_standard = [step for step in steps if smallest < step < largest]
    if len(of_standard) >= FEWEST_STEPS:
        return of_standard, []
    even = MaxNLocator(EVEN_STEPS).tick_values(smallest, largest)
    between = [float(step) for step in even if smallest < step < largest and step not in of_standard]
    return of_standard, between


def isoline_statement(illuminance: FloatArray, texts: Texts) -> str:
    """Say at which levels the isolines are."""
    of_standard, between = isolines(illuminance)
    if not between:
        return texts["steps_of_en"]
    even = np.unique(
        np.round(np.diff(MaxNLocator(EVEN_STEPS).tick_values(illuminance.min(), illuminance.max())), 9)
    )
    return texts.filled("steps_both" if of_standard else "steps_every", step=plain_number(float(even[0])))


def _chart(grid: PlaneGrid, sheet: Sheet, texts: Texts, paint: Callable[[Axes, Normalize], None]) -> bytes:
    norm = Normalize(*_limits(grid.illuminance))

    def paint_all(figure: Figure) -> None:
        axes = axes_in(figure, left=LEFT, bottom=BOTTOM, width=sheet.width, height=sheet.height)
        side = _sides(grid)
        axes.set(xlim=(0.0, side[0]), ylim=(0.0, side[1]))
        axes.set(xlabel=texts["axis_first"], ylabel=texts["axis_second"])
        paint(axes, norm)
        bar_height = max(sheet.height, 15.0)
        bar = axes_in(figure, left=LEFT + sheet.width + 4.0, bottom=BOTTOM, width=4.0, height=bar_height)
        colour_bar(bar, _limits(grid.illuminance), colours=ILLUMINANCE_COLOURS, title="lx")

    height = max(sheet.height, 15.0) + BOTTOM + TOP
    return drawing(max(sheet.width, 15.0) + LEFT + RIGHT, height, paint=paint_all)


def _write_numbers(axes: Axes, grid: PlaneGrid, norm: Normalize, *, size: float) -> None:
    for (row, column), illuminance in np.ndenumerate(grid.illuminance):
        place = (column + 0.5) * grid.spacing[0], (row + 0.5) * grid.spacing[1]
        colour = _legible_on(norm, illuminance)
        axes.text(
            *place, _written(illuminance), color=colour, fontsize=size, ha="center", va="center_baseline"
        )


def _legible_on(norm: Normalize, illuminance: float) -> str:
    """Black where the false colour is bright, white where it is dark."""
    return "black" if norm(illuminance) > 0.6 else "white"


def _written(illuminance: float) -> str:
    """Write the number of a cell: whole lux, three significant digits below 100 lx."""
    return f"{illuminance:.0f}" if illuminance >= 100 else f"{illuminance:.3g}"


def _limits(illuminance: FloatArray) -> tuple[float, float]:
    """Round numbers around the values, in lx, for a linear scale."""
    smallest, largest = float(illuminance.min()), float(illuminance.max())
    ticks = MaxNLocator(6).tick_values(smallest, max(largest, 1.001 * smallest + 1e-9))
    return max(float(ticks[0]), 0.0), float(ticks[-1])


def _cells(grid: PlaneGrid) -> tuple[int, int]:
    rows, columns = grid.illuminance.shape
    return columns, rows


def _sides(grid: PlaneGrid) -> FloatArray:
    return np.asarray(np.array(_cells(grid)) * np.array(grid.spacing))


def _centres(cells: int, step: float) -> FloatArray:
    """Middles of cells with both outer borders added, (cells + 2,) m."""
    return np.concatenate([[0.0], (np.arange(cells) + 0.5) * step, [cells * step]])
