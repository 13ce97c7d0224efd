"""``lelight validate``."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from lelight.cli.options import LARGEST_SEED, NamedPath
from lelight.errors import LelightError

if TYPE_CHECKING:
    from lelight.pipelines.validate import Outcome


@click.command()
@click.option("--full", is_flag=True, help="Also the long cases, all with smaller errors.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of the table.")
@click.option(
    "-o",
    "--out",
    type=NamedPath(),
    default="validation.lelight",
    show_default=True,
    help="Folder for validation.json and validation.pdf.",
)
@click.option("--only", default="*", metavar="PATTERN", help="Only cases of this name, e.g. 'sobolev*'.")
@click.option("--seed", type=click.IntRange(0, LARGEST_SEED), default=0, help="Of every random number.")
@click.option("--threads", type=click.IntRange(min=1), help="Default: all that may be used.")
@click.option("--paper", type=click.Choice(["a4", "letter"]), default="a4", show_default=True)
def command(
    *, full: bool, as_json: bool, out: Path, only: str, seed: int, threads: int | None, paper: str
) -> None:
    """Compute scenes whose light is known exactly and compare: a table, JSON and a PDF.

    Exit status 1 where a case does not pass.
    """
    from lelight.pipelines import validate
    from lelight.reports.validation import write_validation_report

    chosen = validate.chosen_cases(full=full, only=only)
    if not chosen:
        raise click.BadParameter(
            f"no case is called {only!r}; `lelight validate` lists all", param_hint="--only"
        )
    found = []
    for number, outcome in enumerate(validate.outcomes(chosen, seed=seed, threads=threads or 0), start=1):
        found.append(outcome)
        click.echo(f"lelight: {number} of {len(chosen)}: {outcome.case.name}: {outcome.verdict}", err=True)
        if not as_json:
            click.echo("\n".join(validate.table_lines(outcome)))
            sys.stdout.flush()
    record = validate.validation_record(found, full=full, seed=seed)
    validate.write_record(out, record)
    sheet = {"a4": "a4", "letter": "us-letter"}[paper]
    report = write_validation_report(out / "validation.pdf", record, paper=sheet)
    if as_json:
        click.echo(json.dumps(record, indent=1, ensure_ascii=False))
    click.echo(f"lelight: {_counted(found)}; results in {report.parent}", err=True)
    _refuse_failures([outcome.case.name for outcome in found if outcome.verdict != "pass"])


def _counted(found: list[Outcome]) -> str:
    passed = sum(outcome.verdict == "pass" for outcome in found)
    return f"{passed} of {len(found)} cases pass"


def _refuse_failures(names: list[str]) -> None:
    """End with one line and status 1 where cases did not pass."""
    if names:
        told = "1 case does" if len(names) == 1 else f"{len(names)} cases do"
        raise LelightError(f"{told} not pass: {', '.join(names)}; see validation.json")
