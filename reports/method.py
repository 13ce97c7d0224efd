"""How the figures came about: decisions, effort, error reached, what is known to be biased."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lelight.reports.figures.convergence import convergence_curve
from lelight.reports.folder import ResultFolder
from lelight.reports.rounding import LEAST_FRACTION, MISSING, as_given, count, percent, with_unit
from lelight.reports.texts import Texts
from lelight.reports.vocabulary import words

CONVERGENCE = "convergence.svg"
#: What ``run.json`` counts, and its levels of the error statement.
COUNTS = ("nodes", "chains", "replicates", "doublings", "rays")
ERRORS = ("rms", "p95", "p99", "target")


def method_page(folder: ResultFolder) -> dict[str, Any]:
    """Everything on the method page, as text."""
    run, texts = folder.run, folder.texts
    settings = _mapping(run, "settings")
    return {
        "plan": [_decision(decision, texts) for decision in _items(run, "plan")],
        "settings": [_setting(key, chosen, texts) for key, chosen in settings.items() if chosen is not None],
        "effort": _effort(run, texts),
        "seconds": _seconds(_mapping(run, "seconds"), texts),
        "error": _error(_mapping(run, "error"), texts),
        "met": _met(_mapping(run, "error"), texts),
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
    target = _mapping(folder.run, "error").get("target")
    return {CONVERGENCE: convergence_curve(seconds, errors, target=target, texts=folder.texts)}


def _convergence_points(run: Mapping[str, Any]) -> list[tuple[float, float]]:
    """Seconds and relative error after each batch; a curve needs two points that a logarithm can show."""
    steps = [(step.get("seconds"), step.get("rms")) for step in _items(run, "convergence")]
    points = [
        (float(seconds), float(rms)) for seconds, rms in steps if seconds and rms and rms >= LEAST_FRACTION
    ]
    return points if len(points) > 1 else []


def _decision(decision: Mapping[str, Any], texts: Texts) -> dict[str, str]:
    return {
        "decision": words(str(decision.get("decision", MISSING))),
        "value": _plain(decision.get("value"), texts),
        "reason": str(decision.get("reason", "")),
        "cost": str(decision.get("cost", "")),
    }


def _effort(run: Mapping[str, Any], texts: Texts) -> list[tuple[str, str]]:
    counted = [(texts[key], count(int(run[key]))) for key in COUNTS if isinstance(run.get(key), int | float)]
    return [*counted, (texts["seed"], str(run.get("seed", MISSING)))]


def _seconds(seconds: Mapping[str, Any], texts: Texts) -> list[tuple[str, str]]:
    stages = [stage for stage in [*texts.stages, *seconds] if stage in seconds]
    return [
        (texts.stages.get(stage, words(stage)), with_unit(as_given(float(f"{seconds[stage]:.3g}")), "s"))
        for stage in dict.fromkeys(stages)
    ]


def _error(error: Mapping[str, Any], texts: Texts) -> list[tuple[str, str]]:
    return [
        (texts[f"error_{key}"], percent(error[key]))
        for key in ERRORS
        if isinstance(error.get(key), int | float)
    ]


def _met(error: Mapping[str, Any], texts: Texts) -> str:
    if "met" not in error:
        return ""
    return texts["target_met"] if error["met"] else texts["target_missed"]


def _setting(key: str, setting: Any, texts: Texts) -> tuple[str, str]:
    """Name and value of a setting, with its unit where it is a number that has one."""
    name, unit = texts.settings.get(key, (words(key), ""))
    if isinstance(setting, bool) or not isinstance(setting, int | float):
        return name, _plain(setting, texts)
    return name, with_unit(as_given(100.0 * setting if unit == "%" else setting), unit)


def _plain(setting: Any, texts: Texts) -> str:
    """Write a setting in words: yes and no, lists with commas, no braces."""
    if isinstance(setting, bool):
        return texts["yes" if setting else "no"]
    if setting is None:
        return texts["not_set"]
    if isinstance(setting, Mapping):
        return "; ".join(f"{key}: {_plain(part, texts)}" for key, part in setting.items())
    if isinstance(setting, list):
        return ", ".join(_plain(part, texts) for part in setting)
    return str(setting)


def _items(run: Mapping[str, Any], key: str) -> Sequence[Any]:
    found = run.get(key)
    return found if isinstance(found, list) else []


def _mapping(run: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = run.get(key)
    return found if isinstance(found, dict) else {}
