"""``lelight relight``."""

from __future__ import annotations

from pathlib import Path

import click

from lelight.cli.options import OUT, NamedPath


@click.command()
@OUT
@click.option(
    "--material",
    "materials",
    multiple=True,
    required=True,
    metavar="NAME={ reflectance = 0.3, specular = 0.1, exponent = 64 }",
    help="New reflection of a material, keys as in a scene file; again for another.",
)
@click.option("-o", "--output", "to", type=NamedPath(), help="Folder to write. Default: OUT with -relit.")
def command(out: Path, *, materials: tuple[str, ...], to: Path | None) -> None:
    """Give surfaces of the result folder OUT other materials, without a new run.

    What a surface sends to the eye changes; what surfaces have received from each other does not.
    """
    from lelight.pipelines.relight import run_relight
    from lelight.reading.changes import read_changes

    folder, limit = run_relight(out, read_changes(materials), to=to)
    click.echo(limit, err=True)
    click.echo(folder)
