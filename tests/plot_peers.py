"""Draw what `bench_peers` found: ``python tests/plot_peers.py peers.csv peers.svg``.

Relative rms error against processor seconds, a panel for each scene; the lines are of equal efficiency.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

COLOURS = {"lelight": "#1b7837", "Mitsuba": "#2166ac", "Radiance": "#b2182b"}
EFFICIENCIES = (0.1, 1.0, 10.0, 100.0, 1000.0)


def panel(axis: Axes, scene: str, rows: list[dict[str, str]]) -> None:
    """Points of the programs, named, and lines of equal efficiency."""
    errors = np.array([float(row["rms"]) for row in rows])
    seconds = np.array([float(row["cpu_s"]) for row in rows])
    limits = 10.0 ** np.array([np.floor(np.log10(seconds.min())), np.ceil(np.log10(seconds.max()))])
    for efficiency in EFFICIENCIES:
        axis.plot(limits, 1.0 / np.sqrt(efficiency * limits), color="0.85", linewidth=0.8, zorder=0)
    for row, second, error in zip(rows, seconds, errors, strict=True):
        program = row["program"].split()[0].rstrip(",")
        axis.plot(second, error, "o", color=COLOURS[program], label=program)
    axis.set(xscale="log", yscale="log", xlim=limits, title=scene, xlabel="processor seconds")
    axis.set_ylim(0.5 * errors.min(), 2.0 * errors.max())


def main() -> None:
    """Read the CSV and write the SVG."""
    source, target = (Path(name) for name in sys.argv[1:3])
    with source.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure = Figure(figsize=(3.6 * len(scenes), 3.4), layout="constrained")
    FigureCanvasSVG(figure)
    axes = np.atleast_1d(figure.subplots(1, len(scenes)))
    for axis, scene in zip(axes, scenes, strict=True):
        panel(axis, scene, [row for row in rows if row["scene"] == scene])
    axes[0].set_ylabel("relative rms error")
    shown = dict(zip(*reversed(axes[0].get_legend_handles_labels()), strict=True))
    axes[0].legend(shown.values(), shown.keys())
    figure.savefig(target, metadata={"Date": None})


if __name__ == "__main__":
    main()
