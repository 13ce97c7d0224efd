"""Draws the overview in a process of its own: ``python -m lelight.writing.overview FIELD PNG``."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyvista

from lelight.writing.views import partly_seen, robust_range, shown_values
from lelight.writing.vtpreading import read_polydata

WINDOW = (1400, 1000)

#: PR_SET_PDEATHSIG of prctl(2).
_SET_DEATH_SIGNAL = 1

#: From the scene to the eye: high enough to look over the near walls, turned off the axes.
_TOWARDS_EYE = np.array([-0.55, -1.0, 1.05])

_LEGEND = {
    "title": "Illuminance (lx)",
    "vertical": True,
    "color": "black",
    "title_font_size": 26,
    "label_font_size": 22,
    "fmt": "%.3g",
    "position_x": 0.87,
    "position_y": 0.2,
    "height": 0.6,
    "width": 0.1,
}


def draw(field_file: Path, path: Path) -> None:
    """Draw the field to a PNG.

    Faces are shown only from the side that their nodes stand for: near walls and the ceiling, seen from
    behind, are left out. The colours are those of the legend, without shading.
    """
    plotter = pyvista.Plotter(off_screen=True, window_size=WINDOW)
    plotter.set_background("white")
    surface = _surface(field_file)
    plotter.add_mesh(
        surface,
        scalars="illuminance",
        cmap="viridis",
        clim=surface.field_data["range"],
        culling="back",
        lighting=False,
        scalar_bar_args=_LEGEND,
    )
    plotter.scalar_bar.SetVerticalTitleSeparation(12)
    plotter.camera_position = [_TOWARDS_EYE.tolist(), [0, 0, 0], [0, 0, 1]]
    plotter.reset_camera()
    plotter.screenshot(path)


def _surface(field_file: Path) -> pyvista.PolyData:
    """Surface in lit scene space around the origin, where single precision is enough to draw."""
    content = read_polydata(field_file)
    corners, illuminance = content.point_arrays["corner_m"], content.point_arrays["illuminance_lx"]
    hidden = content.point_arrays["hidden"] != 0
    centre = (corners.min(axis=0) + corners.max(axis=0)) / 2
    seen = content.polygons[partly_seen(content.polygons, hidden)]
    surface = pyvista.PolyData.from_regular_faces(corners - centre, seen)
    surface["illuminance"] = shown_values(content.polygons, illuminance, hidden)
    surface.field_data["range"] = robust_range(illuminance, hidden)
    return surface


def end_with_parent() -> None:
    """Have this process killed when the one that waits for the picture ends, where the system is Linux."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() == 1:
        sys.exit(1)


if __name__ == "__main__":
    end_with_parent()
    draw(Path(sys.argv[1]), Path(sys.argv[2]))
