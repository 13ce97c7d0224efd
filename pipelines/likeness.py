"""Sampling like another run, whose result folder is there."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields, replace
from pathlib import Path

from lelight.estimate.samplingplan import SamplingPlan
from lelight.pipelines.folder import REPLICATES
from lelight.pipelines.results import read_run
from lelight.plan import Forced
from lelight.settings import Settings
from lelight.writing.replicatesfile import read_replicates

#: Settings that two runs share where their random numbers are to be the same.
SHARED_SETTINGS = frozenset(
    {"preset", "method", "edge", "directions", "extension", "seed", "adaptive", "estimator"}
    | {field.name for field in fields(Forced)}
)


def settings_like(out: Path, settings: Settings, *, given: Collection[str]) -> tuple[Settings, SamplingPlan]:
    """Take from the result folder ``out`` what the user has not given, and how its run sampled.

    Raises
    ------
    OutputError
        where the folder is not whole
    """
    told = read_run(out).get("settings")
    told = told if isinstance(told, dict) else {}
    sampling = read_replicates(out / REPLICATES).sampling
    known = {field.name for field in fields(Settings)} & SHARED_SETTINGS
    there = {name: told[name] for name in known if name in told} | {"edge": sampling.edge}
    return replace(settings, **{name: value for name, value in there.items() if name not in given}), sampling
