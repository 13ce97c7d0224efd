"""``lelight compare``."""

from __future__ import annotations

import json
from pathlib import Path

import click

from lelight.cli.options import NamedPath
from lelight.pipelines.compare import Comparison, FigureDifference, as_table, run_compare


@click.command()
@click.argument("first", metavar="OUT_A", type=NamedPath())
@click.argument("second", metavar="OUT_B", type=NamedPath())
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
@click.option("--all", "every", is_flag=True, help="Also figures that do not differ significantly.")
@click.option(
    "-o", "--out", type=NamedPath(), help="VTK file of the nodes' differences. Default: OUT_B/difference.vtp."
)
def command(first: Path, second: Path, *, as_json: bool, every: bool, out: Path | None) -> None:
    """Say what differs between the results OUT_A and OUT_B, and how sure that is.

    Errors are smallest where OUT_B was computed by `lelight calc --like OUT_A`.
    """
    comparison = run_compare(first, second, out=out)
    if as_json:
        click.echo(json.dumps(as_table(comparison), indent=1, ensure_ascii=False))
    else:
        click.echo("\n".join(lines(comparison, every=every)))


def lines(comparison: Comparison, *, every: bool) -> list[str]:
    """Tell a comparison as text: how it was made, the figures, the nodes, and the verdict."""
    judged = [each for each in comparison.figures if each.p_value is not None]
    shown = [each for each in judged if each.significant or every]
    told = [
        f"B - A by {comparison.pairs} pairs of replicates"
        if comparison.pairs
        else "B - A of independent runs; `lelight calc --like OUT_A` makes pairs and smaller errors"
    ]
    told += map(_line, shown)
    told.append(
        f"{sum(bool(each.significant) for each in judged)} of {len(judged)} figures differ significantly "
        f"(each at {comparison.level:.2g}, 5 % over all)"
    )
    if comparison.nodes is None:
        told.append("the meshes differ: nodes were not compared")
    else:
        told.append(
            f"{comparison.significant_nodes} of {len(comparison.nodes.difference)} visible nodes differ "
            f"significantly; {comparison.file}"
        )
    return told if comparison.differs else [*told, "no significant difference"]


def _line(each: FigureDifference) -> str:
    where = f"{each.group} {each.name}".strip()
    unit = "" if each.unit == "1" else f" {each.unit}"
    how = "paired" if each.paired else "unpaired"
    verdict = "differs" if each.significant else ""
    change = f"{each.difference:+.3g} ± {each.half_width:.2g}{unit}"
    values = f"{each.first:9.5g} → {each.second:<9.5g}"
    return f"{where:24} {each.figure:31} {values} {change:>22} {how:8} {verdict}".rstrip()
