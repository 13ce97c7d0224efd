"""Plan of the scene from above: surfaces that face up by their illuminance, and what stands where over it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Wedge

from lelight.reports.figures.drawing import ACCENT, FAINT, INK, LAMP, SHINING, axes_in, drawing
from lelight.reports.figures.scales import ILLUMINANCE_COLOURS, LogScale, legend
from lelight.reports.nodemesh import LitMesh
from lelight.reports.texts import Texts
from lelight.scene import FloatArray

LEFT, RIGHT, BOTTOM, TOP = 12.0, 26.0, 10.0, 8.0
#: Length of a line of sight and of cones of view, as shares of the plan's larger side.
ARROW, CONE = 0.09, 0.3
#: Millimetres on the plan that an arrow has at least.
SHORTEST_ARROW = 8.0
#: Half angles in degrees of the cones of view.
CONES = (30.0, 60.0)
#: Luminaires that are named on the plan at most; more would hide it.
MOST_NAMED = 40


@dataclass(frozen=True)
class Eye:
    """Observer on the plan: mark, position (3,) m and direction (3,)."""

    mark: str
    position: FloatArray
    direction: FloatArray


@dataclass(frozen=True)
class Rectangle:
    """Measuring plane on the plan: mark and corners (4, 3) m."""

    mark: str
    corners: FloatArray


@dataclass(frozen=True)
class Lamp:
    """Luminaire on the plan: mark, position (3,) m, outline (k, 3) m, and direction (3,) of C0, zero for none."""

    mark: str
    position: FloatArray
    outline: FloatArray
    c0: FloatArray


@dataclass(frozen=True)
class PlanSheet:
    """Where the scene is on the sheet.

    Attributes
    ----------
    centre, half : (2,) float, m, of what is shown
    drawn : (2,) float, millimetres of the axes
    scale : float, millimetres for a metre
    """

    centre: FloatArray
    half: FloatArray
    drawn: FloatArray
    scale: float

    @classmethod
    def within(cls, points: FloatArray, *, width: float, height: float) -> PlanSheet:
        """Fit points (n, 3) in m, their axes and the legend into so many millimetres."""
        smallest, largest = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
        side = float((largest - smallest).max()) or 1.0
        half = np.maximum((largest - smallest) / 2.0 + 0.04 * side, 0.1 * side)
        scale = min((width - LEFT - RIGHT) / half[0], (height - BOTTOM - TOP) / half[1]) / 2.0
        return cls((smallest + largest) / 2.0, half, np.maximum(2.0 * scale * half, 20.0), scale)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the sheet in millimetres."""
        return float(self.drawn[0]) + LEFT + RIGHT, float(self.drawn[1]) + BOTTOM + TOP

    def axes(self, figure: Figure) -> Axes:
        """Axes on which a metre has its length."""
        axes = axes_in(figure, left=LEFT, bottom=BOTTOM, width=self.drawn[0], height=self.drawn[1])
        reach = self.drawn / self.scale / 2.0
        axes.set(xlim=self.centre[0] + [-reach[0], reach[0]], ylim=self.centre[1] + [-reach[1], reach[1]])
        axes.set(aspect="equal")
        return axes


def scene_plan(
    mesh: LitMesh,
    sheet: PlanSheet,
    scale: LogScale,
    texts: Texts,
    *,
    shining: FloatArray,
    lamps: Sequence[Lamp] = (),
    eyes: Sequence[Eye] = (),
    rectangles: Sequence[Rectangle] = (),
) -> bytes:
    """Draw the scene as seen from above.

    Parameters
    ----------
    shining : (k, 2, 3) float, m, outlines of surfaces that emit
    """

    def paint(figure: Figure) -> None:
        axes = sheet.axes(figure)
        axes.set(xlabel=texts["axis_x"], ylabel=texts["axis_y"])
        _paint_surfaces(axes, mesh, scale)
        bar = axes_in(
            figure,
            left=LEFT + sheet.drawn[0] + 4.0,
            bottom=BOTTOM,
            width=4.0,
            height=min(sheet.drawn[1], 70.0),
        )
        legend(bar, scale, colours=ILLUMINANCE_COLOURS, title="lx")
        for colour, width in (("white", 2.6), (SHINING, 1.3)):
            outlines = LineCollection(list(shining[:, :, :2]), colors=colour, linewidths=width)
            axes.add_collection(outlines, autolim=False)
        for lamp in lamps:
            _paint_lamp(axes, lamp, ARROW * float(sheet.half.max()), named=len(lamps) <= MOST_NAMED)
        for rectangle in rectangles:
            _paint_rectangle(axes, rectangle)
        for eye in eyes:
            _paint_eye(axes, eye, max(2.0 * ARROW * float(sheet.half.max()), SHORTEST_ARROW / sheet.scale))

    return drawing(*sheet.size, paint=paint)


def view_cones(eye: Eye, sheet: PlanSheet) -> bytes:
    """Draw one eye, its line of sight and its cones of view on a clear sheet that lies over a plan."""

    def paint(figure: Figure) -> None:
        axes = sheet.axes(figure)
        axes.set_axis_off()
        turn = float(np.degrees(np.arctan2(eye.direction[1], eye.direction[0])))
        reach = 2.0 * CONE * float(sheet.half.max())
        for half_angle in CONES if np.hypot(*eye.direction[:2]) > 1e-6 else ():
            cone = Wedge(_point(eye.position), reach, turn - half_angle, turn + half_angle)
            cone.set(facecolor="white", edgecolor="black", alpha=0.35, linewidth=0.5)
            axes.add_patch(cone)
        _paint_eye(axes, eye, max(2.0 * ARROW * float(sheet.half.max()), SHORTEST_ARROW / sheet.scale))

    return drawing(*sheet.size, paint=paint)


def _paint_surfaces(axes: Axes, mesh: LitMesh, scale: LogScale) -> None:
    triangles = mesh.upward
    if len(triangles):
        axes.tripcolor(
            *mesh.points[:, :2].T,
            np.clip(mesh.shown, scale.smallest, scale.largest),
            triangles=triangles,
            shading="gouraud",
            cmap=ILLUMINANCE_COLOURS,
            norm=scale.norm,
            rasterized=True,
        )
    axes.add_collection(
        LineCollection(list(mesh.border[:, :, :2]), colors=INK, linewidths=0.35), autolim=False
    )


def _paint_lamp(axes: Axes, lamp: Lamp, length: float, *, named: bool) -> None:
    axes.add_patch(Polygon(lamp.outline[:, :2], facecolor=LAMP, edgecolor="black", linewidth=0.7))
    if np.hypot(*lamp.c0[:2]) > 1e-6:
        axes.plot(
            *zip(_point(lamp.position), _point(lamp.position + length * lamp.c0), strict=True), "k", lw=0.8
        )
    if named:
        _mark(axes, _point(lamp.position), lamp.mark, offset=(-5, -12))


def _paint_rectangle(axes: Axes, rectangle: Rectangle) -> None:
    corners = rectangle.corners[:, :2]
    axes.add_patch(Polygon(corners, fill=False, edgecolor="white", linewidth=1.6))
    axes.add_patch(Polygon(corners, fill=False, edgecolor=ACCENT, linewidth=0.9, linestyle=(0, (4, 2))))
    _mark(axes, _point(rectangle.corners[0]), rectangle.mark, offset=(3, 3))


def _paint_eye(axes: Axes, eye: Eye, length: float) -> None:
    foot, tip = _point(eye.position), _point(eye.position + length * eye.direction)
    for colour, line_width in (("white", 2.6), ("black", 1.2)):
        axes.annotate(
            "",
            xy=tip,
            xytext=foot,
            arrowprops={
                "arrowstyle": "-|>",
                "mutation_scale": 8,
                "color": colour,
                "linewidth": line_width,
                "shrinkA": 0,
                "shrinkB": 0,
            },
        )
    axes.plot(*foot, marker="o", color="black", markeredgecolor="white", markersize=4.5)
    _mark(axes, foot, eye.mark, offset=(-4, 5))


def _point(position: FloatArray) -> tuple[float, float]:
    """Place on the plan, x and y in m, of a position (3,)."""
    return float(position[0]), float(position[1])


def _mark(axes: Axes, place: tuple[float, float], text: str, *, offset: tuple[int, int]) -> None:
    axes.annotate(
        text,
        place,
        xytext=offset,
        textcoords="offset points",
        ha="left" if offset[0] > 0 else "right",
        va="bottom",
        fontsize=7.5,
        bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": FAINT, "linewidth": 0.3},
    )
