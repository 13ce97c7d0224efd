"""Fitting a run into a budget of time: edge, batches and reserve from a short run on a coarse mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lelight.calculation import Pace
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import form_of
from lelight.forecast import dialled, pilot_run
from lelight.mesh.remesh import default_edge
from lelight.scene import Scene
from lelight.settings import Settings

#: A shorter budget is no time for a pilot.
LEAST_TIME = 4.0


@dataclass(frozen=True)
class _Dialled:
    """What the pilot decided: edge in m, rays a second, seconds beside the estimate and after it."""

    edge: float
    ray_rate: float
    before: float
    reserve: float


def paced(scene: Scene, settings: Settings, keep: Keeper, *, spent: float) -> tuple[Settings, Pace | None]:
    """Settle the edge of a run with a budget, and how it shall go by the clock; decided once, and kept.

    Parameters
    ----------
    spent : s that went before the clock of the run
    """
    whole = settings.over(scene.settings)
    if whole.time is None or whole.batches is not None:
        return settings, None
    if whole.time < LEAST_TIME:
        return settings, Pace(reserve=spent)

    def dial() -> _Dialled:
        pilot, _ = pilot_run(scene, settings)
        keep.clock.lap("pilot")
        default = default_edge(scene)
        left = max(whole.time - spent - pilot.seconds, 0.0) if whole.time else 0.0
        edge = whole.edge
        if edge is None:
            pilot, edge = dialled(pilot, scene, left)
        if whole.edge is None and whole.target is not None:
            edge = max(edge, default * whole.edge_scale)
        beside = pilot.fixed(edge) + pilot.seconds
        return _Dialled(edge, pilot.ray_rate, beside + spent, pilot.writing + spent)

    found = keep.once("dial", dial, form_of(_Dialled))
    return replace(settings, edge=found.edge), Pace(found.ray_rate, found.before, found.reserve)
