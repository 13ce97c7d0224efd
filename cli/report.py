"""``lelight report``."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from lelight.cli.options import OUT, NamedPath
from lelight.cli.progress import LOG_INTERVAL

PAPERS = {"a4": "a4", "letter": "us-letter"}


@click.command()
@click.argument("kind", type=click.Choice(["luminance", "glare"]))
@OUT
@click.option("--title", help="Title of the report. Default: the scene's name.")
@click.option("--author", help="Who answers for it.")
@click.option("--logo", type=NamedPath(), help="Picture on the cover: .svg, .png or .jpg.")
@click.option("--language", default="en", show_default=True, help="Of the texts.")
@click.option("--paper", type=click.Choice(list(PAPERS)), default="a4", show_default=True)
@click.option("--figures-only", is_flag=True, help="Write the figures as SVG into OUT/figures/KIND instead.")
def command(kind: str, out: Path, *, paper: str, language: str, **wanted: Any) -> None:
    """Write OUT/luminance.pdf or OUT/glare.pdf from the result folder OUT."""
    from lelight.reports.report import Order
    from lelight.reports.texts import languages

    if language not in languages():
        raise click.BadParameter(
            f"found {language!r}; allowed: {', '.join(languages())}", param_hint="--language"
        )
    with warnings.catch_warnings(record=True) as caught, _announced() as announce:
        warnings.simplefilter("always")
        if kind == "luminance":
            from lelight.reports.luminance import write_luminance_report as write
        else:
            from lelight.reports.glare import write_glare_report as write
        path = write(out, Order(paper=PAPERS[paper], language=language, announce=announce, **wanted))
    for warning in caught:
        click.echo(f"lelight: warning: {warning.message}", err=True)
    click.echo(path)


@contextmanager
def _announced() -> Iterator[Callable[[str], None]]:
    """Say on stderr what is being done: as one line that changes, or seldom where nobody watches."""
    if sys.stderr.isatty():
        from rich.console import Console

        with Console(stderr=True).status("reading") as status:
            yield status.update
    else:
        yield _seldom()


def _seldom() -> Callable[[str], None]:
    from time import monotonic

    due = monotonic() + LOG_INTERVAL

    def say(text: str) -> None:
        nonlocal due
        if monotonic() >= due:
            click.echo(f"lelight: report: {text}", err=True)
            due = monotonic() + LOG_INTERVAL

    return say
