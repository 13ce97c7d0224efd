"""A node's luminance body as files: a VTK glyph that stands on its surface, and a picture."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from lelight.nodelight import LuminanceBody
from lelight.scene import FloatArray, IntArray
from lelight.writing.falsecolour import COLOUR_MAP
from lelight.writing.files import whole
from lelight.writing.polydata import PolyData, write_polydata

_SIZE, _DOTS_PER_INCH = (11.0, 5.0), 100


def write_glyph(path: Path, body: LuminanceBody, *, position: FloatArray, length: float) -> None:
    """Write the body as ``.vtp``: a surface around the node, as far from it as it is bright that way.

    Parameters
    ----------
    position : (3,) float, m, of the node
    length : float, m, from the node to the surface in the brightest direction
    """
    zeniths, azimuths = body.luminance.shape
    largest = max(float(body.luminance.max()), np.finfo(float).tiny)
    reach = length * np.maximum(body.luminance, 0.0) / largest
    points = position + reach[..., None] * body.directions
    write_polydata(
        path,
        PolyData(
            points=np.concatenate([points.reshape(-1, 3), position[None]]),
            polygons=_triangles(zeniths, azimuths),
            point_arrays={
                "luminance_cd_m2": np.append(body.luminance.ravel(), 0.0),
                "images_of_emitters_cd_m2": np.append(body.images.ravel(), 0.0),
            },
            texts={"scale": (f"{length / largest:.9g} m per cd/m2",), "node": (str(body.node),)},
        ),
    )


def _triangles(zeniths: int, azimuths: int) -> IntArray:
    """Triangles (k, 3) of the grid, closed by a fan from the node to the horizon, fronts outside."""
    ring, turn = np.meshgrid(np.arange(zeniths - 1), np.arange(azimuths), indexing="ij")
    here, beside = ring * azimuths + turn, ring * azimuths + (turn + 1) % azimuths
    below, below_beside = here + azimuths, beside + azimuths
    upper = np.stack([here, below, below_beside], axis=-1).reshape(-1, 3)
    lower = np.stack([here, below_beside, beside], axis=-1).reshape(-1, 3)
    last = (zeniths - 1) * azimuths + np.arange(azimuths)
    fan = np.column_stack([np.full(azimuths, zeniths * azimuths), np.roll(last, -1), last])
    return np.concatenate([upper[upper[:, 0] != upper[:, 1]], lower, fan])


def write_body_picture(path: Path, body: LuminanceBody, *, title: str) -> None:
    """Write a PNG: the body in space, and cuts through its brightest direction and across."""
    figure = Figure(figsize=_SIZE, dpi=_DOTS_PER_INCH, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    _draw_space(figure, body)
    _draw_cuts(figure, body)
    with warnings.catch_warnings(), whole(path) as beside:
        warnings.simplefilter("ignore")  # letters that the font lacks are drawn as boxes
        figure.suptitle(title.replace("$", r"\$"))
        canvas.print_png(str(beside), metadata={"Software": None})


def _draw_space(figure: Figure, body: LuminanceBody) -> None:
    axes = figure.add_subplot(1, 2, 1, projection="3d")
    turned = np.append(body.azimuth, 2.0 * np.pi)
    shown = np.maximum(np.concatenate([body.luminance, body.luminance[:, :1]], axis=1), 0.0)
    theta, phi = np.meshgrid(body.zenith, turned, indexing="ij")
    x, y = shown * np.sin(theta) * np.cos(phi), shown * np.sin(theta) * np.sin(phi)
    z = shown * np.cos(theta)
    largest = max(float(shown.max()), 1e-12)
    axes.plot_surface(
        x,
        y,
        z,
        facecolors=colormaps[COLOUR_MAP](Normalize(0.0, largest)(shown)),
        rcount=len(body.zenith),
        ccount=len(turned),
        shade=False,
    )
    reach = max(float(np.abs(x).max()), float(np.abs(y).max()), 0.5 * float(z.max()), 1e-12)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(0.0, 2.0 * reach))
    axes.set(xlabel="x of the node, cd/m²", ylabel="y, cd/m²", zlabel="along the normal, cd/m²")
    axes.set_box_aspect((1, 1, 1))


def _draw_cuts(figure: Figure, body: LuminanceBody) -> None:
    """Draw the half planes of the brightest azimuth and the opposite one as one curve, and those across."""
    axes: Any = figure.add_subplot(1, 2, 2, projection="polar")
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_thetalim(-np.pi / 2, np.pi / 2)
    count = len(body.azimuth)
    _, brightest = body.brightest
    for first, style, name in (
        (brightest, "-", "through the brightest"),
        (brightest + count // 4, "--", "across"),
    ):
        toward, away = body.luminance[:, first % count], body.luminance[:, (first + count // 2) % count]
        angle = np.concatenate([-body.zenith[::-1], body.zenith])
        label = f"{name}: {np.degrees(body.azimuth[first % count]):.0f}° on the right"
        axes.plot(angle, np.maximum(np.concatenate([away[::-1], toward]), 0.0), style, label=label)
    axes.set_rlim(0.0)
    axes.set_title("Luminance by angle from the normal, cd/m²", fontsize="medium")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False)
