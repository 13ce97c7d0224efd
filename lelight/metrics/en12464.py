"""Figures of a measuring plane after EN 12464-1.

The standard's clauses are named, not numbered: they are not verified against its text. Limits for the
surrounding, for Ez and for the modelling index are from memory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lelight.metrics.areas import BACKGROUND_UNIFORMITY, SURROUNDING_UNIFORMITY, required_illuminance
from lelight.metrics.extremes import (
    CROSS_FITTED,
    counted,
    greatest,
    least,
    least_over_greatest,
    least_over_mean,
)
from lelight.metrics.figure import Figure, from_replicates, ratio, stated
from lelight.metrics.spatial import hemispherical, moment_parts, semicylindrical
from lelight.results import PlaneValues
from lelight.scene import FloatArray

#: Normals this close to +z make a plane horizontal (cosine; 2.6 degrees).
_HORIZONTAL = 0.999
#: Bearings of the vertical faces, as the replicates hold them.
_BEARINGS = ("x", "y", "minus_x", "minus_y")
_AXES: FloatArray = np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0]])

#: Value and standard error from replicates (R, ...).
_Estimate = Callable[[FloatArray], tuple[float, float | None]]


@dataclass(frozen=True)
class _Rule:
    """How a figure follows from replicates (R, k, ...) at k points."""

    name: str
    unit: str
    method: str
    clause: str
    estimate: _Estimate
    #: Fewer degrees of freedom than batches less one: the extremes' are halved.
    halved: bool = False


_MAINTAINED = "EN 12464-1, maintained illuminance"
_UNIFORMITY = "EN 12464-1, illuminance uniformity"
_CYLINDRICAL = "EN 12464-1, mean cylindrical illuminance"


def _mean(batches: FloatArray) -> tuple[float, float | None]:
    return from_replicates(lambda e: float(e.mean()), batches)


def _quotient(batches: FloatArray) -> tuple[float, float | None]:
    """Ratio of means of (R, 2, k)."""
    return from_replicates(lambda e: ratio(e[0].mean(), e[1].mean()), batches)


_RULES = (
    _Rule("mean_illuminance", "lx", "mean over the grid", _MAINTAINED, _mean),
    _Rule("min_illuminance", "lx", f"least of the grid; {CROSS_FITTED}", _UNIFORMITY, least, True),
    _Rule("max_illuminance", "lx", f"greatest of the grid; {CROSS_FITTED}", _UNIFORMITY, greatest, True),
    _Rule("uniformity", "1", f"U0 = Emin / Em; {CROSS_FITTED}", _UNIFORMITY, least_over_mean, True),
    _Rule("diversity", "1", f"Ud = Emin / Emax; {CROSS_FITTED}", "CIE, diversity", least_over_greatest, True),
)
_EZ = _Rule("mean_cylindrical_illuminance", "lx", "mean over the grid", _CYLINDRICAL, _mean)
_EZ_UNIFORMITY = _Rule(
    "cylindrical_uniformity", "1", f"least Ez / mean Ez; {CROSS_FITTED}", _CYLINDRICAL, least_over_mean, True
)
_MODELLING = _Rule("modelling", "1", "mean Ez / mean Eh over the grid", "EN 12464-1, modelling", _quotient)
#: What a plane's target can ask for, each as a least value.
REQUIREMENTS = (
    "mean_illuminance",
    "uniformity",
    "mean_cylindrical_illuminance",
    "cylindrical_uniformity",
)


def plane_figures(values: PlaneValues) -> dict[str, Figure]:
    """Rate a measuring plane: Em, Emin, Emax, U0, Ud, Ez, modelling, and the light in space over it.

    Returns
    -------
    Figures by name; means have the jackknife's error, extremes that of cross-fitted readings
    """
    _require_finite(values)
    target = values.plane.target
    figures = {rule.name: _figure(rule, values.replicates, target) for rule in _RULES}
    figures["mean_cylindrical_illuminance"] = _figure(_EZ, values.cylindrical_replicates, target)
    figures["modelling"] = _modelling(values)
    return figures | _spatial(values) | _vertical(values) | _areas(values)


def _modelling(values: PlaneValues) -> Figure:
    if values.plane.normal[2] < _HORIZONTAL:
        note = "not defined: the plane does not face up"
        return Figure(None, "1", None, _MODELLING.method, clause=_MODELLING.clause, note=note)
    return _figure(_MODELLING, np.stack([values.cylindrical_replicates, values.replicates], axis=1), {})


def _spatial(values: PlaneValues) -> dict[str, Figure]:
    """Scalar, hemispherical and semicylindrical illuminance and the light vector, as means over the grid."""
    if values.moment_replicates is None:
        return {}
    scalar, vector, tube = moment_parts(values.moment_replicates)
    faces = {
        f"mean_semicylindrical_{name}": semicylindrical(tube, vector, axis)
        for name, axis in zip(_BEARINGS, _AXES, strict=True)
    }
    fields = {
        "mean_scalar_illuminance": scalar,
        "mean_hemispherical_illuminance": hemispherical(scalar, vector),
        **faces,
    }
    found = {name: _figure(_mean_rule(name), field, {}) for name, field in fields.items()}
    strength = np.stack([np.linalg.norm(vector.mean(axis=1), axis=-1), scalar.mean(axis=1)], axis=1)
    rule = _Rule(
        "vector_over_scalar",
        "1",
        "|mean light vector| / mean scalar illuminance",
        "Cuttle 2003 (scale from memory)",
        lambda _: _vector_over_scalar(vector.mean(axis=1), scalar.mean(axis=1)),
    )
    tubes = {_EZ_UNIFORMITY.name: _figure(_EZ_UNIFORMITY, tube, values.plane.target)}
    return tubes | found | {rule.name: _figure(rule, strength, {})}


def _vector_over_scalar(vectors: FloatArray, scalars: FloatArray) -> tuple[float, float | None]:
    """|E| / E_sr from batches (R, 3) and (R,); the length is taken of the mean vector."""
    together = np.concatenate([vectors, scalars[:, None]], axis=1)
    return from_replicates(lambda e: ratio(float(np.linalg.norm(e[:3])), float(e[3])), together)


def _vertical(values: PlaneValues) -> dict[str, Figure]:
    if values.vertical_replicates is None:
        return {}
    return {
        f"mean_vertical_{name}": _figure(
            _mean_rule(f"mean_vertical_{name}"), values.vertical_replicates[..., k], {}
        )
        for k, name in enumerate(_BEARINGS)
    }


def _mean_rule(name: str) -> _Rule:
    return _Rule(name, "lx", "mean over the grid", "", _mean)


def _areas(values: PlaneValues) -> dict[str, Figure]:
    """Mean and uniformity of the surrounding and the background, against what the task's target implies."""
    figures: dict[str, Figure] = {}
    task = values.plane.target.get("mean_illuminance")
    uniformities = {"surrounding": SURROUNDING_UNIFORMITY, "background": BACKGROUND_UNIFORMITY}
    for kind, batches in values.area_replicates.items():
        clause = f"EN 12464-1, {kind} area (ratios from memory)"
        mean = _Rule(f"{kind}_mean_illuminance", "lx", "mean over the cells of the band", clause, _mean)
        uniformity = _Rule(
            f"{kind}_uniformity", "1", f"Emin / Em; {CROSS_FITTED}", clause, least_over_mean, True
        )
        needed: dict[str, float] = {}
        if task is not None:
            needed[mean.name] = required_illuminance(
                task, "surrounding" if kind == "surrounding" else "background"
            )
            needed[uniformity.name] = uniformities[kind]
        for rule in (mean, uniformity):
            figures[rule.name] = _area_figure(rule, batches, needed)
    return figures


def _area_figure(rule: _Rule, batches: FloatArray, target: dict[str, float]) -> Figure:
    if batches.shape[1] == 0:
        note = "not defined: no point of the band is seen from the task area"
        return Figure(None, rule.unit, None, rule.method, clause=rule.clause, note=note)
    return _figure(rule, batches, target, allowed=tuple(target))


def _figure(
    rule: _Rule,
    batches: FloatArray,
    target: dict[str, float],
    *,
    allowed: tuple[str, ...] = REQUIREMENTS,
) -> Figure:
    value, std_error = rule.estimate(batches)
    return stated(
        value,
        std_error,
        batches=counted(len(batches)) if rule.halved else len(batches),
        unit=rule.unit,
        method=rule.method,
        clause=rule.clause,
        target=target.get(rule.name) if rule.name in allowed else None,
        undefined="not defined: no light reaches the plane",
    )


def _require_finite(values: PlaneValues) -> None:
    for batches in (values.replicates, values.cylindrical_replicates):
        if not np.all(np.isfinite(batches)):
            raise ValueError(f"replicates of plane {values.plane.name!r} must be finite")
