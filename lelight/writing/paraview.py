"""``paraview.py``: a script that opens a result folder in ParaView with ranges and titles set."""

from __future__ import annotations

import os
import pprint
from collections.abc import Mapping, Sequence
from pathlib import Path

from lelight.channels import channel_suffixes, luminance_weights
from lelight.scene import Observer
from lelight.writing.files import write_text

# What ParaView's own Python runs for every node; it has NumPy and nothing of lelight.
_LUMINANCE = '''\
LUMINANCE = """
import numpy as np


def radiance(coefficients, x, y, z):
    # Sum of real orthonormal harmonics, index l*l + l + m, at one unit direction a node.
    degree = int(round(coefficients.shape[1] ** 0.5)) - 1
    total = np.zeros(len(z))
    cosine, sine, sectoral = np.ones(len(z)), np.zeros(len(z)), (4 * np.pi) ** -0.5
    for m in range(degree + 1):
        if m > 0:
            cosine, sine = x * cosine - y * sine, x * sine + y * cosine
            sectoral *= ((2 * m + 1) / (2 * m)) ** 0.5 * (2 ** 0.5 if m == 1 else 1.0)
        behind, here = np.zeros(len(z)), np.full(len(z), sectoral)
        for l in range(m, degree + 1):
            centre = l * l + l
            total += here * cosine * coefficients[:, centre + m]
            if m > 0:
                total += here * sine * coefficients[:, centre - m]
            ahead = ((4 * (l + 1) ** 2 - 1) / ((l + 1) ** 2 - m * m)) ** 0.5
            back = ahead * ((l * l - m * m) / (4 * l * l - 1.0)) ** 0.5
            behind, here = here, ahead * z * here - back * behind
    return total


def add_luminance(source, output, place, channels):
    # Of nodes that look away from the place it is 0.
    arrays = {name: np.asarray(source.PointData[name]) for name in ("normal", "frame_x", "luminance_cd_m2")}
    normal, frame_x = arrays["normal"], arrays["frame_x"]
    away = np.asarray(place) - np.asarray(source.Points)
    away /= np.maximum(np.linalg.norm(away, axis=1), 1e-30)[:, None]
    x, y, z = (np.sum(away * axis, axis=1) for axis in (frame_x, np.cross(normal, frame_x), normal))
    nothing, one = np.zeros(len(z)), np.ones(len(z))
    total = arrays["luminance_cd_m2"].astype(float)  # along the normal: emission is in it
    for name, weight in channels.items():
        own = np.asarray(source.PointData[name], dtype=float).reshape(len(z), -1)
        total += weight * (radiance(own, x, y, z) - radiance(own, nothing, nothing, one))
    output.PointData.append(np.where(z > 0, total, 0.0), "luminance_toward_eye_cd_m2")


"""'''

# Names come in as Python literals in SETTINGS only, never as code.
_SCRIPT = '''\
"""Open this folder in ParaView:  paraview --script=paraview.py  or  pvpython paraview.py [PICTURE.png] [--eye WHO]

Colours are illuminances, or with EYE below, or --eye, luminances toward an observer: reflected light and emission,
without the images that glossy surfaces show of the emitters. WHO is the name of an observer, or X,Y,Z in m.

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

#: None, the name of an observer, or a place [x, y, z] in m.
EYE = None

SETTINGS = @SETTINGS@


def opened(reference, name):
    """Reader of a file beside this script, shown in the pipeline under a name."""
    path = os.path.join(HERE, *reference.split("/"))
    return simple.XMLPolyDataReader(registrationName=name, FileName=[path])


@LUMINANCE@


def eye():
    """Place (3,) in m toward which luminances are wanted; None for illuminances."""
    asked = sys.argv[sys.argv.index("--eye") + 1] if "--eye" in sys.argv[:-1] else EYE
    if isinstance(asked, str) and asked not in SETTINGS["eyes"]:
        asked = [float(number) for number in asked.split(",")]
    return SETTINGS["eyes"][asked] if isinstance(asked, str) else asked


def with_luminance(field, place):
    """The field, and at its nodes the luminance toward a place."""
    toward = simple.ProgrammableFilter(registrationName="field, luminance", Input=field)
    toward.CopyArrays = 1
    call = f"add_luminance(inputs[0], output, {list(place)!r}, {SETTINGS['channels']!r})"
    toward.Script = LUMINANCE + call
    return toward


def quantity():
    """Name of the array that gives the colours."""
    return "illuminance_lx" if eye() is None else "luminance_toward_eye_cd_m2"


def colour(display):
    """Colour as all the others; the range is the field's."""
    simple.ColorBy(display, ("POINTS", quantity()))


def show_field(view):
    """Surfaces without hidden nodes, each from its own side only, so that one looks into the room."""
    field = opened(SETTINGS["field"], "field")
    if eye() is not None:
        field = with_luminance(field, eye())
    visible = simple.Threshold(registrationName="field, visible nodes", Input=field)
    visible.Scalars = ["POINTS", "hidden"]
    visible.LowerThreshold = visible.UpperThreshold = 0.0
    visible.ThresholdMethod = "Between"
    display = simple.Show(visible, view)
    display.BackfaceRepresentation = "Cull Backface"
    display.Ambient, display.Diffuse = 1.0, 0.0
    colour(display)


def show_planes(view):
    """Measuring planes in the colours of the field, which they have for illuminances."""
    if eye() is not None:
        return
    for name, reference in SETTINGS["planes"].items():
        display = simple.Show(opened(reference, name), view)
        display.Ambient, display.Diffuse = 1.0, 0.0
        colour(display)


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
    """One scale for all: 5th to 95th percentile of the visible nodes; for luminances from nothing to the largest."""
    colours = simple.GetColorTransferFunction(quantity())
    colours.ApplyPreset("Viridis (matplotlib)", True)
    if eye() is None:
        colours.RescaleTransferFunction(*SETTINGS["range"])
    colours.AutomaticRescaleRangeMode = "Never"
    legend = simple.GetScalarBar(colours, view)
    legend.Title, legend.ComponentTitle = SETTINGS["legend"], ""
    if eye() is not None:
        legend.Title = "Luminance toward the eye (cd/m²)"
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


main([name for name in sys.argv[1:] if name.lower().endswith(".png")][:1])
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
    eyes: Sequence[Observer] = (),
    channels: int = 1,
) -> None:
    """Write a script that shows the files given, which it finds from its own place.

    Parameters
    ----------
    title : shown above the picture
    field, planes by name, luminaires, observers : the ``.vtp`` files; those that are None are left out
    eyes : observers toward whom the script can colour by luminance
    channels : int, of the field
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
        "eyes": {eye.name: eye.position.tolist() for eye in eyes},
        "channels": dict(
            zip(
                [f"radiance_sh{suffix}" for suffix in channel_suffixes(channels)],
                luminance_weights(channels).tolist(),
                strict=True,
            )
        ),
    }
    script = _SCRIPT.replace("@LUMINANCE@", _LUMINANCE)
    write_text(path, script.replace("@SETTINGS@", pprint.pformat(settings, width=100, sort_dicts=False)))


def _reference(file: Path, script: Path) -> str:
    return Path(os.path.relpath(file, script.parent)).as_posix()
