"""What every command that computes does first: read, let the user's choices win, refuse the endless."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from lelight.errors import SceneError
from lelight.reading.loading import load
from lelight.scene import Scene, triangle_areas
from lelight.settings import Settings

#: Nodes of a mesh; more of them than this need tens of gigabytes.
MOST_NODES = 5e6


def begin(scene_path: Path, settings: Settings, *, given: Collection[str] = ()) -> Scene:
    """Read a scene that is about to be computed.

    Parameters
    ----------
    given : settings that the user gave; they win over the scene file's ``[calc]`` table even where they
        are the default, so the scene comes without them

    Raises
    ------
    SceneError
        where the edge that is asked for would make more nodes than a machine can hold
    """
    scene = load(scene_path)
    scene = replace(scene, settings={k: v for k, v in scene.settings.items() if k not in given})
    _refuse_endless_mesh(scene, settings.over(scene.settings).edge)
    return scene


def _refuse_endless_mesh(scene: Scene, edge: float | None) -> None:
    if edge is None:
        return
    area = float(triangle_areas(scene.corners).sum())
    nodes = area / edge / edge
    if nodes > MOST_NODES:
        found = f"an edge of {edge:g} m makes about {nodes:.1e} nodes on {area:.3g} m²"
        raise SceneError(
            f"{scene.path or scene.name}: {found}; allowed are {MOST_NODES:.0e}; "
            "give a longer --edge, or check the scene's unit"
        )


def default_out(scene_path: Path) -> Path:
    """Folder beside the scene: its stem with ``.lelight``."""
    return scene_path.with_name(f"{scene_path.stem}.lelight")
