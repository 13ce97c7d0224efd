"""How the figures came about: decisions, effort, error reached, what is known to be biased."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lelight.reports.figures.convergence import convergence_curve
from lelight.reports.folder import ResultFolder
from lelight.reports.rounding import MISSING, as_given, count, percent, significant, with_unit
from lelight.reports.vocabulary import SETTINGS, STAGES, words

CONVERGENCE = "convergence.svg"
COUNTS = (
    ("nodes", "Nodes"),
    ("chains", "Chains"),
    ("replicates", "Independent replicates"),
    ("doublings", "Doublings of their sequences"),
    ("rays", "Rays"),
)
#: Levels of the error statement in ``run.json``.
ERRORS = (
    ("rms", "Relative standard error, root mean square over the nodes by area"),
    ("p95", "Not exceeded on 95 % of the area"),
    ("p99", "Not exceeded on 99 % of the area"),
    ("target", "Target of the root mean square"),
)


def method_page(folder: ResultFolder) -> dict[str, Any]:
    """Everything on the method page, as text."""
    run = folder.run
    return {
        "plan": [_decision(decision) for decision in _items(run, "plan")],
        "settings": [_setting(key, setting) for key, setting in _mapping(run, "settings").items()],
        "effort": _effort(run),
        "seconds": _seconds(_mapping(run, "seconds")),
        "error": _error(_mapping(run, "error")),
        "met": _met(_mapping(run, "error")),
        "bias": [str(statement) for statement in _items(run, "bias")],
        "warnings": [str(warning) for warning in _items(run, "warnings")],
        "versions": [(name, str(version)) for name, version in sorted(_mapping(run, "versions").items())],
        "files": [(name, str(digest)) for name, digest in sorted(_mapping(run, "files").items())],
        "convergence": CONVERGENCE if _convergence_points(run) else "",
    }


def method_figures(folder: ResultFolder) -> dict[str, bytes]:
    """Draw the convergence curve, if the run recorded one."""
    points = _convergence_points(folder.run)
    if not points:
        return {}
    seconds, errors = np.array(points).T
    return {
        CONVERGENCE: convergence_curve(seconds, errors, target=_mapping(folder.run, "error").get("target"))
    }


def _convergence_points(run: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Seconds and relative error after each batch; a curve needs two points that a logarithm can show."""
    steps = [(step.get("seconds"), step.get("rms")) for step in _items(run, "convergence")]
    points = [(float(seconds), float(rms)) for seconds, rms in steps if seconds and rms]
    return points if len(points) > 1 else []


def _decision(decision: Mapping[str, Any]) -> dict[str, str]:
    return {
        "decision": words(str(decision.get("decision", MISSING))),
        "value": _plain(decision.get("value")),
        "reason": str(decision.get("reason", "")),
    }


def _effort(run: Mapping[str, Any]) -> list[tuple[str, str]]:
    counted = [
        (label, count(int(run[key]))) for key, label in COUNTS if isinstance(run.get(key), int | float)
    ]
    return [*counted, ("Seed", str(run.get("seed", MISSING)))]


def _seconds(seconds: Mapping[str, Any]) -> list[tuple[str, str]]:
    stages = [stage for stage in [*STAGES, *seconds] if stage in seconds]
    return [
        (STAGES.get(stage, words(stage)), with_unit(significant(float(seconds[stage])), "s"))
        for stage in dict.fromkeys(stages)
    ]


def _error(error: Mapping[str, Any]) -> list[tuple[str, str]]:
    return [(label, percent(error[key])) for key, label in ERRORS if isinstance(error.get(key), int | float)]


def _met(error: Mapping[str, Any]) -> str:
    if "met" not in error:
        return ""
    return (
        "The error target was met."
        if error["met"]
        else "The error target was NOT met: see the error reached."
    )


def _setting(key: str, setting: Any) -> tuple[str, str]:
    """Name and value of a setting, with its unit where it is a number that has one."""
    name, unit = SETTINGS.get(key, (words(key), ""))
    if isinstance(setting, bool) or not isinstance(setting, int | float):
        return name, _plain(setting)
    return name, with_unit(as_given(100.0 * setting if unit == "%" else setting), unit)


def _plain(setting: Any) -> str:
    """Write a setting in words: yes and no, lists with commas, no braces."""
    if isinstance(setting, bool):
        return "yes" if setting else "no"
    if setting is None:
        return "not set"
    if isinstance(setting, Mapping):
        return "; ".join(f"{key}: {_plain(part)}" for key, part in setting.items())
    if isinstance(setting, list):
        return ", ".join(_plain(part) for part in setting)
    return str(setting)


def _items(run: Mapping[str, Any], key: str) -> Sequence[Any]:
    found = run.get(key)
    return found if isinstance(found, list) else []


def _mapping(run: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = run.get(key)
    return found if isinstance(found, dict) else {}
