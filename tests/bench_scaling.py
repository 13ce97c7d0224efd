"""How time and memory grow with nodes, triangles, harmonics and threads; exponents by least squares.

Run by hand: ``python tests/bench_scaling.py nodes triangles tessellation degree threads --csv scaling.csv``. Every run
is a process of its own; the time is that inside the run, the memory its peak. Chain vertices are in `bench_pairs`.

Triangles of boxes ask for nodes of their own, those of a tessellated smooth surface only until they are fine enough
for it: there triangles grow alone.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from rooms import grey, lit, panel
from shapes import Shape, box, icosphere, placed

from lelight.calculation import calculate
from lelight.scene import Scene
from lelight.settings import Settings

TARGET = 0.05
#: What is asked for along each law.
LAWS = {
    "nodes": (1e3, 1e4, 1e5, 1e6),
    "triangles": (1e3, 1e4, 1e5),
    "tessellation": tuple(20.0 * 4**levels for levels in (3, 5, 6, 7, 8, 9)),
    "degree": (0, 8, 16, 32, 64),
    "threads": (1, 2),
}
#: Which count grows along a law.
GROWN = {"nodes": "nodes", "triangles": "triangles", "tessellation": "triangles"}
SIZE = (6.0, 5.0, 3.0)


def room(*, exponent: float | None = None) -> Scene:
    """A room with two tables under a panel."""
    gloss = {} if exponent is None else {"specular": 0.2, "exponent": exponent}
    return lit(
        box(SIZE),
        placed(box((1.6, 0.8, 0.72)), shift=(1.0, 1.0, 0.0)),
        placed(box((1.6, 0.8, 0.72)), shift=(3.2, 3.0, 0.0)),
        panel((2.4, 2.0, 2.9), (0.0, 1.0, 0.0), (1.2, 0.0, 0.0)),
        materials=[
            grey("walls", 0.6, **gloss),
            grey("a", 0.4),
            grey("b", 0.4),
            grey("lamp", 0.5, luminance=3000.0),
        ],
    )


def hall_of(triangles: int) -> Scene:
    """The room with so many triangles of small boxes on its floor, which nodes keep to one a side."""
    across = max(1, round((triangles / 12) ** 0.5))
    pitch = np.array([4.8, 3.8]) / across
    boxes = [
        placed(
            box((0.5 * pitch[0], 0.5 * pitch[1], 0.1)), shift=(0.6 + pitch[0] * i, 0.6 + pitch[1] * j, 0.0)
        )
        for i in range(across)
        for j in range(across)
    ]
    vertices = np.concatenate([shape[0] for shape in boxes])
    faces = np.concatenate([shape[1] + 8 * k for k, shape in enumerate(boxes)])
    return lit(
        box(SIZE),
        (vertices, faces),
        panel((2.4, 2.0, 2.9), (0.0, 1.0, 0.0), (1.2, 0.0, 0.0)),
        materials=[grey("walls", 0.6), grey("boxes", 0.4), grey("lamp", 0.5, luminance=3000.0)],
    )


def in_order(shape: Shape, levels: int) -> Shape:
    """An icosphere whose triangles follow those they share edges with, as files of fine surfaces have them."""
    vertices, faces = shape
    faces = faces.reshape(*[4] * levels, 20, 3).transpose(*range(levels, -1, -1), levels + 1).reshape(-1, 3)
    first = np.argsort(np.unique(faces, return_index=True)[1])
    return vertices[first], np.argsort(first)[faces]


def sculpture_of(triangles: int) -> Scene:
    """The room with a smooth bumpy ball in its middle, of 20 times a power of 4 triangles near those asked for."""
    levels = round(np.log(triangles / 20) / np.log(4))
    directions, faces = in_order(icosphere(levels), levels)
    radii = 1.0 + 0.08 * np.prod(np.sin(4.0 * directions + 1.0), axis=1)
    return lit(
        box(SIZE),
        placed((radii[:, None] * directions, faces), shift=(3.0, 2.5, 1.4)),
        panel((2.4, 2.0, 2.9), (0.0, 1.0, 0.0), (1.2, 0.0, 0.0)),
        materials=[grey("walls", 0.6), grey("sculpture", 0.4), grey("lamp", 0.5, luminance=3000.0)],
    )


def edge_for(nodes: float) -> float:
    """Edge in m that makes about so many nodes of the room."""
    return float(np.sqrt(150.0 / nodes))


def one_run(law: str, size: float) -> dict[str, float]:
    """Compute one scene and say how large it was, what it took, and what error it reached."""
    settings = Settings(target=TARGET, edge=edge_for(1e4))
    scene = room()
    if law == "nodes":
        settings = replace(settings, edge=edge_for(size))
    elif law == "triangles":
        scene, settings = hall_of(int(size)), replace(settings, edge=0.5)
    elif law == "tessellation":
        scene, settings = sculpture_of(int(size)), replace(settings, edge=0.15)
    elif law == "degree":
        scene = room(exponent=30.0) if size else scene
        settings = replace(settings, degree=int(size) or None)
    else:
        settings = replace(settings, threads=int(size))
    cpu, wall = time.process_time(), time.perf_counter()
    run = calculate(scene, settings)
    return {
        "asked": size,
        "nodes": len(run.field.mesh),
        "triangles": len(scene.triangles),
        "wall_s": time.perf_counter() - wall,
        "cpu_s": time.process_time() - cpu,
        "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "rms": run.error.rms,
    }


def exponent(sizes: np.ndarray, cost: np.ndarray) -> float:
    """Slope of log cost against log size, over the larger half of the sizes."""
    half = len(sizes) // 2
    return float(np.polyfit(np.log(sizes[half:]), np.log(cost[half:]), 1)[0])


def law_of(law: str) -> list[dict[str, float]]:
    """Run along one law, print rows and exponents."""
    rows = []
    for size in LAWS[law]:
        child = subprocess.run(
            [sys.executable, __file__, "--one", law, str(size)], capture_output=True, text=True, check=True
        )
        rows.append(json.loads(child.stdout.strip().splitlines()[-1]))
        print(law, " ".join(f"{name} {value:.4g}" for name, value in rows[-1].items()), flush=True)
    if grown := GROWN.get(law):
        sizes = np.array([row[grown] for row in rows])
        for cost in ("cpu_s", "memory_mb"):
            print(
                f"{law}: {cost} grows as the power {exponent(sizes, np.array([row[cost] for row in rows])):.2f}"
            )
    return rows


def main() -> None:
    """Run the laws that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("laws", nargs="*", help=", ".join(LAWS))
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--one", nargs=2)
    given = parser.parse_args()
    if given.one:
        print(json.dumps(one_run(given.one[0], float(given.one[1]))))
        return
    lines = []
    for law in given.laws:
        for row in law_of(law):
            lines = lines or ["law," + ",".join(row)]
            lines.append(law + "," + ",".join(f"{value:.6g}" for value in row.values()))
    if given.csv is not None:
        given.csv.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
