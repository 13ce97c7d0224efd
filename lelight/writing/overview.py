"""Draws the overview in a process of its own: ``python -m lelight.writing.overview FIELD PNG``."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import vtkmodules.vtkRenderingFreeType
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (these two register what draws text and surfaces)
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTextProperty,
    vtkWindowToImageFilter,
)

from lelight.writing.polydata import PolyData, to_vtk
from lelight.writing.views import partly_seen, robust_range, shown_values
from lelight.writing.vtpreading import read_polydata

WINDOW = (1400, 1000)
#: Samples a pixel, which smooth edges.
SAMPLES = 4
#: The colour map viridis (Matplotlib, CC0) at even steps.
VIRIDIS = (
    (0.267, 0.005, 0.329), (0.282, 0.095, 0.417), (0.279, 0.175, 0.483), (0.259, 0.252, 0.525), (0.230, 0.322, 0.546),
    (0.199, 0.388, 0.555), (0.173, 0.449, 0.558), (0.149, 0.508, 0.557), (0.128, 0.567, 0.551), (0.121, 0.626, 0.533),
    (0.158, 0.684, 0.502), (0.246, 0.739, 0.452), (0.369, 0.789, 0.383), (0.516, 0.831, 0.294), (0.678, 0.864, 0.190),
    (0.846, 0.887, 0.100), (0.993, 0.906, 0.144),
)  # fmt: skip
COLOURS = 256

#: PR_SET_PDEATHSIG of prctl(2).
_SET_DEATH_SIGNAL = 1

#: From the scene to the eye: high enough to look over the near walls, turned off the axes.
_TOWARDS_EYE = np.array([-0.55, -1.0, 1.05])

TITLE = "Illuminance (lx)"


def draw(field_file: Path, path: Path) -> None:
    """Draw the field to a PNG.

    Faces are shown only from the side that their nodes stand for: near walls and the ceiling, seen from
    behind, are left out. The colours are those of the legend, without shading.
    """
    surface, limits = _surface(field_file)
    colours = _colours(limits)
    renderer = vtkRenderer()
    renderer.SetBackground(1.0, 1.0, 1.0)
    renderer.AddActor(_painted(surface, colours))
    renderer.AddViewProp(_legend(colours))
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*_TOWARDS_EYE)
    camera.SetFocalPoint(0.0, 0.0, 0.0)
    camera.SetViewUp(0.0, 0.0, 1.0)
    renderer.ResetCamera()
    _photograph(renderer, path)


def _surface(field_file: Path) -> tuple[PolyData, tuple[float, float]]:
    """Surface in lit scene space around the origin, where single precision is enough to draw, and range of colours."""
    content = read_polydata(field_file)
    corners, illuminance = content.point_arrays["corner_m"], content.point_arrays["illuminance_lx"]
    hidden = content.point_arrays["hidden"] != 0
    centre = (corners.min(axis=0) + corners.max(axis=0)) / 2
    seen = content.polygons[partly_seen(content.polygons, hidden)]
    shown = {"illuminance": shown_values(content.polygons, illuminance, hidden)}
    surface = PolyData(corners - centre, polygons=seen, point_arrays=shown)
    return surface, robust_range(illuminance, hidden)


def _colours(limits: tuple[float, float]) -> vtkLookupTable:
    """Colours of illuminances between two limits."""
    colours = vtkLookupTable()
    colours.SetNumberOfTableValues(COLOURS)
    colours.SetRange(*limits)
    steps = np.linspace(0.0, len(VIRIDIS) - 1.0, COLOURS)
    channels = [np.interp(steps, np.arange(len(VIRIDIS)), channel) for channel in zip(*VIRIDIS, strict=True)]
    for k, (red, green, blue) in enumerate(np.transpose(channels).tolist()):
        colours.SetTableValue(k, red, green, blue)
    return colours


def _painted(surface: PolyData, colours: vtkLookupTable) -> vtkActor:
    """Surface in its colours, seen from the front only."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(to_vtk(surface))
    mapper.SetLookupTable(colours)
    mapper.UseLookupTableScalarRangeOn()
    # Colours between nodes follow the illuminance, not the colours of the nodes.
    mapper.InterpolateScalarsBeforeMappingOn()
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    actor.GetProperty().BackfaceCullingOn()
    return actor


def _legend(colours: vtkLookupTable) -> vtkScalarBarActor:
    legend = vtkScalarBarActor()
    legend.SetLookupTable(colours)
    legend.SetTitle(TITLE)
    legend.SetLabelFormat("%.3g")
    legend.SetNumberOfLabels(5)
    legend.SetMaximumNumberOfColors(COLOURS)
    legend.SetPosition(0.87, 0.2)
    legend.SetHeight(0.6)
    legend.SetWidth(0.1)
    legend.SetVerticalTitleSeparation(12)
    legend.UnconstrainedFontSizeOn()
    _write_in(legend.GetTitleTextProperty(), 26)
    _write_in(legend.GetLabelTextProperty(), 22)
    return legend


def _write_in(text: vtkTextProperty, size: int) -> None:
    text.SetColor(0.0, 0.0, 0.0)
    text.SetFontSize(size)
    text.BoldOff()
    text.ItalicOff()
    text.ShadowOff()


def _photograph(renderer: vtkRenderer, path: Path) -> None:
    """Render off screen and write a PNG."""
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(SAMPLES)
    window.SetSize(*WINDOW)
    window.AddRenderer(renderer)
    window.Render()
    picture = vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetInputConnection(picture.GetOutputPort())
    writer.Write()


def end_with_parent() -> None:
    """Have this process killed when the one that waits for the picture ends, where the system is Linux."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() == 1:
        sys.exit(1)


if __name__ == "__main__":
    end_with_parent()
    draw(Path(sys.argv[1]), Path(sys.argv[2]))
