"""Figures of a measuring plane after EN 12464-1.

The standard's clauses are named, not numbered: they are not verified against its text.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lelight.metrics.figure import Figure, measured, ratio
from lelight.results import PlaneValues
from lelight.scene import FloatArray

#: Normals this close to +z make a plane horizontal (cosine; 2.6 degrees).
_HORIZONTAL = 0.999


@dataclass(frozen=True)
class _Rule:
    """How a figure follows from (2, k): illuminance and cylindrical illuminance (lx) at k points."""

    name: str
    unit: str
    method: str
    clause: str
    function: Callable[[FloatArray], float]


_MAINTAINED = "EN 12464-1, maintained illuminance"
_UNIFORMITY = "EN 12464-1, illuminance uniformity"
_CYLINDRICAL = "EN 12464-1, mean cylindrical illuminance"

_RULES = (
    _Rule("mean_illuminance", "lx", "mean over the grid", _MAINTAINED, lambda e: float(e[0].mean())),
    _Rule("min_illuminance", "lx", "least of the grid", _UNIFORMITY, lambda e: float(e[0].min())),
    _Rule("max_illuminance", "lx", "greatest of the grid", _UNIFORMITY, lambda e: float(e[0].max())),
    _Rule("uniformity", "1", "U0 = Emin / Em", _UNIFORMITY, lambda e: ratio(e[0].min(), e[0].mean())),
    _Rule("diversity", "1", "Ud = Emin / Emax", "CIE, diversity", lambda e: ratio(e[0].min(), e[0].max())),
    _Rule(
        "mean_cylindrical_illuminance", "lx", "mean over the grid", _CYLINDRICAL, lambda e: float(e[1].mean())
    ),
)
_MODELLING = _Rule(
    "modelling",
    "1",
    "mean Ez / mean Eh over the grid",
    "EN 12464-1, modelling",
    lambda e: ratio(e[1].mean(), e[0].mean()),
)
#: What a plane's target can ask for, each as a least value.
REQUIREMENTS = ("mean_illuminance", "uniformity")


def plane_figures(values: PlaneValues) -> dict[str, Figure]:
    """Rate a measuring plane: Em, Emin, Emax, U0, Ud, Ez and modelling, against the plane's target.

    Returns
    -------
    Figures by name, always the same names in the same order; the error is the jackknife's over the batches
    """
    batches = _batches(values)
    figures = {rule.name: _figure(rule, batches, values.plane.target) for rule in _RULES}
    if values.plane.normal[2] < _HORIZONTAL:
        note = "not defined: the plane does not face up"
        modelling = Figure(None, "1", None, _MODELLING.method, clause=_MODELLING.clause, note=note)
    else:
        modelling = _figure(_MODELLING, batches, {})
    return figures | {"modelling": modelling}


def _figure(rule: _Rule, batches: FloatArray, target: dict[str, float]) -> Figure:
    return measured(
        rule.function,
        batches,
        unit=rule.unit,
        method=rule.method,
        clause=rule.clause,
        target=target.get(rule.name) if rule.name in REQUIREMENTS else None,
        undefined="not defined: no light reaches the plane",
    )


def _batches(values: PlaneValues) -> FloatArray:
    """(R, 2, k) float, lx: illuminance and cylindrical illuminance by batch."""
    batches = np.stack([values.replicates, values.cylindrical_replicates], axis=1)
    if not np.all(np.isfinite(batches)):
        raise ValueError(f"replicates of plane {values.plane.name!r} must be finite")
    return batches
