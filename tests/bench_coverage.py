"""Do the stated 95 % intervals hold the long-run value? Run by hand: pytest tests/bench_coverage.py -s.

The environment variable COVERAGE_SEEDS gives the number of seeds, 200 if absent. The long-run value is that of
all runs together, whose own error is sqrt(200) times smaller than a run's.
"""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
from rooms import grey, lit, panel
from shapes import box

from lelight.calculation import Calculation, calculate
from lelight.metrics.en12464 import plane_figures
from lelight.metrics.figure import Figure
from lelight.metrics.glare import observer_figures
from lelight.pipelines.eyes import sources_seen
from lelight.scene import MeasuringPlane, Observer, Scene
from lelight.settings import Settings

#: Two standard errors of a share of 95 % in 200 runs are 3 %: the band that is asked for.
LEAST, MOST = 0.92, 0.98
PLANE = (
    "mean_illuminance",
    "min_illuminance",
    "uniformity",
    "mean_cylindrical_illuminance",
    "mean_vertical_x",
    "modelling",
)


def room() -> Scene:
    """A room 4 x 3 x 2.5 m under a panel, with a plane of about a hundred points and an eye."""
    walls, lamp = grey("walls", 0.5), grey("lamp", 0.5, luminance=3000.0)
    made = lit(
        box((4.0, 3.0, 2.5)), panel((1.2, 0.9, 2.4), (0, 0.8, 0), (1.1, 0, 0)), materials=[walls, lamp]
    )
    plane = MeasuringPlane("p", np.array([0.5, 0.5, 0.75]), np.array([3.0, 0, 0]), np.array([0, 2.0, 0]))
    eye = Observer("eye", np.array([0.4, 1.5, 1.2]), np.array([1.0, 0, 0]))
    return replace(made, planes=(plane,), observers=(eye,))


def rated(run: Calculation) -> dict[str, Figure]:
    figures = plane_figures(run.planes[0])
    (eye,) = run.observers
    return {name: figures[name] for name in PLANE} | {
        "ugr": observer_figures(eye, sources_seen(run.field, eye.observer))["ugr"]
    }


def test_intervals_hold_the_long_run_value():
    count = int(os.environ.get("COVERAGE_SEEDS", "200"))
    settings = Settings(preset="draft", batches=10, edge=0.8, threads=1, target=0.3)
    runs = []
    grid = np.zeros(0)
    for seed in range(count):
        run = calculate(room(), replace(settings, seed=seed))
        grid = run.planes[0].illuminance / count + (grid if grid.size else 0.0)
        runs.append(rated(run))
    truth = {name: np.mean([run[name].value for run in runs]) for name in runs[0]}
    truth |= {"min_illuminance": grid.min(), "uniformity": grid.min() / grid.mean()}
    shares = {}
    for name, exact in truth.items():
        intervals = np.array([run[name].interval for run in runs])
        shares[name] = float(np.mean((intervals[:, 0] <= exact) & (exact <= intervals[:, 1])))
        spread = np.std([run[name].value for run in runs])
        print(f"{name:32} {exact:10.4f} spread {spread:.4g} covered {shares[name]:.3f}")
    slack = 0.03 * np.sqrt(200 / count) - 0.03
    assert all(LEAST - slack <= share <= MOST + slack for share in shares.values()), shares
