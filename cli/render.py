"""``lelight render``."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import click
import numpy as np

from lelight.cli.interruption import STOP
from lelight.cli.options import LARGEST_SEED, OUT, relative_error, seconds
from lelight.cli.progress import watched
from lelight.pipelines.render import Colouring, Eye, Projection, Shot, run_render
from lelight.writing.falsecolour import Marks

#: Options that only ``--method trace`` has.
OF_TRACE = ("target", "time", "chains", "frames", "seed")
#: Widest horizontal angle of a projection, degrees; others have none to choose.
WIDEST = {"perspective": 179.0, "cylindrical": 360.0}


def view(given: str) -> Eye:
    """Read a place and a direction, ``X,Y,Z:DX,DY,DZ``."""
    try:
        position, direction = (np.array([float(n) for n in part.split(",")]) for part in given.split(":"))
    except ValueError as error:
        raise click.BadParameter(f"{given!r} is not X,Y,Z:DX,DY,DZ") from error
    if position.shape != (3,) or direction.shape != (3,) or not np.any(direction):
        raise click.BadParameter(f"{given!r} is not X,Y,Z:DX,DY,DZ with a direction")
    if not np.isfinite([position, direction]).all():
        raise click.BadParameter(f"{given!r} has a number that is not finite")
    return Eye("view", position, direction)


def luminances(given: str) -> tuple[float, ...]:
    """Read positive numbers that ascend, ``1,30,1000``, cd/m²."""
    try:
        values = tuple(float(number) for number in given.split(","))
    except ValueError as error:
        raise click.BadParameter(f"{given!r} is not a list of numbers such as 1,1000") from error
    ascending = all(low < high for low, high in pairwise(values))
    if not (ascending and values[0] > 0 and np.isfinite(values[-1])):
        raise click.BadParameter(f"{given!r}: luminances must be positive and ascend")
    return values


def scale(given: str) -> tuple[float, float]:
    """Read the two ends of a scale, ``LOW,HIGH``, cd/m²."""
    values = luminances(given)
    if len(values) != 2:
        raise click.BadParameter(f"{given!r} is not LOW,HIGH")
    return values[0], values[1]


def isolines(given: str) -> tuple[float, ...]:
    """Read the values of isolines; ``auto``, those of the legend, as an empty list."""
    return () if given == "auto" else luminances(given)


@click.command()
@OUT
@click.option("--observer", help="Name of an observer of the scene.")
@click.option("--view", "place", type=view, metavar="X,Y,Z:DX,DY,DZ", help="Place and direction, m.")
@click.option(
    "--projection",
    type=click.Choice(["fisheye", "equisolid", "perspective", "cylindrical"]),
    default="fisheye",
    show_default=True,
    help="Fisheyes show 180°, equi-angular or equi-solid-angle.",
)
@click.option("--angle", type=click.FloatRange(min=1), help="Degrees across. Default: 70, cylindrical 360.")
@click.option("--size", type=click.IntRange(16, 8192), default=1000, show_default=True, help="Pixels across.")
@click.option("--samples", type=click.IntRange(1, 64), default=1, show_default=True, help="Rays a pixel.")
@click.option(
    "--method",
    type=click.Choice(["field", "trace"]),
    default="field",
    show_default=True,
    help="Read the stored field, or trace by double local estimation.",
)
@click.option("--target", type=relative_error, metavar="ERROR", help="trace: error to reach. Default: 2%.")
@click.option("--time", type=seconds, metavar="TIME", help="trace: stop at this budget, e.g. 60s.")
@click.option(
    "--chains",
    type=click.Choice(["field", "emitters"]),
    help="trace: chains start from what the stored field lacks (default), or from the emitters.",
)
@click.option(
    "--progress-frames",
    "frames",
    is_flag=True,
    default=None,
    help="trace: keep a picture after every step, from the first node of the first chain from the emitters on.",
)
@click.option("--seed", type=click.IntRange(0, LARGEST_SEED), help="trace: seed. Default: 0.")
@click.option(
    "--range", "limits", type=scale, metavar="LOW,HIGH", help="Ends of the scale, cd/m². Default: automatic."
)
@click.option("--decades", type=click.IntRange(1, 12), help="Length of the automatic scale. Default: 3 to 4.")
@click.option(
    "--isolines", type=isolines, metavar="L1,L2|auto", help="Lines of equal luminance, cd/m² or the legend's."
)
@click.option("--no-extrema", is_flag=True, help="Do not mark the darkest and the brightest pixel.")
@click.option("--threads", type=click.IntRange(min=1), help="Default: all that may be used.")
@click.option("--quiet", is_flag=True, help="No progress.")
def command(
    out: Path,
    *,
    observer: str | None,
    place: Eye | None,
    projection: Projection,
    angle: float | None,
    size: int,
    samples: int,
    method: str,
    limits: tuple[float, float] | None,
    decades: int | None,
    isolines: tuple[float, ...] | None,
    no_extrema: bool,
    threads: int | None,
    quiet: bool,
    **of_trace: Any,
) -> None:
    """Take a new luminance picture of the result folder OUT: from its stored field, or traced anew."""
    if (observer is None) == (place is None):
        raise click.UsageError("give either --observer NAME or --view X,Y,Z:DX,DY,DZ")
    if limits is not None and decades is not None:
        raise click.UsageError("--range fixes the scale: leave --decades out")
    _require_angle(projection, angle)
    shot = Shot(place or observer or "", projection, angle, size, samples)
    colouring = Colouring(limits, decades, Marks(extremes=not no_extrema, isolines=isolines))
    given = {name: value for name, value in of_trace.items() if value is not None}
    if method == "field":
        if given:
            raise click.UsageError(f"--{_option(next(iter(given)))} is for --method trace")
        click.echo(run_render(out, shot, colouring=colouring, threads=threads or 0))
        return
    click.echo(_traced(out, shot, colouring, threads or 0, given, quiet=quiet))


def _traced(
    out: Path, shot: Shot, colouring: Colouring, threads: int, given: dict[str, Any], *, quiet: bool
) -> Path:
    """Trace the picture, say how it goes on, and warn where the target was not reached."""
    from lelight.pipelines.trace import Tracing, run_trace

    if given.get("frames"):
        if given.get("chains") == "field":
            raise click.UsageError("--progress-frames shows chains from the emitters: leave --chains out")
        given = given | {"chains": "emitters"}
    tracing = Tracing(**given)
    with watched(quiet=quiet) as (_, progress):
        path, taken = run_trace(
            out, shot, tracing, colouring=colouring, threads=threads, stop=STOP, progress=progress
        )
    if tracing.target is not None and not taken.meets(tracing.target):
        reached = "unknown" if taken.error is None else f"{taken.error.rms:.2%}"
        click.echo(f"lelight: warning: target {tracing.target:.2%} not reached, got {reached}", err=True)
    if not quiet and taken.error is not None:
        click.echo(
            f"lelight: {taken.chains} chains in {taken.replicates} replicates, "
            f"relative standard error {taken.error.rms:.2%}",
            err=True,
        )
    return path


def _require_angle(projection: str, angle: float | None) -> None:
    if angle is None:
        return
    if projection not in WIDEST:
        raise click.UsageError("a fisheye shows 180°: leave --angle out")
    if angle > WIDEST[projection]:
        raise click.UsageError(
            f"--angle {angle:g}: a {projection} picture shows {WIDEST[projection]:g}° at most"
        )


def _option(name: str) -> str:
    return {"frames": "progress-frames"}.get(name, name)
