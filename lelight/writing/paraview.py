"""``paraview.py``: a script that opens a result folder in ParaView with ranges and titles set."""

from __future__ import annotations

import os
import pprint
from collections.abc import Mapping
from pathlib import Path

from lelight.writing.files import write_text

# Names come in as Python literals in SETTINGS only, never as code.
_SCRIPT = '''\
"""Open this folder in ParaView:  paraview --script=paraview.py  or  pvpython paraview.py [PICTURE.png]

With the name of a picture the view is also saved; a ParaView that is built for X needs a display for that
(without one: xvfb-run pvpython paraview.py PICTURE.png).
"""

import os
import sys

try:
    HERE = os.path.dirname(os.path.realpath(__file__))
except NameError:  # pasted into ParaView's Python shell
    HERE = os.getcwd()

# This script has the name of the module that it needs: keep its folder out of the search.
sys.path[:] = [folder for folder in sys.path if os.path.realpath(folder or ".") != HERE]

from paraview import simple

SETTINGS = @SETTINGS@


def opened(reference, name):
    """Reader of a file beside this script, shown in the pipeline under a name."""
    path = os.path.join(HERE, *reference.split("/"))
    return simple.XMLPolyDataReader(registrationName=name, FileName=[path])


def colour_by_illuminance(display):
    """Colour as all the others; the range is the field's."""
    simple.ColorBy(display, ("POINTS", "illuminance_lx"))


def show_field(view):
    """Surfaces without hidden nodes, each from its own side only, so that one looks into the room."""
    field = opened(SETTINGS["field"], "field")
    visible = simple.Threshold(registrationName="field, visible nodes", Input=field)
    visible.Scalars = ["POINTS", "hidden"]
    visible.LowerThreshold = visible.UpperThreshold = 0.0
    visible.ThresholdMethod = "Between"
    display = simple.Show(visible, view)
    display.BackfaceRepresentation = "Cull Backface"
    display.Ambient, display.Diffuse = 1.0, 0.0
    colour_by_illuminance(display)


def show_planes(view):
    """Measuring planes in the colours of the field."""
    for name, reference in SETTINGS["planes"].items():
        display = simple.Show(opened(reference, name), view)
        display.Ambient, display.Diffuse = 1.0, 0.0
        colour_by_illuminance(display)


def show_marks(view):
    """Luminaires as points, observers as arrows."""
    marks = (("luminaires", [1.0, 0.6, 0.0]), ("observers", [0.8, 0.0, 0.5]))
    for name, colour in marks:
        if SETTINGS[name] is None:
            continue
        display = simple.Show(opened(SETTINGS[name], name), view)
        display.ColorArrayName = ["POINTS", ""]
        display.AmbientColor = display.DiffuseColor = colour
        display.PointSize, display.LineWidth = 12.0, 3.0


def show_legend(view):
    """One scale for all: 5th to 95th percentile of the visible nodes."""
    colours = simple.GetColorTransferFunction("illuminance_lx")
    colours.ApplyPreset("Viridis (matplotlib)", True)
    colours.RescaleTransferFunction(*SETTINGS["range"])
    colours.AutomaticRescaleRangeMode = "Never"
    legend = simple.GetScalarBar(colours, view)
    legend.Title, legend.ComponentTitle = SETTINGS["legend"], ""
    legend.HorizontalTitle, legend.RangeLabelFormat = 1, "%.3g"
    legend.TitleFontSize, legend.LabelFontSize = 14, 12
    legend.TitleColor = legend.LabelColor = [0.0, 0.0, 0.0]
    legend.Visibility = 1


def show_title(view):
    """What the scene is called, above the picture."""
    title = simple.Text(registrationName="title", Text=SETTINGS["title"])
    display = simple.Show(title, view)
    display.WindowLocation, display.FontSize = "Upper Center", 14
    display.Color = [0.0, 0.0, 0.0]


def look_from_above(view):
    """An oblique view over the near walls, z up."""
    view.CameraFocalPoint = [0.0, 0.0, 0.0]
    view.CameraPosition = [-0.55, -1.0, 1.05]
    view.CameraViewUp = [0.0, 0.0, 1.0]
    view.ResetCamera()


def main(pictures):
    """Show everything, and save the view to the pictures that are named."""
    view = simple.GetActiveViewOrCreate("RenderView")
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    show_field(view)
    show_planes(view)
    show_legend(view)
    show_marks(view)
    show_title(view)
    look_from_above(view)
    for picture in pictures:
        view.ViewSize = [1400, 1000]
        simple.SaveScreenshot(picture, view, ImageResolution=view.ViewSize)


main([name for name in sys.argv[1:2] if name.lower().endswith(".png")])
'''


def write_paraview_script(
    path: Path,
    *,
    title: str,
    field: Path,
    illuminance_range: tuple[float, float],
    planes: Mapping[str, Path] | None = None,
    luminaires: Path | None = None,
    observers: Path | None = None,
) -> None:
    """Write a script that shows the files given, which it finds from its own place.

    Parameters
    ----------
    title : shown above the picture
    field, planes by name, luminaires, observers : the ``.vtp`` files; those that are None are left out
    illuminance_range : ends of the colour scale in lx, see `robust_range` in `lelight.writing.views`
    """
    settings = {
        "title": title,
        "legend": "Illuminance (lx)",
        "range": [float(limit) for limit in illuminance_range],
        "field": _reference(field, path),
        "planes": {name: _reference(plane, path) for name, plane in (planes or {}).items()},
        "luminaires": None if luminaires is None else _reference(luminaires, path),
        "observers": None if observers is None else _reference(observers, path),
    }
    write_text(path, _SCRIPT.replace("@SETTINGS@", pprint.pformat(settings, width=100, sort_dicts=False)))


def _reference(file: Path, script: Path) -> str:
    return Path(os.path.relpath(file, script.parent)).as_posix()
