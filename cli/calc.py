"""``lelight calc``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lelight.calculation import Calculation
from lelight.cli.interruption import STOP
from lelight.cli.options import SCENE, NamedPath, run_options
from lelight.cli.progress import watched
from lelight.pipelines.calc import run_calc
from lelight.pipelines.record import mesh_statement
from lelight.settings import Settings


@click.command()
@SCENE
@click.option("-o", "--out", type=NamedPath(), help="Result folder. Default: SCENE's stem.lelight.")
@run_options
@click.option(
    "--like",
    type=NamedPath(),
    metavar="OUT",
    help="Sample as the run in OUT did, for `lelight compare`; instead of --target and --time.",
)
@click.option("--resume", is_flag=True, help="Go on where a run that was stopped or killed has come to.")
@click.option("--quiet", is_flag=True, help="No progress and no summary.")
def command(
    scene: Path, out: Path | None, *, like: Path | None, resume: bool, quiet: bool, **chosen: Any
) -> None:
    """Compute the light in SCENE (an OBJ, or a TOML that names one) and write all results."""
    given = {name: value for name, value in chosen.items() if value is not None}
    if like is not None and given.keys() & {"target", "time"}:
        raise click.UsageError("--like takes the other run's effort: leave --target and --time out")
    if like is not None and resume:
        raise click.UsageError("--like begins anew: leave --resume out")
    warnings: list[str] = []
    with watched(quiet=quiet) as (announce, progress):
        folder, run = run_calc(
            scene,
            out,
            settings=Settings(**given),
            given=given,
            resume="yes" if resume else "no",
            stop=STOP,
            like=like,
            announce=announce,
            tell=lambda text: click.echo(f"lelight: {text}", err=True),
            warn=warnings.append,
            progress=progress,
        )
    if run is None:
        return
    if not run.target_met:
        click.echo(
            f"lelight: warning: target {run.settings.target_error:.2%} not reached, got {run.error.rms:.2%}",
            err=True,
        )
    if not quiet:
        told = [f"lelight: warning: {warning}" for warning in warnings]
        click.echo("\n".join(told + summary(folder, run)), err=True)


def summary(folder: Path, run: Calculation) -> list[str]:
    """Say in a few lines what was reached and where it is."""
    seconds = sum(run.seconds.values())
    lines = [
        f"unit {run.scene.unit}, {run.scene.up} up; {len(run.field.mesh)} nodes, "
        f"{run.replicates.count} replicates doubled {run.replicates.doublings} times, "
        f"{run.replicates.rays / 1e6:.1f} million rays, {seconds:.1f} s",
        f"relative standard error {run.error.rms:.2%} (95 % of the area below {run.error.p95:.2%}, "
        f"99 % below {run.error.p99:.2%})",
        mesh_statement(run),
    ]
    for values in run.planes:
        mean = values.replicates.mean(axis=1)
        error = mean.std(ddof=1) / len(mean) ** 0.5
        lines.append(f"{values.plane.name}: Em {mean.mean():.1f} ± {2 * error:.1f} lx")
    return [*lines, f"results in {folder}"]
