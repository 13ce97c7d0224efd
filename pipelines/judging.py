"""What the runs of a sweep show: the front, how error falls with time by knob, and what pays most, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lelight.paretofront import front_error, pareto_front, slope


def judged(record: dict[str, Any]) -> dict[str, Any]:
    """Add to a record what its runs show: the front, slopes by knob, and what pays most, in words."""
    runs = record["runs"]
    seconds, errors = (np.array([row[key] for row in runs]) for key in ("cpu_seconds", "error"))
    front = pareto_front(seconds, errors)
    runs = [row | {"front": bool(on)} for row, on in zip(runs, front, strict=True)]
    slopes = {}
    for knob in dict.fromkeys(row["knob"] for row in runs):
        own = [row for row in runs if row["knob"] == knob]
        found = slope(np.array([r["cpu_seconds"] for r in own]), np.array([r["error"] for r in own]))
        if found is not None and knob != "preset":
            slopes[knob] = found
    return record | {"runs": runs, "slopes": slopes, "words": in_words(runs, slopes)}


def in_words(runs: list[dict[str, Any]], slopes: Mapping[str, float]) -> list[str]:
    """Say which knob pays most, what the presets are worth, and how far the runs' own errors can be trusted."""
    told = []
    falling = {knob: each for knob, each in slopes.items() if each < 0}
    if falling:
        best = min(falling, key=lambda knob: falling[knob])
        told.append(
            f"{best.capitalize()} pays most: twice the time leaves {2.0 ** falling[best]:.2f} of the error."
        )
        told += [
            f"{knob.capitalize()}: twice the time leaves {2.0**each:.2f} of the error."
            for knob, each in falling.items()
            if knob != best
        ]
    told += [f"{knob.capitalize()}: more time brings nothing." for knob, each in slopes.items() if each >= 0]
    for row in (row for row in runs if row["knob"] == "preset"):
        where = "on the front" if row["front"] else "behind the front"
        if others := [each for each in runs if each["knob"] != "preset"]:
            seconds, errors = ([each[key] for each in others] for key in ("cpu_seconds", "error"))
            times = row["error"] / front_error(seconds, errors, row["cpu_seconds"])
            where = f"{where}, {times:.2f} of the error of the other runs' front in the same time"
        told.append(
            f"Preset {row['value']}: error {row['error']:.2%} in {row['cpu_seconds']:.0f} processor seconds, {where}."
        )
    ratio = np.array([row["error"] / row["predicted_error"] for row in runs])
    told.append(
        f"The error found is {np.median(ratio):.2f} of what runs state themselves "
        f"(median; {ratio.min():.2f} to {ratio.max():.2f})."
    )
    return told
