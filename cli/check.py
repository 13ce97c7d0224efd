"""``lelight check``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from lelight.cli.options import SCENE, NamedPath, run_options
from lelight.luminaires import have_direction
from lelight.photometry.zones import luminous_flux
from lelight.pipelines.check import Check, draw_luminaires, run_check
from lelight.plan import Decision
from lelight.scene import PointLuminaire
from lelight.settings import Settings

#: Where the plane C0 lies in LM-63 and in EULUMDAT files.
C0_RULES = ("its C0 is the zero plane of LM-63, along the length", "its C0 lies across the lamp axis")


@click.command()
@SCENE
@click.option("-o", "--out", type=NamedPath(), help="Folder of layout.svg. Default: SCENE's stem.lelight.")
@run_options
def command(scene: Path, out: Path | None, **chosen: Any) -> None:
    """Read SCENE and run it shortly on a coarse mesh: the plan, the materials, the lint, and what a run will take.

    Draws where luminaires hang and point: layout.svg and luminaires.vtp.
    """
    given = {name: value for name, value in chosen.items() if value is not None}
    check = run_check(scene, settings=Settings(**given), given=given)
    for title, lines in (
        ("Scene", _scene(check)),
        ("Plan", [_decided(d) for d in check.plan.decisions]),
        ("Materials", _materials(check)),
        *([("Luminaires", _luminaires(check))] if have_direction(check.scene.luminaires) else []),
        ("Lint", [f"{f.severity}: {f.rule}: {f.text}" for f in check.findings] or ["nothing found"]),
        ("A run will take", _cost(check)),
    ):
        click.echo(f"{title}\n" + "".join(f"  {line}\n" for line in lines))
    drawn = draw_luminaires(scene, check.scene, out)
    if drawn is not None:
        click.echo(f"luminaires drawn in {drawn}")


def _decided(decision: Decision) -> str:
    cost = f" [{decision.cost}]" if str(decision.cost) else ""
    return f"{decision.name}: {decision.value} ({decision.reason}){cost}"


def _scene(check: Check) -> list[str]:
    scene = check.scene
    low, high = scene.corners.reshape(-1, 3).min(axis=0), scene.corners.reshape(-1, 3).max(axis=0)
    photometric = sum(not isinstance(lamp, PointLuminaire) for lamp in scene.luminaires)
    points = len(scene.luminaires) - photometric
    size = " x ".join(f"{length:.4g}" for length in high - low)
    return [
        f"{scene.name}: {len(scene.triangles)} triangles, {size} m (unit {scene.unit}, {scene.up} up)",
        f"{points} point luminaires, "
        + (f"{photometric} photometric luminaires, " if photometric else "")
        + f"{len(scene.observers)} observers, {len(scene.planes)} planes",
    ]


def _luminaires(check: Check) -> list[str]:
    """Say where each luminaire hangs and points; files are told once."""
    lines = []
    for lamp in check.scene.luminaires:
        place = f"{lamp.name:20} at {_vector(lamp.position)} m"
        if isinstance(lamp, PointLuminaire):
            lines.append(f"{place}, isotropic, {_numbers(lamp.intensity)} cd")
            continue
        lines.append(
            f"{place}, aim {_vector(lamp.aim)}, C0 {_vector(lamp.axes[0])}, {lamp.path}, "
            f"{lamp.factor * luminous_flux(lamp.photometry):.0f} lm"
        )
    used = {lamp.path: lamp for lamp in check.scene.luminaires if not isinstance(lamp, PointLuminaire)}
    for path, lamp in used.items():
        opening = lamp.photometry.opening
        lines.append(
            f"{path}: {lamp.photometry.format}, opening {opening.along_c0:g} m along C0, {opening.along_c90:g} m "
            f"along C90; {C0_RULES[lamp.photometry.format == 'EULUMDAT']}; give c0 to turn it"
        )
    return lines


def _vector(vector: NDArray[Any]) -> str:
    return "(" + ", ".join(f"{component + 0.0:.3g}" for component in np.round(vector, 6)) + ")"


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
    found = check.forecast
    lines = [
        f"about {found.nodes:.0f} nodes at an edge of {found.edge:.3g} m",
        f"about {found.seconds:.0f} s to a relative standard error of {found.error:.2%}, "
        f"and {found.memory / 1e6:.0f} MB",
    ]
    if check.adaptive:
        lines.append(
            "and what --adaptive adds, which shows only as it cuts the mesh: often several times as much"
        )
    return lines
