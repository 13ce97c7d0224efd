"""How far presets lie from the front of a scene that no constant of the dial was fitted on. Not collected by default.

    python tests/bench_presets.py FOLDER [SECONDS]

A gallery with a screen across it, one red wall, a bench and a panel that shines at the ceiling. FOLDER keeps the runs.
"""

from __future__ import annotations

import sys
from pathlib import Path

from lelight.paretofront import front_error
from lelight.pipelines.tradeoff import run_tradeoff

#: Boxes by material: corners low and high in m; the first is the room, seen from inside, the others from outside.
BOXES = (
    ("wall", (0.0, 0.0, 0.0), (7.0, 4.0, 3.0)),
    ("screen", (3.2, 0.8, 0.0), (3.3, 4.0, 2.2)),
    ("bench", (4.5, 1.5, 0.0), (6.0, 2.1, 0.45)),
)
SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
PANEL = ((1.0, 1.0, 2.3), (2.2, 1.0, 2.3), (2.2, 2.6, 2.3), (1.0, 2.6, 2.3))
MTL = """newmtl wall
Kd 0.7 0.7 0.7
newmtl red
Kd 0.6 0.15 0.1
newmtl screen
Kd 0.5 0.5 0.5
newmtl bench
Kd 0.3 0.3 0.3
newmtl panel
Kd 0.5 0.5 0.5
"""
TOML = 'geometry = "gallery.obj"\nup = "z"\n[materials]\n"panel" = { luminance = 2000, sides = "front" }\n'
TOLERANCE = 1.2


def gallery(folder: Path) -> Path:
    """Write the scene and return its TOML."""
    lines, corners = ["mtllib gallery.mtl"], 0
    for material, low, high in BOXES:
        lines += [
            f"v {(low, high)[k & 1][0]} {(low, high)[k >> 1 & 1][1]} {(low, high)[k >> 2][2]}"
            for k in range(8)
        ]
        for number, side in enumerate(SIDES):
            inward = side[::-1] if material == "wall" else side
            lines.append("usemtl " + ("red" if material == "wall" and number == 5 else material))
            lines.append("f " + " ".join(str(corners + k + 1) for k in inward))
        corners += 8
    lines += [f"v {x} {y} {z}" for x, y, z in PANEL]
    lines += ["usemtl panel", "f " + " ".join(str(corners + k + 1) for k in range(4))]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "gallery.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "gallery.mtl").write_text(MTL, encoding="utf-8")
    scene = folder / "gallery.toml"
    scene.write_text(TOML, encoding="utf-8")
    return scene


def main() -> None:
    folder = Path(sys.argv[1])
    budget = float(sys.argv[2]) if len(sys.argv) > 2 else 600.0
    record = run_tradeoff(gallery(folder), folder / "gallery.tradeoff", budget=budget, tell=print)
    others = [row for row in record["runs"] if row["knob"] != "preset"]
    seconds, errors = ([row[key] for row in others] for key in ("cpu_seconds", "error"))
    for row in (row for row in record["runs"] if row["knob"] == "preset"):
        times = row["error"] / front_error(seconds, errors, row["cpu_seconds"])
        verdict = "within" if times <= TOLERANCE else "outside"
        print(
            f"{row['value']}: {row['error']:.2%} in {row['cpu_seconds']:.1f} s, x {times:.2f}: {verdict} 20 %"
        )


if __name__ == "__main__":
    main()
