"""Luminance pictures in false colour: logarithmic steps, a legend, the extremes marked."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from lelight.scene import FloatArray
from lelight.writing.files import whole

#: Perceptually ordered, safe for colour-blind eyes, legible in grey print.
COLOUR_MAP = "viridis"

#: Grey and red do not occur in the colour map.
_BELOW, _ABOVE, _OUTSIDE = "dimgrey", "#d7191c", "white"
_DOTS_PER_INCH = 100
_SMALLEST_SIDE, _LONGEST_SIDE = 600, 2000
_MARGIN, _TITLE_HEIGHT, _LEGEND_WIDTH = 24, 60, 150
_ALL_DARK = (1e-3, 1.0)
#: Standard deviation in pixels of the smoothing under isolines.
SMOOTHING = 2.0


@dataclass(frozen=True)
class Marks:
    """What is drawn over a picture.

    Attributes
    ----------
    extremes : whether the darkest and the brightest pixel are marked
    isolines : values of lines of equal luminance; empty for the legend's own, None for no lines
    """

    extremes: bool = True
    isolines: tuple[float, ...] | None = None


def write_falsecolour(
    path: Path,
    luminance: NDArray[np.floating],
    *,
    title: str,
    limits: tuple[float, float] | None = None,
    unit: str = "cd/m²",
    marks: Marks | None = None,
) -> None:
    """Write a PNG of the picture in false colour on a logarithmic scale with a legend.

    Values beyond the limits have their own colours, shown at the legend's ends. Equal input gives equal
    bytes.

    Parameters
    ----------
    luminance : (h, w) float, nan where there is no picture
    limits : smallest and largest value that the scale tells apart; default `decade_limits`
    marks : what is drawn over the picture; default its extremes
    """
    lower, upper = limits or decade_limits(luminance)
    if not 0 < lower < upper:
        raise ValueError(f"limits: ({lower}, {upper}), must be positive and ascending")
    marks = marks or Marks()
    figure, picture_axes, legend_axes = _canvas(luminance.shape)
    # A logarithmic scale has no zero: what is dark is drawn as just below the scale.
    shown = picture_axes.imshow(
        np.maximum(luminance, lower / 10),
        norm=LogNorm(lower, upper),
        cmap=_colours(),
        interpolation="nearest",
    )
    _draw_legend(figure, shown, legend_axes, extend=_clipped_ends(luminance, lower, upper), unit=unit)
    if marks.isolines is not None:
        _draw_isolines(picture_axes, luminance, marks.isolines or tuple(scale_ticks(lower, upper).tolist()))
    if marks.extremes:
        _mark_extremes(picture_axes, luminance, unit)
    picture_axes.set_title(" ".join(title.split()), parse_math=False, fontsize=12, loc="left", pad=28)
    _save(figure, path)


def decade_limits(luminance: NDArray[np.floating], decades: int | None = None) -> tuple[float, float]:
    """Choose a scale of so many decades, else of three to four, that ends just above the 99.9th percentile.

    Both ends are of the series 1, 3, 10; the lower one follows the darkest thousandth within these bounds.
    """
    lit = luminance[np.isfinite(luminance) & (luminance > 0)]
    if not lit.size:
        return _ALL_DARK
    darkest, brightest = np.percentile(lit, [0.1, 99.9])
    upper = _one_three_ten(brightest, np.ceil)
    if decades is not None:
        return upper / 10.0**decades, upper
    lower = _one_three_ten(np.clip(darkest, upper / 1e4, upper / 1e3), np.floor)
    return lower, upper


def scale_ticks(lower: float, upper: float) -> FloatArray:
    """Values 1, 3, 10, 30 ... between the limits, both included."""
    decades = np.arange(np.floor(np.log10(lower)) - 1, np.ceil(np.log10(upper)) + 1)
    series = np.outer(10.0**decades, [1, 3]).ravel()
    inside = (series >= lower * (1 - 1e-9)) & (series <= upper * (1 + 1e-9))
    return np.asarray(series[inside])


def _one_three_ten(value: float, rounding: np.ufunc) -> float:
    """Round to the series 1, 3, 10 with ``np.floor`` or ``np.ceil``."""
    decade = 10.0 ** np.floor(np.log10(value) + 1e-9)
    steps = np.array([1.0, 3.0, 10.0]) * decade
    if rounding is np.ceil:
        return float(steps[steps >= value * (1 - 1e-9)][0])
    return float(steps[steps <= value * (1 + 1e-9)][-1])


def _colours() -> Colormap:
    return colormaps[COLOUR_MAP].with_extremes(under=_BELOW, over=_ABOVE, bad=_OUTSIDE)


def _canvas(shape: tuple[int, ...]) -> tuple[Figure, Any, Any]:
    """Lay out a figure in which a pixel of the picture covers a whole number of pixels of the PNG."""
    magnification = max(1, min(round(_SMALLEST_SIDE / min(shape)), _LONGEST_SIDE // max(shape)))
    height, width = (side * magnification for side in shape)
    full_width = width + 2 * _MARGIN + _LEGEND_WIDTH
    full_height = height + 2 * _MARGIN + _TITLE_HEIGHT
    figure = Figure((full_width / _DOTS_PER_INCH, full_height / _DOTS_PER_INCH), dpi=_DOTS_PER_INCH)
    FigureCanvasAgg(figure)

    def axes(left: float, across: float) -> Any:
        box = (left / full_width, _MARGIN / full_height, across / full_width, height / full_height)
        return figure.add_axes(box)

    picture_axes, legend_axes = axes(_MARGIN, width), axes(_MARGIN + width + 30, 24)
    picture_axes.set_axis_off()
    return figure, picture_axes, legend_axes


def _clipped_ends(luminance: NDArray[np.floating], lower: float, upper: float) -> str:
    below, above = bool(np.any(luminance < lower)), bool(np.any(luminance > upper))
    return {(False, False): "neither", (True, False): "min", (False, True): "max"}.get((below, above), "both")


def _draw_legend(figure: Figure, shown: Any, axes: Any, *, extend: str, unit: str) -> None:
    bar = figure.colorbar(shown, cax=axes, extend=extend)
    bar.ax.yaxis.set_major_locator(FixedLocator(scale_ticks(shown.norm.vmin, shown.norm.vmax).tolist()))
    bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: _short(value)))
    bar.ax.text(1.0, 1.06, unit, transform=axes.transAxes, ha="center", parse_math=False)


def _draw_isolines(axes: Any, luminance: NDArray[np.floating], values: tuple[float, ...]) -> None:
    """Draw lines of equal luminance where they are a step of the picture, each with its value."""
    known = luminance[np.isfinite(luminance)]
    crossed = sorted({v for v in values if known.size and known.min() < v < known.max()})
    if not crossed:
        return
    smooth = _smoothed(luminance)
    lines = axes.contour(smooth, levels=crossed, colors="white", linewidths=0.8)
    for text in axes.clabel(lines, fmt=_short, fontsize=8, colors="white"):
        text.set_path_effects([withStroke(linewidth=1.5, foreground="black")])


def _smoothed(luminance: NDArray[np.floating]) -> FloatArray:
    """Means of the logarithm over a few pixels around, nan where there is no picture: lines do not follow noise."""
    lit = luminance > 0
    weight = gaussian_filter(lit.astype(float), SMOOTHING)
    logarithm = gaussian_filter(np.where(lit, np.log(np.where(lit, luminance, 1.0)), 0.0), SMOOTHING)
    return np.where(lit, np.exp(logarithm / np.where(lit, weight, 1.0)), np.nan)


def _mark_extremes(axes: Any, luminance: NDArray[np.floating], unit: str) -> None:
    """Mark the darkest and the brightest pixel and tell their values above the picture."""
    if np.all(np.isnan(luminance)):
        return
    marks = {"v": ("min", np.nanargmin(luminance)), "^": ("max", np.nanargmax(luminance))}
    told = []
    for marker, (name, flat_index) in marks.items():
        row, column = np.unravel_index(flat_index, luminance.shape)
        axes.plot(column, row, marker, markersize=9, markerfacecolor="white", markeredgecolor="black")
        sign = {"v": "\N{WHITE DOWN-POINTING TRIANGLE}", "^": "\N{WHITE UP-POINTING TRIANGLE}"}[marker]
        told.append(f"{sign} {name} {_short(luminance[row, column])} {unit}")
    axes.text(
        0, 1, "    ".join(told) + "\n", transform=axes.transAxes, fontsize=10, va="baseline", parse_math=False
    )


def _short(value: float) -> str:
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _save(figure: Figure, path: Path) -> None:
    with whole(path) as beside, warnings.catch_warnings():
        # A title may hold letters that the font lacks; they are drawn as boxes.
        warnings.filterwarnings("ignore", message="Glyph .* missing")
        figure.savefig(beside, metadata={"Software": "lelight"})
