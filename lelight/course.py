"""The course of an estimate: what has been added up, the steps that led there, and how to keep both."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lelight.checkpoint.records import Form, Record, form_of
from lelight.estimate.blocks import Batch
from lelight.estimate.replicates import ErrorReached, Replicates
from lelight.receivers import MOMENTS, Receivers

#: Lists of `Replicates` that hold an array a replicate.
BY_REPLICATE = ("illuminance", "in_space", "indirect_in_space", "bands_in_space")
#: Its arrays, and its numbers and texts.
TOTALS = ("direct", "indirect", "angular")
COUNTS = ("first_in_space", "doublings", "vertices", "rays", "seconds", "step", "done", "units")


@dataclass(frozen=True)
class Standing:
    """Where a run stands.

    Attributes
    ----------
    replicates, doublings : int; independent scrambles, and how often each has doubled its sequences
    rays : int so far
    seconds : float since the run began
    error : reached so far, None before there are two replicates
    target : float
    """

    replicates: int
    doublings: int
    rays: int
    seconds: float
    error: ErrorReached | None
    target: float


@dataclass
class Course:
    """An estimate under way; what it does next depends on nothing else.

    Attributes
    ----------
    replicates : totals so far
    began : seconds after which the estimate began
    convergence : where it stood after each step. A step that is decided by the clock is decided once: a run that
        goes on finds it here, or in the replicates as the step under way.
    """

    replicates: Replicates
    began: float
    convergence: list[Standing] = field(default_factory=list)


def course_form(receivers: Receivers, *, width: int, channels: int) -> Form[Course]:
    """Form of the course of an estimate at these receivers.

    Parameters
    ----------
    width : of what glossy receivers keep of angular distributions, 0 for nothing
    """
    count, glossy = len(receivers), int(np.count_nonzero(receivers.degrees > 0)) if width else 0
    moments = (count, MOMENTS, channels)
    shapes = {"direct": moments, "indirect": moments, "angular": (glossy, width, channels)}

    def unpack(record: Record) -> Course:
        course = _unpacked(record)
        held: list[Any] = [course.replicates, course.replicates.halfway]
        for totals in held if course.replicates.count else held[1:]:
            for name, shape in shapes.items() if totals is not None else ():
                if getattr(totals, name).shape != shape:
                    raise ValueError(name)
        if any(light.shape != (count,) for light in course.replicates.illuminance):
            raise ValueError("illuminance")
        return course

    return Form(packed, unpack)


def packed(course: Course) -> Record:
    """Record of a course as it is now; arrays are not copied."""
    replicates = course.replicates
    values: dict[str, Any] = {name: getattr(replicates, name) for name in COUNTS}
    arrays: dict[str, NDArray[Any]] = {name: getattr(replicates, name) for name in TOTALS}
    for name in BY_REPLICATE:
        arrays |= {f"{name}.{k}": array for k, array in enumerate(getattr(replicates, name))}
    values["halfway"] = None
    if replicates.halfway is not None:
        halfway = form_of(Batch).pack(replicates.halfway)
        values["halfway"] = halfway.values
        arrays |= {f"halfway.{name}": array for name, array in halfway.arrays.items()}
    values["began"] = course.began
    values["convergence"] = [asdict(standing) for standing in course.convergence]
    return Record(values, arrays)


def _unpacked(record: Record) -> Course:
    values, arrays = record.values, record.arrays
    replicates = Replicates(**{name: values[name] for name in COUNTS})
    for name in TOTALS:
        setattr(replicates, name, arrays[name])
    for name in BY_REPLICATE:
        count = sum(key.startswith(f"{name}.") for key in arrays)
        setattr(replicates, name, [arrays[f"{name}.{k}"] for k in range(count)])
    if values["halfway"] is not None:
        inner = {key.removeprefix("halfway."): array for key, array in arrays.items()}
        replicates.halfway = form_of(Batch).unpack(Record(values["halfway"], inner))
    return Course(replicates, float(values["began"]), [_standing(row) for row in values["convergence"]])


def _standing(row: dict[str, Any]) -> Standing:
    error = row["error"]
    return Standing(**{**row, "error": None if error is None else ErrorReached(**error)})
