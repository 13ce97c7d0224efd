"""``lelight report``."""

from __future__ import annotations

import warnings
from pathlib import Path

import click

from lelight.cli.options import OUT


@click.command()
@click.argument("kind", type=click.Choice(["luminance", "glare"]))
@OUT
@click.option("--title", help="Title of the report. Default: the scene's name.")
@click.option("--author", help="Who answers for it.")
@click.option("--paper", type=click.Choice(["a4", "letter"]), default="a4", show_default=True)
def command(kind: str, out: Path, *, title: str | None, author: str | None, paper: str) -> None:
    """Write OUT/luminance.pdf or OUT/glare.pdf from the result folder OUT."""
    sheet = {"a4": "a4", "letter": "us-letter"}[paper]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        if kind == "luminance":
            from lelight.reports.luminance import write_luminance_report as write
        else:
            from lelight.reports.glare import write_glare_report as write
        path = write(out, title=title, author=author, paper=sheet)
    for warning in caught:
        click.echo(f"lelight: warning: {warning.message}", err=True)
    click.echo(path)
