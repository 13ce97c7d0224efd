"""``lelight check``: everything about a scene that can be said without tracing a ray."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from lelight.luminaires import have_direction
from lelight.mesh.grading import graded
from lelight.mesh.patches import patches
from lelight.mesh.remesh import default_edge, remesh
from lelight.pipelines.beginning import begin, default_out
from lelight.plan import Plan, make_plan
from lelight.reading.lint import Finding, MaterialRow, lint, material_table
from lelight.scene import Scene
from lelight.settings import Settings

#: Rays a node took to reach a relative error of 1 on the example scenes; the square of the target divides
#: them.
RAYS_AT_UNIT_ERROR = 2.5
#: Rays a second and thread with everything around them, on the machine where the examples were measured.
RAYS_PER_SECOND = 1.3e6
#: Bytes for each node without angular detail, and for everything before the first node.
BYTES_PER_NODE, BYTES_AT_REST = 6_000, 3.5e8


@dataclass(frozen=True)
class Check:
    """What a look at the files tells.

    Attributes
    ----------
    nodes : int, vertices of the node mesh, one side
    seconds, memory : float, s and bytes that a run is expected to take
    """

    scene: Scene
    plan: Plan
    materials: tuple[MaterialRow, ...]
    findings: tuple[Finding, ...]
    edge: float
    nodes: int
    seconds: float
    memory: float


def run_check(scene_path: Path, *, settings: Settings, given: Collection[str] = ()) -> Check:
    """Read, plan, lint and remesh a scene, and foretell what a run will take."""
    scene = begin(scene_path, settings, given=given)
    settings = settings.over(scene.settings)
    plan = make_plan(scene, method=settings.method, forced=settings)
    edge = settings.edge or default_edge(scene) * settings.values.edge_scale
    labels = patches(scene)
    nodes = len(graded(remesh(scene, labels, edge=edge), scene, labels).vertices)
    rays = nodes * RAYS_AT_UNIT_ERROR / settings.target_error**2
    detail = 8 * (plan.degree + 1) ** 2 * plan.channels * 3
    return Check(
        scene=scene,
        plan=plan,
        materials=material_table(scene),
        findings=lint(scene),
        edge=edge,
        nodes=nodes,
        seconds=rays / (RAYS_PER_SECOND * settings.workers),
        memory=BYTES_AT_REST + nodes * (BYTES_PER_NODE + detail * (plan.degree > 0)),
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
