"""Luminance picture of an observer in false colour, with its extrema or its glare sources."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from lelight.reports.figures.drawing import FAINT, INK, axes_in, drawing
from lelight.reports.figures.scales import LUMINANCE_COLOURS, LogScale, legend
from lelight.reports.pictures import LuminancePicture, disc_coordinates
from lelight.scene import FloatArray

DISC, LEGEND_WIDTH = 88.0, 24.0
#: Colour of marks on the picture; it does not occur in the false colours.
MARK = "#39d0e8"
RINGS = (30.0, 60.0)


@dataclass(frozen=True)
class Outline:
    """Border of a source on the unit disc, (k, 2), and the text beside it; counted in the rating or not."""

    border: FloatArray
    label: str
    counted: bool


def luminance_picture(picture: LuminancePicture, scale: LogScale) -> bytes:
    """Draw a fisheye with a legend, its brightest and its darkest point marked."""

    def paint(figure: Figure) -> None:
        axes = _paint_disc(figure, picture, scale)
        _mark_extremum(axes, picture, largest=True)
        _mark_extremum(axes, picture, largest=False)

    return drawing(DISC + LEGEND_WIDTH, DISC + 2.0, paint=paint)


def glare_picture(picture: LuminancePicture, scale: LogScale, outlines: Sequence[Outline]) -> bytes:
    """Draw a fisheye with a legend, rings at 30° and 60° and every source outlined and numbered."""

    def paint(figure: Figure) -> None:
        axes = _paint_disc(figure, picture, scale)
        for degrees in RINGS:
            _ring(axes, degrees)
        for outline in outlines:
            _outline(axes, outline)

    return drawing(DISC + LEGEND_WIDTH, DISC + 2.0, paint=paint)


def cone_border(right: float, up: float, forward: float, solid_angle: float) -> FloatArray:
    """Border on the unit disc of the cone around a direction that has the given solid angle.

    Parameters
    ----------
    right, up, forward : float; direction in the eye's axes, any length
    solid_angle : float, sr; half angle acos(1 - omega / 2 pi)

    Returns
    -------
    (65, 2) float; closed, x to the right, y up, radius 1 at 90° from the line of sight
    """
    axis = np.array([right, up, forward]) / np.linalg.norm([right, up, forward])
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    cos_half = 1.0 - min(solid_angle, 2.0 * np.pi) / (2.0 * np.pi)
    turn = np.linspace(0.0, 2.0 * np.pi, 65)[:, None]
    around = np.cos(turn) * side + np.sin(turn) * np.cross(axis, side)
    return _on_disc(cos_half * axis + np.sqrt(1.0 - cos_half**2) * around)


def _on_disc(directions: FloatArray) -> FloatArray:
    """Equi-angular projection of unit directions (k, 3) in the eye's axes to the unit disc (k, 2)."""
    theta = np.arccos(np.clip(directions[:, 2], -1.0, 1.0))
    sideways = np.hypot(directions[:, 0], directions[:, 1])
    radius = np.divide(theta / (np.pi / 2.0), sideways, out=np.zeros_like(theta), where=sideways > 0)
    return directions[:, :2] * radius[:, None]


def _paint_disc(figure: Figure, picture: LuminancePicture, scale: LogScale) -> Axes:
    axes = axes_in(figure, left=1.0, bottom=1.0, width=DISC, height=DISC)
    axes.set(xlim=(-1.01, 1.01), ylim=(-1.01, 1.01))
    axes.set_axis_off()
    luminance = np.maximum(picture.luminance, scale.smallest)
    image = axes.imshow(
        luminance,
        norm=scale.norm,
        cmap=LUMINANCE_COLOURS,
        extent=(-1.0, 1.0, -1.0, 1.0),
        interpolation="none",
    )
    image.set_clip_path(Circle((0.0, 0.0), 1.0, transform=axes.transData))
    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, edgecolor=INK, linewidth=0.6))
    bar = axes_in(figure, left=DISC + 6.0, bottom=6.0, width=4.0, height=DISC - 14.0)
    legend(bar, scale, colours=LUMINANCE_COLOURS, title="cd/m²")
    return axes


def _mark_extremum(axes: Axes, picture: LuminancePicture, *, largest: bool) -> None:
    row, column = picture.extremum(largest)
    x, y = disc_coordinates(len(picture.luminance))
    place = float(x[0, column]), float(y[row, 0])
    axes.plot(*place, marker="^" if largest else "v", color=MARK, markeredgecolor="black", markersize=6)
    _label(axes, place, "max" if largest else "min")


def _ring(axes: Axes, degrees: float) -> None:
    radius = degrees / 90.0
    axes.add_patch(
        Circle((0.0, 0.0), radius, fill=False, edgecolor=FAINT, linewidth=0.4, linestyle=(0, (4, 3)))
    )
    axes.text(0.0, -radius, f"{degrees:.0f}°", color="white", fontsize=6, ha="center", va="bottom")


def _outline(axes: Axes, outline: Outline) -> None:
    style = "-" if outline.counted else (0, (2, 1.5))
    axes.plot(*outline.border.T, color=MARK, linewidth=0.9, linestyle=style)
    centre = outline.border.mean(axis=0)
    rightmost = float(outline.border[:, 0].max())
    _label(axes, (min(rightmost, 0.95), float(centre[1])), outline.label)


def _label(axes: Axes, place: tuple[float, float], text: str) -> None:
    """Set a short text beside a point, on the side away from the rim."""
    to_left = place[0] > 0.6
    axes.annotate(
        text,
        place,
        xytext=(-5 if to_left else 5, 0),
        textcoords="offset points",
        ha="right" if to_left else "left",
        va="center",
        fontsize=7,
        bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
    )
