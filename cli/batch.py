"""``lelight batch``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lelight.cli.interruption import STOP
from lelight.cli.options import NamedPath, run_options
from lelight.cli.progress import watched
from lelight.errors import LelightError
from lelight.pipelines.batch import Row, Watch, run_batch, table_lines
from lelight.settings import Settings


@click.command()
@click.argument("scenes", type=NamedPath(), nargs=-1, required=True, metavar="SCENE...")
@click.option(
    "-o", "--out", type=NamedPath(), default="batch.lelight", show_default=True, help="Folder of all results."
)
@run_options
@click.option("--quiet", is_flag=True, help="No progress and no table.")
def command(scenes: tuple[Path, ...], out: Path, *, quiet: bool, **chosen: Any) -> None:
    """Compute many scenes, each into a folder of its own, and list them in index.csv and index.html.

    A scene that fails does not stop the others; a second call skips what is finished and goes on with what was cut
    off. Exit status 1 where a scene failed.
    """
    given = {name: value for name, value in chosen.items() if value is not None}
    at = ""

    with watched(quiet=quiet, title=lambda: at) as (announce, progress):

        def scene(number: int, count: int, name: str) -> None:
            nonlocal at
            at = f"{number} of {count}, {name}: "

        def row(found: Row) -> None:
            if not quiet:
                click.echo(f"lelight: {at}{found.status} {found.message}".rstrip(), err=True)

        rows = run_batch(
            scenes,
            out,
            settings=Settings(**given),
            given=given,
            stop=STOP,
            watch=Watch(scene, row, announce, lambda _: None, progress),
        )
    if not quiet:
        click.echo("\n".join(table_lines(rows)))
    failed = [Path(each.scene).name for each in rows if each.status == "failed"]
    if failed:
        told = "1 scene" if len(failed) == 1 else f"{len(failed)} scenes"
        raise LelightError(f"{told} of {len(rows)} failed: {', '.join(failed)}; see {out / 'index.csv'}")
