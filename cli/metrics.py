"""``lelight metrics``."""

from __future__ import annotations

import json
from pathlib import Path

import click

from lelight.cli.options import OUT
from lelight.pipelines.results import read_metrics, table_lines


@click.command()
@OUT
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
@click.option("--csv", "as_csv", is_flag=True, help="As comma-separated values.")
def command(out: Path, *, as_json: bool, as_csv: bool) -> None:
    """Print every figure of the result folder OUT."""
    table = read_metrics(out)
    if as_json:
        click.echo(json.dumps(table, indent=1, ensure_ascii=False))
    elif as_csv:
        from lelight.metrics.table import to_csv

        click.echo(to_csv(table), nl=False)
    else:
        click.echo("\n".join(table_lines(table)))
