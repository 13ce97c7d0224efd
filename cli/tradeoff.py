"""``lelight tradeoff``."""

from __future__ import annotations

from pathlib import Path

import click

from lelight.cli.options import LARGEST_SEED, SCENE, NamedPath, seconds


@click.command()
@SCENE
@click.option("--against", type=NamedPath(), metavar="OUT", help="Result folder to take for the truth.")
@click.option("-o", "--out", type=NamedPath(), help="Default: SCENE's stem.tradeoff.")
@click.option("--time", type=seconds, default="10min", show_default=True, metavar="TIME", help="Budget.")
@click.option("--seed", type=click.IntRange(0, LARGEST_SEED), default=0, help="Of every random number.")
@click.option("--threads", type=click.IntRange(min=1), help="Default: all that may be used.")
@click.option("--paper", type=click.Choice(["a4", "letter"]), default="a4", show_default=True)
@click.option("--quiet", is_flag=True, help="No progress and no summary.")
def command(
    scene: Path,
    *,
    against: Path | None,
    out: Path | None,
    time: float,
    seed: int,
    threads: int | None,
    paper: str,
    quiet: bool,
) -> None:
    """Measure speed against accuracy in SCENE: chains, edge, method, degree and presets against a long run.

    Where the scene has a closed form, that is the truth. Called again it goes on where it ended.
    """
    from lelight.pipelines.tradeoff import run_tradeoff
    from lelight.reports.tradeoff import write_tradeoff_sheet

    folder = out if out is not None else scene.with_name(f"{scene.stem}.tradeoff")

    def tell(text: str) -> None:
        if not quiet:
            click.echo(f"lelight: {text}", err=True)

    record = run_tradeoff(
        scene, folder, against=against, budget=time, seed=seed, threads=threads or 0, tell=tell
    )
    write_tradeoff_sheet(folder, record, paper={"a4": "a4", "letter": "us-letter"}[paper])
    if not quiet:
        click.echo("\n".join(record["words"]))
        click.echo(f"lelight: results in {folder}", err=True)
