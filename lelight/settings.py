"""How a run is to be done: what the user asked for, and what stands in where nothing was asked."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal

from lelight.dial import edge_scale
from lelight.dialvalues import DRAFT
from lelight.estimate.variants import Estimator
from lelight.harmonics.hemigrid import Extension
from lelight.plan import Forced, Method

Preset = Literal["draft", "normal", "fine"]


@dataclass(frozen=True)
class PresetValues:
    """What a preset stands for.

    Attributes
    ----------
    target : float, relative standard error (root mean square over the visible nodes by area)
    picture_size, picture_samples : int, pixels across an observer's picture and rays a pixel
    """

    target: float
    picture_size: int
    picture_samples: int


PRESETS: dict[Preset, PresetValues] = {
    "draft": PresetValues(DRAFT, picture_size=500, picture_samples=1),
    "normal": PresetValues(0.02, picture_size=800, picture_samples=4),
    "fine": PresetValues(0.01, picture_size=1000, picture_samples=9),
}


@dataclass(frozen=True)
class Settings(Forced):
    """The choices of a run, and those of its plan that are forced.

    Attributes
    ----------
    target : float or None; relative standard error to reach, None for the preset's
    time : float or None; seconds for the estimate, after which it stops
    method : how glossy nodes keep angular detail
    edge : float or None; edge length of the node mesh in m, None for the scene's size and the preset
    directions : int or None; directions of the hemisphere grid, only for method ``grid``
    extension : how the fit to that grid goes on below the horizon
    seed : int, of the random numbers but those that tell which sides have nodes, see `lelight.placement`
    threads : int
    memory : float or None; bytes that the run may take, None for a share of what is free
    cluster : str or None; address of the Dask scheduler whose workers take part, see `lelight.cluster`
    batches : int or None; exactly so many replicates, without doubling, instead of a target
    adaptive : refine the mesh where light is not linear over its triangles
    estimator : ``base`` gathers a first field and lets chains carry what it lacks; ``emitters`` lets chains
        from the emitters carry everything; ``paths`` has no chains. They are unbiased, their speed differs.
        The others of `lelight.estimate.variants` are for comparison.
    """

    target: float | None = None
    time: float | None = None
    preset: Preset = "normal"
    method: Method = "sh"
    edge: float | None = None
    directions: int | None = None
    extension: Extension = "least_squares"
    seed: int = 0
    threads: int = 0
    memory: float | None = None
    cluster: str | None = None
    batches: int | None = None
    adaptive: bool = False
    estimator: Estimator = "base"

    @property
    def values(self) -> PresetValues:
        """What the preset stands for."""
        return PRESETS[self.preset]

    @property
    def target_error(self) -> float:
        """Relative standard error to reach."""
        return self.target if self.target is not None else self.values.target

    @property
    def edge_scale(self) -> float:
        """Edge of the node mesh against the default of the scene's size: what goes with the target."""
        return edge_scale(self.target_error)

    @property
    def workers(self) -> int:
        """Threads to use; all that this process may run on where none were asked for."""
        return self.threads or len(os.sched_getaffinity(0))

    def over(self, table: Mapping[str, Any]) -> Settings:
        """Take what is set here, and the scene file's ``[calc]`` table where it is not."""
        default = Settings()
        known = {f.name for f in fields(Settings)}
        taken = {
            key: value
            for key, value in table.items()
            if key in known and value is not None and getattr(self, key) == getattr(default, key)
        }
        return replace(self, **taken)

    def as_table(self) -> dict[str, Any]:
        """Plain mapping for files."""
        return asdict(self)
