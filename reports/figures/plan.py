"""Plan of the scene from above: surfaces that face up by their illuminance, eyes and measuring planes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from lelight.reports.figures.drawing import ACCENT, FAINT, INK, axes_in, drawing
from lelight.reports.figures.scales import ILLUMINANCE_COLOURS, illuminance_scale, legend
from lelight.reports.nodemesh import LitMesh
from lelight.scene import FloatArray

LEFT, RIGHT, BOTTOM, TOP = 12.0, 26.0, 10.0, 8.0
#: Length of a line of sight, as a share of the plan's larger side.
ARROW = 0.09
#: Millimetres on the plan that it has at least.
SHORTEST_ARROW = 8.0


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


def scene_plan(
    mesh: LitMesh, eyes: Sequence[Eye], rectangles: Sequence[Rectangle], *, width: float, height: float
) -> bytes:
    """Draw the scene as seen from above, within so many millimetres."""
    centre, half = _extent(mesh, eyes, rectangles)
    scale = min((width - LEFT - RIGHT) / half[0], (height - BOTTOM - TOP) / half[1]) / 2.0
    drawn = np.maximum(2.0 * scale * half, 20.0)

    def paint(figure: Figure) -> None:
        axes = axes_in(figure, left=LEFT, bottom=BOTTOM, width=drawn[0], height=drawn[1])
        reach = drawn / scale / 2.0
        axes.set(xlim=centre[0] + [-reach[0], reach[0]], ylim=centre[1] + [-reach[1], reach[1]])
        axes.set(xlabel="x in m", ylabel="y in m", aspect="equal")
        _paint_surfaces(figure, axes, mesh)
        for rectangle in rectangles:
            _paint_rectangle(axes, rectangle)
        for eye in eyes:
            _paint_eye(axes, eye, max(2.0 * ARROW * float(half.max()), SHORTEST_ARROW / scale))

    return drawing(drawn[0] + LEFT + RIGHT, drawn[1] + BOTTOM + TOP, paint=paint)


def _extent(
    mesh: LitMesh, eyes: Sequence[Eye], rectangles: Sequence[Rectangle]
) -> tuple[FloatArray, FloatArray]:
    """Centre (2,) and half sides (2,) in m of all that is on the plan, with a margin."""
    parts = [mesh.points, *(eye.position[None] for eye in eyes), *(each.corners for each in rectangles)]
    shown = np.concatenate(parts)[:, :2]
    smallest, largest = shown.min(axis=0), shown.max(axis=0)
    side = float((largest - smallest).max()) or 1.0
    return (smallest + largest) / 2.0, np.maximum((largest - smallest) / 2.0 + 0.04 * side, 0.1 * side)


def _paint_surfaces(figure: Figure, axes: Axes, mesh: LitMesh) -> None:
    triangles = mesh.upward
    if len(triangles):
        scale = illuminance_scale(mesh.illuminance[triangles])
        axes.tripcolor(
            *mesh.points[:, :2].T,
            np.clip(mesh.illuminance, scale.smallest, scale.largest),
            triangles=triangles,
            shading="gouraud",
            cmap=ILLUMINANCE_COLOURS,
            norm=scale.norm,
            rasterized=True,
        )
        right = axes.get_position().x1 * figure.get_size_inches()[0] * 25.4
        height = min(axes.get_position().height * figure.get_size_inches()[1] * 25.4, 70.0)
        bar = axes_in(figure, left=right + 4.0, bottom=BOTTOM, width=4.0, height=height)
        legend(bar, scale, colours=ILLUMINANCE_COLOURS, title="lx")
    axes.add_collection(
        LineCollection(list(mesh.border[:, :, :2]), colors=INK, linewidths=0.35), autolim=False
    )


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
