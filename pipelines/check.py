"""``lelight check``: everything about a scene that the files and a short run on a coarse mesh tell."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from lelight.forecast import Forecast, forecast
from lelight.luminaires import have_direction
from lelight.pipelines.beginning import begin, default_out
from lelight.plan import Plan
from lelight.reading.lint import Finding, MaterialRow, lint, material_table
from lelight.scene import Scene
from lelight.settings import Settings


@dataclass(frozen=True)
class Check:
    """What a look at a scene tells.

    Attributes
    ----------
    plan : as a short run on a coarse mesh found it
    forecast : what a run is expected to take and to reach
    adaptive : whether it will refine its mesh, which no forecast sees
    """

    scene: Scene
    plan: Plan
    materials: tuple[MaterialRow, ...]
    findings: tuple[Finding, ...]
    forecast: Forecast
    adaptive: bool


def run_check(scene_path: Path, *, settings: Settings, given: Collection[str] = ()) -> Check:
    """Read, lint and plan a scene, and foretell what a run will take."""
    scene = begin(scene_path, settings, given=given)
    found, run = forecast(scene, settings)
    return Check(
        scene=scene,
        plan=run.plan,
        materials=material_table(scene),
        findings=lint(scene),
        forecast=found,
        adaptive=settings.over(scene.settings).adaptive,
    )


def draw_luminaires(scene_path: Path, scene: Scene, out: Path | None = None) -> Path | None:
    """Draw where luminaires hang and point, as ``layout.svg`` and ``luminaires.vtp``; None where none points.

    Returns
    -------
    Path : of the plan
    """
    if not have_direction(scene.luminaires):
        return None
    from lelight.writing.files import make_folder
    from lelight.writing.layout import write_layout
    from lelight.writing.vtkfiles import write_luminaires

    folder = make_folder(out if out is not None else default_out(scene_path))
    write_layout(folder / "layout.svg", scene)
    write_luminaires(folder / "luminaires.vtp", scene.luminaires)
    return folder / "layout.svg"
