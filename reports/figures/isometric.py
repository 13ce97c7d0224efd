"""The scene from the south-west and above, in parallel projection, its surfaces by their illuminance."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from lelight.reports.figures.drawing import axes_in, drawing
from lelight.reports.figures.scales import ILLUMINANCE_COLOURS, LogScale, legend
from lelight.reports.nodemesh import LitMesh
from lelight.scene import FloatArray

#: Direction to the camera: equal angles with all three axes, so that lengths along them have one scale.
TO_CAMERA: FloatArray = np.array([-1.0, -1.0, 1.0]) / np.sqrt(3.0)
RIGHT_HAND: FloatArray = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
UPWARDS: FloatArray = np.cross(TO_CAMERA, RIGHT_HAND)
LEGEND_WIDTH, MARGIN = 24.0, 2.0
#: Edges are drawn this share of the scene's size nearer to the camera than they are, over their own surfaces.
LIFT = 0.004


def isometric_view(mesh: LitMesh, scale: LogScale, *, width: float, height: float) -> bytes:
    """Draw what turns its front to the camera, farthest first, within so many millimetres."""
    faces, colours, edges = _painted(mesh, scale)
    flat = [part @ np.stack([RIGHT_HAND, UPWARDS], axis=1) for part in faces]
    shown = np.concatenate(flat) if flat else np.zeros((1, 2))
    low, high = shown.min(axis=0), shown.max(axis=0)
    spread = np.maximum(high - low, 1e-3 * float((high - low).max()) or 1.0)
    room = np.array([width - LEGEND_WIDTH - 2 * MARGIN, height - 2 * MARGIN])
    drawn = spread * float((room / spread).min())

    def paint(figure: Figure) -> None:
        axes = axes_in(figure, left=MARGIN, bottom=MARGIN, width=drawn[0], height=drawn[1])
        axes.set(xlim=(low[0], low[0] + spread[0]), ylim=(low[1], low[1] + spread[1]))
        axes.set_axis_off()
        polygons = PolyCollection(flat, facecolors=colours, edgecolors=edges, linewidths=0.4, rasterized=True)
        polygons.set_clip_on(False)
        axes.add_collection(polygons, autolim=False)
        bar_height = min(drawn[1] - 6.0, 70.0)
        bar = axes_in(figure, left=MARGIN + drawn[0] + 4.0, bottom=MARGIN + 1.0, width=4.0, height=bar_height)
        legend(bar, scale, colours=ILLUMINANCE_COLOURS, title="lx")

    return drawing(drawn[0] + LEGEND_WIDTH + 2 * MARGIN, max(drawn[1], 20.0) + 2 * MARGIN, paint=paint)


def _painted(mesh: LitMesh, scale: LogScale) -> tuple[list[FloatArray], FloatArray, FloatArray]:
    """Corners in m of faces and of edges, farthest first, with the colours (n, 4) of their inside and border."""
    facing = mesh.normals[mesh.triangles].mean(axis=1) @ TO_CAMERA > 0.02
    triangles = mesh.triangles[facing & mesh.lit]
    corners = mesh.points[triangles]
    shades = colormaps[ILLUMINANCE_COLOURS](scale.norm(mesh.shown[triangles].mean(axis=1)))
    lines = mesh.outline_of(triangles)
    ink = np.tile(colormaps["gray"](0.15), (len(lines), 1))
    depth = np.concatenate([corners.mean(axis=1) @ TO_CAMERA, lines.mean(axis=1) @ TO_CAMERA])
    size = float(np.ptp(mesh.points, axis=0).max()) if len(mesh.points) else 1.0
    depth[len(corners) :] += LIFT * size
    order = np.argsort(depth, kind="stable")
    shapes = [*corners, *lines]
    insides = np.concatenate([np.reshape(shades, (-1, 4)), np.zeros((len(lines), 4))])
    borders = np.concatenate([np.reshape(shades, (-1, 4)), ink.reshape(-1, 4)])
    return [shapes[k] for k in order], insides[order], borders[order]
