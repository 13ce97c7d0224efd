"""Luminance of task, surround and background in a picture, and their ratios against 10 : 3 : 1.

Task, surround and background are cones of 10, 30 (ergorama) and 60 degrees (panorama) around the task; the
angles and the ratios are from memory, not verified.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.metrics.figure import Figure
from lelight.scene import BoolArray, FloatArray, Observer, Threshold

#: Half angles in degrees where the zones end.
ZONES = {"task": 10.0, "surround": 30.0, "background": 60.0}
#: Largest luminance of the task over that of a zone.
LARGEST_RATIO = {"surround": 3.0, "background": 10.0}
PERCENTILES = (5, 25, 50, 75, 95)


def task_direction(observer: Observer) -> FloatArray:
    """Find the unit direction (3,) to what an eye works on; its line of sight where no task is given."""
    towards = observer.direction if observer.task is None else observer.task - observer.position
    return np.asarray(towards / np.linalg.norm(towards))


def zone_masks(directions: FloatArray, solid_angles: FloatArray, observer: Observer) -> dict[str, BoolArray]:
    """Pixels (h, w) of each zone; a zone leaves out those inside it."""
    cosine = np.where(solid_angles > 0, directions @ task_direction(observer), -1.0)
    masks, inner = {}, np.inf
    for name, half_angle in ZONES.items():
        outer = math.cos(math.radians(half_angle))
        masks[name] = (cosine >= outer) & (cosine < inner) & (solid_angles > 0)
        inner = outer
    return masks


def weighted_percentile(values: FloatArray, weights: FloatArray, percent: float) -> float:
    """Value below which ``percent`` of the weight lies."""
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order[min(int(np.searchsorted(share, percent / 100 * share[-1])), len(order) - 1)]])


def zone_statistics(
    luminance: FloatArray, solid_angles: FloatArray, directions: FloatArray, observer: Observer
) -> dict[str, dict[str, float]]:
    """Mean, percentiles, least and largest luminance (cd/m²) of each zone that the picture shows."""
    found = {}
    for name, mask in zone_masks(directions, solid_angles, observer).items():
        if mask.any():
            found[name] = statistics(luminance[mask], solid_angles[mask])
    return found


def statistics(luminance: FloatArray, solid_angles: FloatArray) -> dict[str, float]:
    """Statistics of pixels (n,) by solid angle, cd/m²; ``median`` is the 50th percentile."""
    percentiles = {f"p{p}": weighted_percentile(luminance, solid_angles, p) for p in PERCENTILES}
    return {
        "mean": float(np.average(luminance, weights=solid_angles)),
        "median": percentiles["p50"],
        **percentiles,
        "min": float(luminance.min()),
        "max": float(luminance.max()),
        "solid_angle": float(solid_angles.sum()),
    }


def threshold_luminance(
    threshold: Threshold,
    luminance: FloatArray,
    solid_angles: FloatArray,
    directions: FloatArray,
    observer: Observer,
) -> float:
    """Luminance (cd/m²) above which a pixel is a glare source: absolute, or a multiple of a mean."""
    if threshold.kind == "absolute":
        return threshold.luminance
    zones = zone_masks(directions, solid_angles, observer) | {"picture": solid_angles > 0}
    chosen = zones[threshold.kind]
    mean = float(np.average(luminance[chosen], weights=solid_angles[chosen])) if chosen.any() else 0.0
    return threshold.luminance * mean


def zone_figures(statistics_of: dict[str, dict[str, float]]) -> dict[str, Figure]:
    """Mean luminance of each zone, and the ratios of task to surround and background."""
    method = "mean by solid angle in the picture"
    figures = {
        f"luminance_{name}": Figure(numbers["mean"], "cd/m²", None, f"{method}, {_zone(name)}")
        for name, numbers in statistics_of.items()
        if name in ZONES
    }
    for name, largest in LARGEST_RATIO.items():
        figures |= _ratio(statistics_of, name, largest)
    return figures


def _ratio(statistics_of: dict[str, dict[str, float]], name: str, largest: float) -> dict[str, Figure]:
    task, zone = (statistics_of.get(each, {}).get("mean", 0.0) for each in ("task", name))
    if not (task > 0 and zone > 0):
        return {}
    quotient = task / zone
    inside = 1 / largest <= quotient <= largest
    note = f"{'within' if inside else 'outside'} {largest:g}:1 either way"
    clause = "10:3:1 (from memory)"
    return {
        f"luminance_ratio_task_{name}": Figure(
            quotient, "1", None, "ratio of means", clause=clause, note=note
        )
    }


def _zone(name: str) -> str:
    ends = [0.0, *ZONES.values()]
    number = list(ZONES).index(name)
    return f"{ends[number]:g}° to {ends[number + 1]:g}° around the task"
