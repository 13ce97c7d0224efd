"""``lelight render``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from lelight.cli.options import OUT
from lelight.pipelines.render import Eye, Projection, run_render


class View(click.ParamType):
    """A place and a direction, ``X,Y,Z:DX,DY,DZ``."""

    name = "view"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Eye:
        """Read two triples of numbers."""
        try:
            position, direction = (np.array([float(n) for n in part.split(",")]) for part in value.split(":"))
        except ValueError:
            self.fail(f"{value!r} is not X,Y,Z:DX,DY,DZ", param, ctx)
        if position.shape != (3,) or direction.shape != (3,) or not np.any(direction):
            self.fail(f"{value!r} is not X,Y,Z:DX,DY,DZ with a direction", param, ctx)
        if not np.isfinite([position, direction]).all():
            self.fail(f"{value!r} has a number that is not finite", param, ctx)
        return Eye("view", position, direction)


@click.command()
@OUT
@click.option("--observer", help="Name of an observer of the scene.")
@click.option("--view", type=View(), help="X,Y,Z:DX,DY,DZ in m, scene axes.")
@click.option("--projection", type=click.Choice(["fisheye", "perspective"]), default="fisheye")
@click.option("--size", type=click.IntRange(16, 8192), default=1000, show_default=True, help="Pixels across.")
@click.option("--samples", type=click.IntRange(1, 64), default=1, show_default=True, help="Rays a pixel.")
def command(
    out: Path, *, observer: str | None, view: Eye | None, projection: Projection, size: int, samples: int
) -> None:
    """Take a new luminance picture of the result folder OUT, from its stored field."""
    if (observer is None) == (view is None):
        raise click.UsageError("give either --observer NAME or --view X,Y,Z:DX,DY,DZ")
    click.echo(run_render(out, view or observer or "", projection=projection, size=size, samples=samples))
