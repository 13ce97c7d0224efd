"""Ways to keep angular distributions, side by side: what they cost, what they scatter, what they store.

``python tests/bench_angular.py [PICTURE.png]`` prints four tables of a room whose walls are all glossy (exponent 16):
processor time of an estimate against the diffuse one, interleaved; difference of the grid from the closed form by
its number of directions, for each way to go on below the horizon, also drawn as a picture; variance of the paper's
equation (20) with one drawn direction an arrival against the closed form; bytes of a stored node against a grid.
"""

from __future__ import annotations

import sys
import time
import zlib
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from rooms import glossy_room

from lelight.checkpoint.keeper import Keeper
from lelight.estimate.angular import AngularDetail, HarmonicDetail, SampledDetail, angular_detail
from lelight.estimate.batch import estimate_batch
from lelight.estimate.blocks import Batch, Effort
from lelight.harmonics.basis import evaluate
from lelight.harmonics.hemigrid import Extension
from lelight.harmonics.indices import degree_of, terms
from lelight.plan import Plan
from lelight.preparation import Stage, prepare
from lelight.receivers import ILLUMINANCE, Receivers
from lelight.scene import FloatArray
from lelight.settings import Settings
from lelight.storeddegree import lobe_degree

#: Points of one replicate: what the program chooses for this room at a target of 2 %.
EFFORT = Effort(log2_chains=5, log2_direct=2, log2_near=5, bound=0.107)
DEGREE, ROUNDS, REPLICATES, NODES = 13, 7, 16, 100
DIRECTIONS = (36, 64, 100, 196, 324, 576, 900, 1600)
LOBES = np.array([DEGREE, 0])
EXTENSIONS: tuple[Extension, ...] = ("least_squares", "even", "zero")


@dataclass(frozen=True)
class Room:
    """The glossy room, ready to be lit."""

    stage: Stage
    executor: Executor

    def batch(self, receivers: Receivers, detail: AngularDetail | None, replicate: int) -> Batch:
        """Estimate once."""
        return estimate_batch(
            self.stage.world,
            receivers,
            effort=EFFORT,
            seed=(0, replicate),
            base=self.stage.base,
            detail=detail,
            executor=self.executor,
        )

    def nodes(self, degree: int, *, every: int = 1) -> Receivers:
        """Nodes that keep detail of a degree."""
        chosen = self.stage.receivers[np.arange(0, len(self.stage.mesh), every)]
        return replace(chosen, degrees=np.full(len(chosen), degree))

    def radiance(self, receivers: Receivers, detail: AngularDetail, replicate: int) -> FloatArray:
        """Coefficients (r, T) of what nodes reflect."""
        found = self.batch(receivers, detail, replicate)
        coefficients = detail.coefficients(
            found.angular,
            receivers=receivers,
            illuminance=(found.direct + found.indirect)[:, ILLUMINANCE],
            reflectances=self.stage.world.reflectances,
        )
        return coefficients[..., 0]


def closed_form(degree: int) -> HarmonicDetail:
    return HarmonicDetail(degree, 1, np.array([degree, 0]))


def grid_plan() -> Plan:
    return Plan(
        1, "grid", LOBES, LOBES, indirect=True, residual=True, angular="all", sides="lit", decisions=()
    )


def costs(room: Room) -> None:
    """Print processor time against the diffuse estimate, medians of interleaved rounds."""
    reflectances = room.stage.world.reflectances
    ways: dict[str, tuple[int, AngularDetail | None]] = {"diffuse": (0, None)}
    ways |= {f"sh, degree {degree}": (degree, closed_form(degree)) for degree in (11, 13, 24, 48)}
    plan = grid_plan()
    ways["grid, degree 13"] = (DEGREE, angular_detail(plan, reflectances))
    ways["sampled, degree 13"] = (DEGREE, SampledDetail(DEGREE, reflectances, LOBES))
    spent: dict[str, list[float]] = {name: [] for name in ways}
    for turn in range(ROUNDS + 1):
        for name, (degree, detail) in ways.items():
            receivers = room.nodes(degree)
            started = time.process_time()
            room.batch(receivers, detail, turn)
            spent[name].append(time.process_time() - started)
    diffuse = np.array(spent["diffuse"][1:])
    print(f"processor seconds of one estimate at {len(room.stage.mesh)} nodes, and against the diffuse one")
    for name, seconds in spent.items():
        ratio = np.median(np.array(seconds[1:]) / diffuse)
        print(f"  {name:20} {np.median(seconds[1:]):6.2f} {ratio:6.2f}")


def upper(count: int) -> FloatArray:
    """Directions (k, 3) over the horizon."""
    directions = np.random.default_rng(1).normal(size=(count, 3))
    directions[:, 2] = np.abs(directions[:, 2])
    return directions / np.linalg.norm(directions, axis=1)[:, None]


def convergence(room: Room, picture: Path | None) -> None:
    """Print the rms difference of grid and closed form, relative to the mean luminance, for the same arrivals."""
    receivers = room.nodes(DEGREE, every=max(1, len(room.stage.mesh) // NODES))
    views = upper(500)
    truth = room.radiance(receivers, closed_form(DEGREE), 0) @ evaluate(DEGREE, views).T
    plan = grid_plan()
    rows: dict[Extension, list[float]] = {extension: [] for extension in EXTENSIONS}
    print("rms difference of grid and sh by directions: " + ", ".join(EXTENSIONS))
    for directions in DIRECTIONS:
        for extension in EXTENSIONS:
            detail = angular_detail(
                plan, room.stage.world.reflectances, directions=directions, extension=extension
            )
            assert detail is not None
            found = room.radiance(receivers, detail, 0)
            seen = found @ evaluate(degree_of(found.shape[1]), views).T
            rows[extension].append(float(np.sqrt(np.mean((seen - truth) ** 2)) / truth.mean()))
        print(f"  {directions:6} " + " ".join(f"{rows[extension][-1]:10.2e}" for extension in EXTENSIONS))
    if picture is not None:
        _draw(rows, picture)


def _draw(rows: dict[Extension, list[float]], picture: Path) -> None:
    figure = Figure(figsize=(6.0, 4.0), dpi=100, layout="constrained")
    axes = figure.add_subplot()
    for extension, differences in rows.items():
        axes.loglog(DIRECTIONS, differences, "o-", label=extension.replace("_", " "))
    axes.set_xlabel("directions of the grid over the hemisphere")
    axes.set_ylabel("rms of grid minus sh, over the mean radiance")
    axes.grid(which="both", alpha=0.3)
    axes.legend(frameon=False)
    FigureCanvasAgg(figure).print_png(str(picture), metadata={"Software": None})


def variances(room: Room) -> None:
    """Print the variance of radiance by direction over replicates, drawn directions against the closed form."""
    receivers = room.nodes(DEGREE, every=max(1, len(room.stage.mesh) // NODES))
    basis = evaluate(DEGREE, upper(500)).T
    spread, mean = {}, {}
    ways = {
        "closed form": closed_form(DEGREE),
        "drawn": SampledDetail(DEGREE, room.stage.world.reflectances, LOBES),
    }
    for name, detail in ways.items():
        seen = np.array([room.radiance(receivers, detail, k) @ basis for k in range(REPLICATES)])
        spread[name], mean[name] = seen.var(axis=0, ddof=1).mean(), seen.mean()
    print(f"variance of radiance over {REPLICATES} replicates, relative to the square of the mean")
    for name in ways:
        print(f"  {name:12} {spread[name] / mean[name] ** 2:10.3e}   mean {mean[name]:.4f} cd/m2")
    print(f"  ratio {spread['drawn'] / spread['closed form']:.1f}")


def storage(room: Room) -> None:
    """Print bytes a node: float32 harmonics against a grid that carries the same degree, and compressed."""
    print("exponent, degree, bytes of harmonics, of a grid as fine as its degree needs, ratio")
    for exponent in (4, 16, 64, 256):
        degree = lobe_degree(exponent)
        grid = (degree + 1) * (2 * degree + 1)
        print(f"  {exponent:4} {degree:3} {4 * terms(degree):7} {4 * grid:7} {grid / terms(degree):5.2f}")
    receivers = room.nodes(DEGREE)
    found = room.radiance(receivers, closed_form(DEGREE), 0).astype(np.float32)
    padded = np.zeros_like(found)
    padded[:, 0] = found[:, 0]
    for name, stored in (("glossy", found), ("of degree 0", padded)):
        packed = len(zlib.compress(stored.tobytes())) / len(stored)
        print(f"  compressed, node {name} in an array of degree {DEGREE}: {packed:.1f} bytes")


def main() -> None:
    """Print all tables."""
    picture = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    with ThreadPoolExecutor(2) as executor:
        room = Room(prepare(glossy_room(0.4, 0.3, 16.0), Settings(), executor, Keeper()), executor)
        costs(room)
        convergence(room, picture)
        variances(room)
        storage(room)


if __name__ == "__main__":
    main()
