"""Tables of a scene file and what each key allows.

Positions and directions are in scene axes, z up, whatever axes and unit the OBJ has; positions are in m.
"""

from __future__ import annotations

import difflib
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)
from pydantic_core import PydanticCustomError

from lelight import plan
from lelight.estimate.variants import Estimator
from lelight.harmonics.hemigrid import Extension
from lelight.metrics.en12464_tasks import TASKS
from lelight.metrics.grid import cell_counts
from lelight.reading.quantities import (
    Band,
    Colour,
    Direction,
    Exponent,
    Flux,
    Length,
    MemorySize,
    Position,
    Positive,
    Reflectance,
    RelativeError,
    Seconds,
    Share,
    Spacing,
    SpectralReflectance,
    Threshold,
    number,
)
from lelight.storeddegree import LARGEST_DEGREE, LARGEST_STORED_EXPONENT, Mirrors

Unit = Literal["m", "cm", "mm", "in", "ft"]
UpAxis = Literal["z", "y"]

#: Shortest edge of a measuring plane in m.
SHORTEST_EDGE = 1e-6

#: Most rows and columns of an array of luminaires.
MOST_ROWS = 1000

#: Points of a plane's grid; a square kilometre has as many at the largest spacing of 10 m.
MOST_GRID_POINTS = 10_000


class Table(BaseModel):
    """A TOML table that knows its keys and names the nearest one to a slip of the pen."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _keys_are_known(cls, table: Any) -> Any:
        allowed = list(cls.model_fields)
        for key in table if isinstance(table, dict) else ():
            if key not in allowed:
                near = difflib.get_close_matches(str(key)[:60], allowed, n=2, cutoff=0.6)
                meant = f"did you mean {' or '.join(near)}? " if near else ""
                reason = f"{meant}allowed are {', '.join(allowed)}"
                raise PydanticCustomError("unknown_key", "{reason}", {"reason": reason, "key": key})
        return table


Name = Annotated[str, Field(min_length=1)]


class MaterialTable(Table):
    """Overrides of the materials that a pattern matches; keys that are absent leave theirs alone."""

    reflectance: SpectralReflectance | None = None
    specular: Reflectance | None = None
    exponent: Exponent | None = None
    luminance: Colour | None = None
    flux: Flux | None = None
    sides: Literal["front", "both"] | None = None
    spectrum: Name | None = None

    @model_validator(mode="after")
    def _one_emission(self) -> Self:
        if self.luminance is not None and self.flux is not None:
            raise ValueError("allowed is luminance or flux, not both")
        return self


class LuminaireTable(Table):
    """A luminaire, or an array of them; ``aim`` and ``c0`` turn its photometry."""

    name: Annotated[str, Field(min_length=1)]
    position: Position
    intensity: Colour | None = None
    photometry: str | None = None
    aim: Direction = (0.0, 0.0, -1.0)
    c0: Direction = (1.0, 0.0, 0.0)
    dimming: Share = 1.0
    maintenance: Share = 1.0
    housing: Annotated[str, Field(min_length=1)] | None = None
    rows: Annotated[int, Field(ge=1, le=MOST_ROWS)] = 1
    columns: Annotated[int, Field(ge=1, le=MOST_ROWS)] = 1
    spacing: Spacing | None = None
    spectrum: Name | None = None

    @model_validator(mode="after")
    def _one_light(self) -> Self:
        if (self.intensity is None) == (self.photometry is None):
            raise ValueError("allowed is one of intensity (cd) and photometry (a file)")
        return self

    @model_validator(mode="after")
    def _array_is_spaced(self) -> Self:
        if self.rows * self.columns > 1 and self.spacing is None:
            raise ValueError("rows and columns need spacing, m: one number, or two along x and y")
        return self

    @property
    def spacings(self) -> tuple[float, float]:
        """Distances in m of columns along x and of rows along y."""
        return self.spacing or (0.0, 0.0)


class ObserverTable(Table):
    """An eye and where it looks."""

    name: Annotated[str, Field(min_length=1)]
    position: Position
    direction: Direction
    task: Position | None = None
    threshold: Threshold | None = None


class TargetTable(Table):
    """What a plane is required to reach; ``task`` takes what EN 12464-1 asks for that is not given."""

    task: Name | None = None
    mean_illuminance: Positive | None = None
    uniformity: Share | None = None
    ugr: Positive | None = None
    mean_cylindrical_illuminance: Positive | None = None
    cylindrical_uniformity: Share | None = None
    wall_illuminance: Positive | None = None
    ceiling_illuminance: Positive | None = None
    ra: Positive | None = None

    @model_serializer(mode="wrap")
    def _given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: asked for key, asked in handler(self).items() if asked is not None}

    @model_validator(mode="after")
    def _task_is_known(self) -> Self:
        if self.task is not None and self.task not in TASKS:
            near = difflib.get_close_matches(self.task[:60], TASKS, n=1)
            meant = f"did you mean {near[0]}? " if near else ""
            raise ValueError(f"no such task; {meant}allowed are {', '.join(TASKS)}")
        return self


class PlaneTable(Table):
    """A rectangle to measure on: a corner and two edge vectors."""

    name: Annotated[str, Field(min_length=1)]
    origin: Position
    u: Direction
    v: Direction
    target: TargetTable = TargetTable()
    wall_band: Band = 0.0
    surrounding: Band = 0.0
    background: Band = 0.0

    @model_validator(mode="after")
    def _has_area(self) -> Self:
        u, v = np.array(self.u), np.array(self.v)
        lengths = np.linalg.norm(u), np.linalg.norm(v)
        if min(lengths) < SHORTEST_EDGE:
            raise ValueError(
                f"u or v is shorter than {SHORTEST_EDGE:g} m; allowed are edges that span a rectangle"
            )
        if np.linalg.norm(np.cross(u, v)) < 1e-6 * np.prod(lengths):
            raise ValueError("u and v are parallel; allowed are edges that span a rectangle")
        lengths = lengths[0] - 2 * self.wall_band, lengths[1] - 2 * self.wall_band
        if min(lengths) < SHORTEST_EDGE:
            raise ValueError(
                f"wall_band {self.wall_band:g} m leaves nothing of it; allowed is a narrower one"
            )
        columns, rows = cell_counts(float(lengths[0]), float(lengths[1]))
        if columns * rows > MOST_GRID_POINTS:
            raise ValueError(
                f"its grid (EN 12464-1) has {columns * rows} points; allowed are {MOST_GRID_POINTS}; "
                "give a shorter or a less slender plane"
            )
        return self


Count = Annotated[int, Field(ge=1, le=2**31)]


class CalcTable(Table):
    """Expert keys of the calculation; what is absent is for the command line and the plan to say.

    ``target`` is a relative standard error, ``time`` is in s, ``edge`` in m. From ``colour`` on they are decisions of
    the plan, see `lelight.plan.Forced`.
    """

    target: RelativeError | None = None
    time: Seconds | None = None
    preset: Literal["draft", "normal", "fine"] | None = None
    method: plan.Method | None = None
    edge: Length | None = None
    seed: Annotated[int, Field(ge=0, lt=2**63)] | None = None
    threads: Count | None = None
    memory: MemorySize | None = None
    estimator: Estimator | None = None
    adaptive: bool | None = None
    batches: Annotated[Count, Field(ge=2)] | None = None
    directions: Annotated[int, Field(ge=16, le=2**16)] | None = None
    extension: Extension | None = None
    relightable: Annotated[float, number(0, LARGEST_STORED_EXPONENT)] | None = None
    colour: plan.Colour | None = None
    degree: Annotated[int, Field(ge=0, le=LARGEST_DEGREE)] | None = None
    angular: plan.Angular | None = None
    mirrors: Mirrors | None = None
    sides: plan.Sides | None = None
    indirect: bool | None = None
    residual: bool | None = None
    emitters: plan.Lamps | None = None
    pictures: bool | None = None


class OutdoorTable(Table):
    """What the glare rating of outdoor areas needs: the plane on the ground and its reflectance."""

    plane: Name
    reflectance: Annotated[float, number(0, 1)]


class SceneTables(Table):
    """A whole scene file."""

    geometry: str | None = None
    unit: Unit = "m"
    up: UpAxis = "z"
    materials: dict[str, MaterialTable] = {}
    luminaires: list[LuminaireTable] = []
    observers: list[ObserverTable] = []
    planes: list[PlaneTable] = []
    outdoor: OutdoorTable | None = None
    calc: CalcTable = CalcTable()

    @model_validator(mode="after")
    def _names_are_unique(self) -> Self:
        for kind, tables in (("observers", self.observers), ("planes", self.planes)):
            names = [table.name for table in tables]
            repeated = next((name for name in names if names.count(name) > 1), None)
            if repeated is not None:
                reason = "a name that is given twice; allowed are different names"
                raise PydanticCustomError(
                    "repeated", "{reason}", {"reason": reason, "key": kind, "name": repeated}
                )
        return self

    @model_validator(mode="after")
    def _ground_is_known(self) -> Self:
        planes = [plane.name for plane in self.planes]
        if self.outdoor is not None and self.outdoor.plane not in planes:
            reason = f"no such plane; allowed are {', '.join(planes) or 'none: add [[planes]]'}"
            raise PydanticCustomError(
                "unknown", "{reason}", {"reason": reason, "key": "outdoor", "name": self.outdoor.plane}
            )
        return self
