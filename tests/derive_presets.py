"""Derive presets and dial from the Pareto fronts of committed scenes, and write ``lelight/dialvalues.py``.

    python tests/derive_presets.py [FOLDER]

Every scene runs at every pair of target and edge that is not too much work; runs are kept in FOLDER and not done
again. Of each scene the front of processor seconds and error found is taken. For each target the edge is the one whose
runs lie nearest to the fronts, as mean over the scenes of log(error / error of the front in the same time); these are
the points of the dial. Presets are the dial at their targets; a draft's is as loose as is worth it.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path

import numpy as np

from lelight.analytic.known import known_illuminance
from lelight.mesh.remesh import default_edge
from lelight.paretofront import front_error
from lelight.pipelines.beginning import begin
from lelight.pipelines.measuredrun import run_measured
from lelight.pipelines.results import read_run
from lelight.pipelines.sweep import REFERENCE, Variation
from lelight.pipelines.tradeoff import _row, _truth
from lelight.settings import Settings
from lelight.writing.fieldfile import read_field

ROOT = Path(__file__).parents[1]
SCENES = ("sobolev_offset", "cornell", "corridor")
TARGETS = (0.16, 0.08, 0.04, 0.02, 0.01)
SCALES = (2.5, 1.6, 1.0, 0.65, 0.45)
#: Pairs with more work than this, 1/(target x scale)², are left out; the time of references, s.
MOST_WORK, REFERENCE_SECONDS = 24_000.0, 150.0
#: Times as long that half the error may take where a draft had better take it.
WORTH = 1.5


def measured(name: str, folder: Path) -> list[dict]:
    """Rows of a scene's runs, done or read back."""
    path = ROOT / "scenes" / f"{name}.toml"
    scene = begin(path, Settings())
    exact = known_illuminance(scene)
    reference = None
    if exact is None:
        reference = folder / f"{name}-reference.lelight"
        if not (reference / "run.json").exists():
            order = REFERENCE | {"time": REFERENCE_SECONDS, "pictures": False, "seed": 1}
            order |= {"edge": 0.35 * default_edge(scene)}
            run_measured(path, reference, order)
    kept = folder / f"{name}.json"
    rows = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else []
    done = {(row["value"]) for row in rows}
    truth = None
    pairs = [(t, s) for s in SCALES for t in TARGETS if 1.0 / (t * s) ** 2 <= MOST_WORK]
    for target, scale in sorted(pairs, key=lambda pair: -pair[0] * pair[1]):
        value = f"{target:g} {scale:g}"
        if value in done:
            continue
        settings = {"target": target, "edge": scale * default_edge(scene), "pictures": False}
        out = folder / f"{name}-{target:g}-{scale:g}.lelight"
        usage = run_measured(path, out, settings)
        mesh, values, _ = read_field(out / "field.vtp")
        truth = truth or _truth(exact, reference, mesh)
        row = _row(
            Variation("pair", value, out.name, settings, scale), read_run(out), usage, truth, mesh, values
        )
        rows.append(asdict(row))
        kept.write_text(json.dumps(rows, indent=1), encoding="utf-8")
        print(f"{name} {value}: {row.error:.2%} {row.cpu_seconds:.1f} s", flush=True)
    return rows


def edges(tables: list[list[dict]]) -> dict[float, float]:
    """Edge scale for each target whose runs lie nearest to the fronts."""
    found = {}
    for target in TARGETS:
        behind: dict[float, list[float]] = {}
        for rows in tables:
            seconds = [row["cpu_seconds"] for row in rows]
            errors = [row["error"] for row in rows]
            for row in rows:
                if row["settings"]["target"] == target:
                    best = front_error(seconds, errors, row["cpu_seconds"])
                    behind.setdefault(row["scale"], []).append(float(np.log(row["error"] / best)))
        whole = {scale: each for scale, each in behind.items() if len(each) == len(tables)}
        found[target] = _lowest({scale: float(np.mean(each)) for scale, each in whole.items()})
        print(
            f"target {target:.0%}: "
            + ", ".join(f"{s:g}: x {np.exp(np.mean(v)):.2f}" for s, v in whole.items())
        )
    return found


def _lowest(behind: dict[float, float]) -> float:
    """Scale where a parabola in log scale through the least mean and its neighbours is lowest."""
    scales = sorted(behind)
    k = int(np.argmin([behind[scale] for scale in scales]))
    if not 0 < k < len(scales) - 1:
        return scales[k]
    near = scales[k - 1 : k + 2]
    bend, tilt, _ = np.polyfit(np.log(near), [behind[scale] for scale in near], 2)
    return float(np.exp(np.clip(-tilt / (2.0 * bend), np.log(near[0]), np.log(near[2]))))


def dial_of(best: dict[float, float]) -> tuple[list[tuple[float, float]], float]:
    """Points (target, edge) of the dial, the tightest target first, and the power that goes on beyond them.

    Runs to very loose targets are all the same, with the least samples there are: no edge is less than a tighter
    target's.
    """
    targets = sorted(best)
    scales = np.maximum.accumulate([best[target] for target in targets])
    power, _ = np.polyfit(np.log(targets), np.log(scales), 1)
    return [(target, float(f"{scale:.3g}")) for target, scale in zip(targets, scales, strict=True)], power


def draft_of(tables: list[list[dict]], best: dict[float, float]) -> float:
    """Target of a draft: the loosest from which on half the error takes more than so many times as long."""
    targets = sorted(best, reverse=True)
    for loose, tight in pairwise(targets):
        times = [_seconds(rows, tight, best[tight]) / _seconds(rows, loose, best[loose]) for rows in tables]
        print(f"{loose:.0%} to {tight:.0%}: {np.mean(times):.2f} times as long")
        if np.mean(times) > WORTH:
            return loose
    return targets[-1]


def _seconds(rows: list[dict], target: float, scale: float) -> float:
    """Processor seconds of a scene's run to a target, its edge the nearest to a scale."""
    own = [row for row in rows if row["settings"]["target"] == target]
    return float(min(own, key=lambda row: abs(np.log(row["scale"] / scale)))["cpu_seconds"])


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "presets")
    folder.mkdir(parents=True, exist_ok=True)
    tables = [measured(name, folder) for name in SCENES]
    best = edges(tables)
    print("edges: " + ", ".join(f"{t:.0%}: {s:.3g}" for t, s in best.items()))
    points, power = dial_of(best)
    lines = [
        '"""Dial of edge by target; written by ``tests/derive_presets.py``, not by hand."""',
        "",
        "from __future__ import annotations",
        "",
        "#: Targets, and edge length over the default of the scene's size at each.",
        "POINTS: tuple[tuple[float, float], ...] = (",
        *(f"    ({target:g}, {scale:g})," for target, scale in points),
        ")",
        "#: The edge goes with this power of the target beyond them.",
        f"POWER = {power:.4g}",
        f"#: Target of a draft: half the error takes more than {WORTH:g} times as long.",
        f"DRAFT = {draft_of(tables, dict(points)):g}",
        "",
    ]
    (ROOT / "lelight" / "dialvalues.py").write_text("\n".join(lines), encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
