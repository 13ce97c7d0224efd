"""``lelight photometry``: what photometric files say, what is wrong with them, and their UGR tables."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from lelight.cli.options import NamedPath

FILE = click.argument("file", type=NamedPath())
AS_JSON = click.option("--json", "as_json", is_flag=True, help="As JSON.")


@click.group()
def command() -> None:
    """Read luminaires from IES LM-63 and EULUMDAT files."""


@command.command()
@FILE
@AS_JSON
@click.option("--polar", type=NamedPath(), help="Draw the polar diagram: a .png, .svg or .pdf.")
def info(file: Path, polar: Path | None, *, as_json: bool) -> None:
    """Tell what FILE says: flux, output ratio, angles, flux code, luminances."""
    from lelight.photometry.facts import fact_lines, facts
    from lelight.photometry.reading import read_photometry

    photometry = read_photometry(file)
    if as_json:
        click.echo(json.dumps(facts(photometry), indent=1, ensure_ascii=False))
    else:
        click.echo("\n".join(fact_lines(photometry)))
    if polar is not None:
        from lelight.photometry.diagram import write_polar_diagram

        write_polar_diagram(polar, photometry)
        click.echo(f"polar diagram in {polar}", err=True)


@command.command()
@click.argument("files", type=NamedPath(), nargs=-1, required=True)
@AS_JSON
def check(files: tuple[Path, ...], *, as_json: bool) -> int:
    """Look for mistakes in FILES; exit status 1 where there is an error."""
    checked = [_checked(file) for file in files]
    if as_json:
        click.echo(json.dumps(checked, indent=1, ensure_ascii=False))
    else:
        click.echo("\n".join(line for one in checked for line in _check_lines(one)))
    return int(any(not one["ok"] for one in checked))


def _checked(file: Path) -> dict[str, Any]:
    """Check one file; a file that cannot be read is one of them."""
    from lelight.errors import InputError
    from lelight.photometry.findings import findings
    from lelight.photometry.reading import read_photometry

    try:
        found = [vars(finding) for finding in findings(read_photometry(file))]
    except InputError as failure:
        text = " ".join(str(failure).split())
        found = [{"rule": "unreadable", "severity": "error", "text": text, "line": None}]
    ok = not any(finding["severity"] == "error" for finding in found)
    return {"file": str(file), "ok": ok, "findings": found}


def _check_lines(checked: dict[str, Any]) -> list[str]:
    if not checked["findings"]:
        return [f"{checked['file']}: nothing found"]
    return [
        f"{checked['file']}{'' if one['line'] is None else ':' + str(one['line'])}: "
        f"{one['severity']}: {one['rule']}: {one['text']}"
        for one in checked["findings"]
    ]


@command.command()
@click.argument("source", metavar="IN", type=NamedPath())
@click.argument("out", type=NamedPath())
def convert(source: Path, out: Path) -> None:
    """Write IN as the format that the ending of OUT names: .ies or .ldt."""
    from lelight.photometry.reading import read_photometry
    from lelight.photometry.writing import convert as written

    for lost in written(read_photometry(source), out):
        click.echo(f"lelight: warning: not expressed in {out.name}: {lost}", err=True)


@command.command()
@FILE
@click.option(
    "--spacing", type=click.Choice(["0.25", "1.0"]), default="0.25", help="Of luminaires in H. Default: 0.25."
)
@AS_JSON
def ugr(file: Path, spacing: str, *, as_json: bool) -> None:
    """Print the table of unified glare ratings of FILE (CIE 190)."""
    from lelight.errors import InputError
    from lelight.metrics.cie190 import ugr_table
    from lelight.photometry.reading import read_photometry

    photometry = read_photometry(file)
    try:
        table = ugr_table(photometry, spacing=float(spacing)).to_json()
    except ValueError as reason:
        raise InputError.at(file, None, f"no rating: {reason}") from None
    click.echo(json.dumps(table, indent=1) if as_json else "\n".join(_ugr_lines(table)))


def _ugr_lines(table: dict[str, Any]) -> list[str]:
    head = "  ".join(f"{name:>8}" for name in table["reflectances"])
    lines = [
        f"UGR (CIE 190), spacing {table['spacing']:g} H, {table['flux']:g} lm; ceiling/walls/floor in %",
        f"{'room':12}  {'crosswise':48}  endwise",
        f"{'X x Y':12}  {head}  {head}",
    ]
    for room, cross, end in zip(table["rooms"], table["crosswise"], table["endwise"], strict=True):
        figures = "  ".join(f"{'-' if u is None else format(u, '.1f'):>8}" for u in (*cross, *end))
        lines.append(f"{room:12}  {figures}")
    return lines
