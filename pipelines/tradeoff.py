"""``lelight tradeoff``: speed against accuracy of one scene, measured run by run within a budget of time."""

from __future__ import annotations

import csv
import io
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

import lelight
from lelight.analytic.known import known_illuminance
from lelight.checkpoint.identity import fingerprint, identity_of
from lelight.errors import OutputError
from lelight.fielderror import (
    Exact,
    SamplePoints,
    illuminance_at,
    radiance_at,
    relative_rms,
    sample_points,
)
from lelight.mesh.nodes import NodeMesh
from lelight.pipelines.beginning import begin
from lelight.pipelines.folder import write_json
from lelight.pipelines.judging import judged
from lelight.pipelines.measuredrun import Usage, run_measured
from lelight.pipelines.results import read_run
from lelight.pipelines.sweep import REFERENCE, Variation, variations
from lelight.results import NodeValues
from lelight.scene import FloatArray, Scene
from lelight.settings import Settings
from lelight.writing.fieldfile import read_field
from lelight.writing.files import make_folder, write_text

#: Most of the budget that the reference may take.
SHARE_OF_REFERENCE = 0.35
#: What a run is expected to take beside its estimate, before anything was measured, in s.
OVERHEAD = 4.0
RECORD = "tradeoff.json"


@dataclass(frozen=True)
class Row:
    """One run of the sweep.

    Attributes
    ----------
    knob, value : what was turned, and to where
    scale : of the edge against the default
    predicted_error : standard error and interpolation as the run itself states them, together
    error : measured against the truth, relative root mean square of the illuminance over all lit surfaces
    radiance_error : likewise of the radiance that glossy nodes store; None where none do
    front : whether no other run is both faster and more accurate
    """

    knob: str
    value: str
    settings: dict[str, Any]
    scale: float
    nodes: int
    rays: int
    chains: int
    std_error: float
    interpolation: float
    predicted_error: float
    error: float
    radiance_error: float | None
    seconds: float
    cpu_seconds: float
    memory: int
    size: int
    front: bool = False


@dataclass(frozen=True)
class Truth:
    """What runs are held against.

    Attributes
    ----------
    basis : in words
    std_error : of the reference itself, 0 for a closed form
    """

    basis: str
    std_error: float
    at: SamplePoints
    illuminance: FloatArray
    radiance: FloatArray | None


def run_tradeoff(
    scene_path: Path,
    out: Path,
    *,
    against: Path | None = None,
    budget: float = 600.0,
    seed: int = 0,
    threads: int = 0,
    tell: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Sweep, measure and write ``tradeoff.json`` and ``tradeoff.csv`` into ``out``; go on where an earlier call ended.

    Parameters
    ----------
    against : result folder to take for the truth instead of a long run; a closed form wins over both
    budget : s, of all calls together

    Returns
    -------
    dict : what ``tradeoff.json`` holds
    """
    scene = begin(scene_path, Settings())
    if against is not None:
        read_run(against)
    make_folder(out)
    fixed = {"seed": seed, "threads": threads}
    record = _begun(out, scene, fixed, against)
    sweep = variations(scene)
    clock = _Budget(budget, spent=record["seconds"])
    exact = known_illuminance(scene)
    reference = against
    if reference is None and exact is None:
        reference = _reference(scene_path, out, clock, fixed, tell)
    elif exact is not None:
        tell(f"known exactly: {exact[0]}")
    truth = None
    done = {(row["knob"], row["value"]) for row in record["runs"]}
    for number, variation in enumerate(sweep, start=1):
        name = f"{number} of {len(sweep)}: {variation.knob} {variation.value}"
        if (variation.knob, variation.value) in done:
            tell(f"{name}: done before")
            continue
        expected = _expected(variation, record["runs"])
        if expected > clock.left:
            tell(f"{name}: left out, would take about {expected:.0f} s of {max(clock.left, 0.0):.0f} s")
            continue
        folder = out / "runs" / variation.stem
        usage = run_measured(scene_path, folder, fixed | variation.settings)
        mesh, values, _ = read_field(folder / "field.vtp")
        truth = truth or _truth(exact, reference, mesh)
        row = _row(variation, read_run(folder), usage, truth, mesh, values)
        record["runs"].append(asdict(row))
        tell(f"{name}: error {row.error:.2%}, {row.seconds:.1f} s, {row.cpu_seconds:.1f} processor seconds")
        record |= {"seconds": clock.spent, "truth": _told(truth)}
        _write(out, record)
    done = {(row["knob"], row["value"]) for row in record["runs"]}
    left_out = [f"{each.knob} {each.value}" for each in sweep if (each.knob, each.value) not in done]
    if not record["runs"]:
        raise OutputError(f"{out}: no run fits into {budget:.0f} s; give more --time")
    record = judged(record | {"seconds": clock.spent, "left_out": left_out, "budget": budget})
    _write(out, record)
    return record


class _Budget:
    """Seconds that may still be spent, over all calls."""

    def __init__(self, budget: float, *, spent: float) -> None:
        self._started = time.perf_counter() - spent
        self._budget = budget

    @property
    def spent(self) -> float:
        return time.perf_counter() - self._started

    @property
    def left(self) -> float:
        return self._budget - self.spent

    @property
    def whole(self) -> float:
        return self._budget


def _begun(out: Path, scene: Scene, fixed: Mapping[str, Any], against: Path | None) -> dict[str, Any]:
    """Go on with the record of an earlier call on the same scene, or begin one."""
    settings = replace(Settings(), seed=fixed["seed"]).over(scene.settings)
    own = fingerprint(identity_of(scene, settings) | {"against": {"path": str(against)}})
    fresh: dict[str, Any] = {
        "lelight": lelight.__version__,
        "scene": scene.name,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "fingerprint": own,
        "seconds": 0.0,
        "runs": [],
    }
    try:
        found = json.loads((out / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return fresh
    if not isinstance(found, dict) or found.get("fingerprint") != own:
        return fresh
    kept = {name: found[name] for name in ("date", "runs", "truth") if name in found}
    return fresh | kept | {"seconds": float(found["seconds"])}


def _reference(
    scene_path: Path, out: Path, clock: _Budget, fixed: Mapping[str, Any], tell: Callable[[str], None]
) -> Path:
    """Compute a long run to hold the others against, unless an earlier call has."""
    folder = out / "reference.lelight"
    seconds = SHARE_OF_REFERENCE * clock.whole
    if (folder / "run.json").exists():
        tell("reference: done before")
        return folder
    tell(f"reference: a run of up to {seconds:.0f} s")
    settings = dict(fixed) | REFERENCE | {"time": seconds, "seed": fixed["seed"] + 1}
    run_measured(scene_path, folder, settings)
    return folder


def _truth(exact: tuple[str, Exact] | None, reference: Path | None, mesh: NodeMesh) -> Truth:
    if exact is not None:
        at = sample_points(mesh)
        return Truth(exact[0], 0.0, at, exact[1](at.points, at.normals), None)
    if reference is None:
        raise ValueError("reference: nothing to hold runs against")
    own, values, _ = read_field(reference / "field.vtp")
    told = read_run(reference)
    at = sample_points(own)
    radiance = radiance_at(own, values, at)[0] if values.sh_degree.any() else None
    error = told["error"]["rms"] or 0.0
    off = (told["interpolation"] or {}).get("rms", 0.0)
    basis = f"run of {len(own)} nodes, standard error {error:.2%}, interpolation off by {off:.2%} of the mean"
    return Truth(basis, float(np.hypot(error, off)), at, illuminance_at(own, values, at), radiance)


def _row(
    variation: Variation,
    run: Mapping[str, Any],
    usage: Usage,
    truth: Truth,
    mesh: NodeMesh,
    values: NodeValues,
) -> Row:
    radiance_error = None
    if truth.radiance is not None and values.sh_degree.any():
        found, degrees = radiance_at(mesh, values, truth.at)
        kept = degrees > 0
        if kept.any():
            radiance_error = relative_rms(found[kept].ravel(), truth.radiance[kept].ravel())
    std_error = float(run["error"]["rms"] or np.inf)
    off = float((run["interpolation"] or {}).get("rms", 0.0))
    return Row(
        knob=variation.knob,
        value=variation.value,
        settings=dict(variation.settings),
        scale=variation.scale,
        nodes=run["nodes"],
        rays=run["rays"],
        chains=run["chains"],
        std_error=std_error,
        interpolation=off,
        predicted_error=float(np.hypot(std_error, off)),
        error=relative_rms(illuminance_at(mesh, values, truth.at), truth.illuminance),
        radiance_error=radiance_error,
        **{name: round(number, 3) for name, number in vars(usage).items()},
    )


def _expected(variation: Variation, runs: list[dict[str, Any]]) -> float:
    """Seconds that a run will take, from those that were: by nodes and the square of the target."""
    if not runs:
        return 0.0
    work = [1.0 / (row["settings"]["target"] * row["scale"]) ** 2 for row in runs]
    own = 1.0 / (variation.settings["target"] * variation.scale) ** 2
    nearest = int(np.argmin(np.abs(np.log(np.array(work) / own))))
    estimate = max(0.0, float(runs[nearest]["seconds"]) - OVERHEAD)
    return OVERHEAD + estimate * float(max(own / work[nearest], 1.0))


def _told(truth: Truth) -> dict[str, Any]:
    return {"basis": truth.basis, "error": truth.std_error, "points": len(truth.illuminance)}


def _write(out: Path, record: Mapping[str, Any]) -> None:
    write_json(out / RECORD, record)
    text = io.StringIO(newline="")
    columns = [name for name in Row.__dataclass_fields__ if name != "settings"]
    writer = csv.DictWriter(text, columns, lineterminator="\n", extrasaction="ignore")
    writer.writeheader()
    writer.writerows(record["runs"])
    write_text(out / "tradeoff.csv", text.getvalue())
