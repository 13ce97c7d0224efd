"""``lelight check``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
from numpy.typing import NDArray

from lelight.cli.options import SCENE, run_options
from lelight.pipelines.check import Check, run_check
from lelight.settings import Settings


@click.command()
@SCENE
@run_options
def command(scene: Path, **chosen: Any) -> None:
    """Read SCENE, trace nothing: the plan, the materials, the lint, and what a run will take."""
    given = {name: value for name, value in chosen.items() if value is not None}
    check = run_check(scene, settings=Settings(**given), given=given)
    for title, lines in (
        ("Scene", _scene(check)),
        ("Plan", [f"{d.name}: {d.value} ({d.reason})" for d in check.plan.decisions]),
        ("Materials", _materials(check)),
        ("Lint", [f"{f.severity}: {f.rule}: {f.text}" for f in check.findings] or ["nothing found"]),
        ("A run will take", _cost(check)),
    ):
        click.echo(f"{title}\n" + "".join(f"  {line}\n" for line in lines))


def _scene(check: Check) -> list[str]:
    scene = check.scene
    low, high = scene.corners.reshape(-1, 3).min(axis=0), scene.corners.reshape(-1, 3).max(axis=0)
    size = " x ".join(f"{length:.4g}" for length in high - low)
    return [
        f"{scene.name}: {len(scene.triangles)} triangles, {size} m (unit {scene.unit}, {scene.up} up)",
        f"{len(scene.luminaires)} point luminaires, {len(scene.observers)} observers, "
        f"{len(scene.planes)} planes",
    ]


def _materials(check: Check) -> list[str]:
    header = (
        f"{'name':20} {'faces':>7} {'area m²':>9}  reflectance  specular  exponent  luminance cd/m²  from"
    )
    return [header] + [
        f"{row.name:20} {row.faces:7d} {row.area:9.3f}  {_numbers(row.reflectance):11}  "
        f"{_numbers(row.specular):8}  {row.exponent:8g}  {_numbers(row.luminance):15}  {row.origin}"
        for row in check.materials
    ]


def _numbers(components: NDArray[Any]) -> str:
    """One number where all components are the same."""
    if components.min() == components.max():
        return f"{components[0]:.3g}"
    return " ".join(f"{c:.3g}" for c in components)


def _cost(check: Check) -> list[str]:
    return [
        f"about {check.nodes} nodes a side at an edge of {check.edge:.3g} m",
        f"about {check.seconds:.0f} s (within a factor of three), about {check.memory / 1e6:.0f} MB",
    ]
