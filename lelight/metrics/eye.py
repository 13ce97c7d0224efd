"""Light at an eye and further ratings of its picture, beside the glare ratings of `lelight.metrics.glare`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lelight.metrics.daylight_glare import RATINGS, View
from lelight.metrics.figure import Figure, measured, ratio
from lelight.metrics.glare import CARRIED, WHOLE, picture_method
from lelight.metrics.picture import PictureGlare
from lelight.metrics.spatial import altitude, hemispherical, moment_parts, semicylindrical, symmetric_scalar
from lelight.results import ObserverValues
from lelight.scene import FloatArray

_Function = Callable[[FloatArray], float]
#: A standard error below this share of its value is what is left of rounding.
ROUNDING = 1e-12


def eye_figures(values: ObserverValues) -> dict[str, Figure]:
    """Spatial illuminances at an eye, its four vertical illuminances, and their ratios."""
    if values.moment_replicates is None:
        return {}
    facing = _facing(values.observer.direction)
    rules: dict[str, tuple[str, str, _Function]] = {
        "light_vector_up": (
            "lx",
            "upward component of the light vector",
            lambda m: float(_vector(m)[2]),
        ),
        "scalar_illuminance": ("lx", "1/4 of the integral of luminance", lambda m: float(moment_parts(m)[0])),
        "cylindrical_illuminance": ("lx", "mean over vertical planes", lambda m: float(moment_parts(m)[2])),
        "hemispherical_illuminance": ("lx", "E_sr + E_up / 4, axis up", _hemispherical),
        "light_vector": ("lx", "length of the light vector", lambda m: float(np.linalg.norm(_vector(m)))),
        "vector_altitude": ("°", "angle of the light vector to the horizon", lambda m: altitude(_vector(m))),
        "vector_over_scalar": ("1", "|light vector| / scalar illuminance", _vector_over_scalar),
        "symmetric_scalar_illuminance": ("lx", "E_sr - |E| / 4", _symmetric),
    }
    if facing is not None:
        rules["semicylindrical_illuminance"] = (
            "lx",
            "E_z + E · f / π, facing the line of sight",
            lambda m: float(semicylindrical(moment_parts(m)[2], _vector(m), facing)),
        )
    found = {
        name: measured(function, values.moment_replicates, unit=unit, method=method)
        for name, (unit, method, function) in rules.items()
    }
    return found | _turned(values)


def _turned(values: ObserverValues) -> dict[str, Figure]:
    """Illuminance across lines of sight turned by quarters."""
    if values.turned_total is None:
        return {}
    return {
        f"vertical_illuminance_{name}": measured(
            float,
            values.turned_total[:, 6 * quarter],
            unit="lx",
            method=f"line of sight turned {90 * quarter}° left",
        )
        for quarter, name in ((1, "left"), (2, "back"), (3, "right"))
    }


def _vector(moments: FloatArray) -> FloatArray:
    return moment_parts(moments)[1]


def _hemispherical(moments: FloatArray) -> float:
    scalar, vector, _ = moment_parts(moments)
    return float(hemispherical(scalar, vector))


def _symmetric(moments: FloatArray) -> float:
    scalar, vector, _ = moment_parts(moments)
    return float(symmetric_scalar(scalar, vector))


def _vector_over_scalar(moments: FloatArray) -> float:
    scalar, vector, _ = moment_parts(moments)
    return ratio(float(np.linalg.norm(vector)), float(scalar))


def _facing(direction: FloatArray) -> FloatArray | None:
    """Horizontal unit vector (3,) of a line of sight; None where it is upright."""
    level = np.array([direction[0], direction[1], 0.0])
    length = float(np.linalg.norm(level))
    return level / length if length > 1e-9 else None


def further_picture_figures(picture: PictureGlare, indirect: FloatArray) -> dict[str, Figure]:
    """DGI, CGI, VCP, UGP and veils of a picture, always the same names."""
    method = picture_method(picture)
    if picture.covered < WHOLE:
        note = f"not defined: the picture holds {100 * picture.covered:.0f} % of the view hemisphere"
        return {name: Figure(None, unit, None, method, note=note) for name, unit, _, _ in RATINGS}
    return {
        name: carried(function, picture.view, indirect, unit=unit, method=method, clause=clause)
        for name, unit, function, clause in RATINGS
    }


def carried(
    function: Callable[[View], float],
    view: View,
    indirect: FloatArray,
    *,
    unit: str,
    method: str,
    clause: str,
    note: str = "",
) -> Figure:
    """Figure of a picture whose error is that of the indirect light: all but the sources moves with it.

    Parameters
    ----------
    indirect : (R,) float, lx, by batch

    Returns
    -------
    figure : without an error where the indirect light is no part of it, as in a veil made by the sources
    """
    mean = float(indirect.mean())
    if not mean > 0:
        value = function(view)
        shown = value if np.isfinite(value) else None
        return Figure(shown, unit, None, method, clause=clause, note=note)
    figure = measured(
        lambda share: function(view.with_background(float(share))) if share != 1 else function(view),
        indirect / mean,
        unit=unit,
        method=method + CARRIED,
        clause=clause,
        undefined="not defined: no glare source, or no light beside it, in the picture",
        note=note,
    )
    if figure.value is not None and (figure.std_error or 0.0) <= ROUNDING * abs(figure.value):
        # Made of the sources alone: what the indirect light is not sure of says nothing about it.
        return replace(figure, std_error=None, interval=None, method=method)
    return figure
