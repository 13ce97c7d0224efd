"""The sheet that every figure is drawn on: its type, its lines and how it becomes SVG."""

from __future__ import annotations

import io
from collections.abc import Callable

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

MILLIMETRES_PER_INCH = 25.4
#: Dots an inch of what SVG holds as pixels (shaded triangles, colour bars).
PIXEL_DENSITY = 200

INK = "#1c2430"
FAINT = "#8a93a0"
ACCENT = "#12436d"
#: Luminaires, and outlines of surfaces that emit; the latter does not occur in the false colours of illuminance.
LAMP, SHINING = "#ffb000", "#d81b78"

#: Text is measured with STIX, which is as wide as the face that sets it: Libertinus, which Typst carries.
MEASURED_FACE, SET_FACE = b"STIXGeneral", b"Libertinus Serif"

STYLE = {
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.5,
    "font.family": MEASURED_FACE.decode(),
    "font.size": 8.0,
    "svg.fonttype": "none",
    "svg.hashsalt": "lelight",
    "text.color": INK,
    "xtick.color": FAINT,
    "xtick.labelcolor": INK,
    "xtick.labelsize": 7.5,
    "xtick.major.width": 0.5,
    "xtick.minor.width": 0.3,
    "ytick.color": FAINT,
    "ytick.labelcolor": INK,
    "ytick.labelsize": 7.5,
    "ytick.major.width": 0.5,
    "ytick.minor.width": 0.3,
}


def drawing(width: float, height: float, *, paint: Callable[[Figure], None]) -> bytes:
    """Draw a figure of so many millimetres and return it as SVG.

    ``paint`` fills an empty figure; the style and the seed of identifiers are set around it.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(width / MILLIMETRES_PER_INCH, height / MILLIMETRES_PER_INCH))
        figure.patch.set_alpha(0.0)
        paint(figure)
        svg = io.BytesIO()
        figure.savefig(svg, format="svg", dpi=PIXEL_DENSITY, metadata={"Date": None, "Creator": None})
    return svg.getvalue().replace(MEASURED_FACE, SET_FACE)


def axes_in(figure: Figure, *, left: float, bottom: float, width: float, height: float) -> Axes:
    """Place axes by millimetres from the lower left corner of the sheet."""
    sheet_width, sheet_height = figure.get_size_inches() * MILLIMETRES_PER_INCH
    return figure.add_axes(
        (left / sheet_width, bottom / sheet_height, width / sheet_width, height / sheet_height)
    )


def plain_axes(axes: Axes) -> None:
    """Take away the frame's upper and right side, which say nothing."""
    axes.spines[["top", "right"]].set_visible(False)
