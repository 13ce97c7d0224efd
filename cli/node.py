"""``lelight node``."""

from __future__ import annotations

import json
from pathlib import Path

import click
import numpy as np

from lelight.cli.options import OUT, edge_length
from lelight.pipelines.node import run_node, summary
from lelight.scene import FloatArray


def coordinates(given: str) -> FloatArray:
    """Read three numbers, ``X,Y,Z``."""
    try:
        found = np.array([float(number) for number in given.split(",")])
    except ValueError as error:
        raise click.BadParameter(f"{given!r} is not X,Y,Z") from error
    if found.shape != (3,) or not np.isfinite(found).all():
        raise click.BadParameter(f"{given!r} is not X,Y,Z")
    return found


@click.command()
@OUT
@click.option("--at", "place", type=coordinates, required=True, metavar="X,Y,Z", help="Place, m.")
@click.option("--facing", type=coordinates, metavar="X,Y,Z", help="Direction into which its surface looks.")
@click.option("--length", type=edge_length, metavar="LENGTH", help="Length of the glyph, m.")
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON.")
def command(
    out: Path, *, place: FloatArray, facing: FloatArray | None, length: float | None, as_json: bool
) -> None:
    """Show how the node nearest to a place looks from every side.

    Writes its luminance body as a picture, as a glyph for ParaView, and as numbers.
    """
    files = run_node(out, place, facing=facing, length=length)
    if as_json:
        click.echo(json.dumps(files.table, indent=1, ensure_ascii=False))
    else:
        click.echo("\n".join(summary(files)))
