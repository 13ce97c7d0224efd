"""Table of predicted against reached: what ``check`` foretells, and what runs to targets and in budgets find.

    python tests/predicted_and_reached.py FOLDER [SCENE...]

Every scene runs to every target and in every budget, each time after the forecast that ``lelight check`` prints; rows
are kept in FOLDER/rows.json and not done again.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from lelight.forecast import forecast
from lelight.pipelines.beginning import begin
from lelight.pipelines.measuredrun import run_measured
from lelight.pipelines.results import read_run
from lelight.settings import Settings

ROOT = Path(__file__).parents[1]
SCENES = ("sobolev_offset", "sphere90", "cornell", "corridor", "furnace")
TARGETS = (0.16, 0.08, 0.04, 0.02)
BUDGETS = (10.0, 20.0, 40.0)


def row(name: str, folder: Path, asked: dict) -> dict:
    path = ROOT / "scenes" / f"{name}.toml"
    told, _ = forecast(begin(path, Settings()), Settings(**asked))
    key = "-".join(f"{k}-{v:g}" for k, v in asked.items())
    usage = run_measured(path, folder / f"{name}-{key}.lelight", asked)
    run = read_run(folder / f"{name}-{key}.lelight")
    error = run["error"]
    reached = max(error["rms"], error["p95"] / 3.0, error["p99"] / 5.0)
    return {
        "scene": name,
        **asked,
        "foretold_seconds": told.seconds,
        "seconds": run["seconds"]["total"],
        "process_seconds": usage.seconds,
        "cpu_seconds": usage.cpu_seconds,
        "foretold_error": told.error,
        "error": reached,
        "rms": error["rms"],
        "foretold_memory": told.memory,
        "memory": usage.memory,
        "nodes": run["nodes"],
        "foretold_nodes": told.nodes,
        "chains": run["chains"],
        "replicates": run["replicates"],
        "doublings": run["doublings"],
    }


def line(each: dict) -> str:
    asked = f"{each['target']:.0%}" if "target" in each else f"{each['time']:.0f} s"
    return (
        f"| {each['scene']} | {asked} | {each['foretold_error']:.1%} | {each['error']:.1%} | "
        f"{each['foretold_seconds']:.0f} | {each['seconds']:.1f} | "
        f"{each['foretold_memory'] / 1e6:.0f} | {each['memory'] / 1e6:.0f} |"
    )


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    kept = folder / "rows.json"
    rows = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else []
    for name in sys.argv[2:] or SCENES:
        for asked in [*({"target": t} for t in TARGETS), *({"time": t} for t in BUDGETS)]:
            if any(each["scene"] == name and asked.items() <= each.items() for each in rows):
                continue
            rows.append(row(name, folder, asked))
            kept.write_text(json.dumps(rows, indent=1), encoding="utf-8")
            print(line(rows[-1]), flush=True)


if __name__ == "__main__":
    main()
