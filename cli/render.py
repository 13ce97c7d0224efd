"""``lelight render``."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from lelight.cli.options import OUT
from lelight.pipelines.render import Eye, Projection, run_render


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


@click.command()
@OUT
@click.option("--observer", help="Name of an observer of the scene.")
@click.option("--view", "place", type=view, metavar="X,Y,Z:DX,DY,DZ", help="Place and direction, m.")
@click.option("--projection", type=click.Choice(["fisheye", "perspective"]), default="fisheye")
@click.option("--size", type=click.IntRange(16, 8192), default=1000, show_default=True, help="Pixels across.")
@click.option("--samples", type=click.IntRange(1, 64), default=1, show_default=True, help="Rays a pixel.")
def command(
    out: Path, *, observer: str | None, place: Eye | None, projection: Projection, size: int, samples: int
) -> None:
    """Take a new luminance picture of the result folder OUT, from its stored field."""
    if (observer is None) == (place is None):
        raise click.UsageError("give either --observer NAME or --view X,Y,Z:DX,DY,DZ")
    click.echo(run_render(out, place or observer or "", projection=projection, size=size, samples=samples))
