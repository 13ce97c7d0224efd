"""Nothing that is not a number leaves a stage: no NaN, no infinity, and no light below zero where none can be.

Always on; one pass over an array costs a thousandth of what it took to fill it. Where something is wrong the stage
and the place are named, so that a figure is never built on it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lelight.errors import NumberError
from lelight.estimate.base import BaseField
from lelight.estimate.blocks import Batch
from lelight.field import RadianceField
from lelight.mesh.nodes import NodeMesh
from lelight.preparation import Stage
from lelight.results import ObserverValues, PlaneValues
from lelight.scene import FloatArray, Scene

#: Names a place by its number.
Named = Callable[[int], str]


def require_sound(
    values: NDArray[Any], *, stage: str, quantity: str, named: Named, negative: bool = False
) -> None:
    """Refuse numbers that are not finite, or below zero.

    Parameters
    ----------
    values : (k, ...) float
    named : names the place that a row belongs to
    negative : whether numbers may be below zero

    Raises
    ------
    NumberError
    """
    if not values.size:
        return
    with np.errstate(over="ignore", invalid="ignore"):
        # A finite sum has finite terms.
        sound = bool(np.isfinite(values.sum())) and (negative or bool(values.min() >= 0.0))
    if sound:
        return
    wrong = ~np.isfinite(values)
    if not negative:
        wrong |= values < 0.0
    if not wrong.any():
        return
    place = np.argwhere(wrong)[0]
    raise NumberError(
        f"stage {stage}: {quantity} at {named(int(place[0]))} is {float(values[tuple(place)])!r} "
        f"({np.count_nonzero(wrong.reshape(len(values), -1).any(axis=1))} of {len(values)} places); nothing was "
        "written; leave out what is extreme there, and report the scene, which is a fault of lelight"
    )


def require_sound_mesh(scene: Scene, mesh: NodeMesh) -> None:
    """Check nodes before light is estimated at them."""
    named = _node(scene, mesh)
    for quantity in ("vertices", "positions", "normals", "frames_x"):
        require_sound(getattr(mesh, quantity), stage="mesh", quantity=quantity, named=named, negative=True)
    require_sound(mesh.areas, stage="mesh", quantity="area", named=named)


def require_sound_base(scene: Scene, mesh: NodeMesh, base: BaseField) -> None:
    """Check the field that the estimate stands on."""
    require_sound(base.illuminance, stage="base", quantity="illuminance", named=_node(scene, mesh))


def require_sound_batch(scene: Scene, stage: Stage, batch: Batch) -> None:
    """Check a batch before it is added to the others; estimates may be below zero, only light may not."""
    named = _receiver(scene, stage)
    require = partial(require_sound, stage="estimate", named=named)
    require(batch.direct, quantity="direct light", negative=True)
    require(batch.indirect, quantity="indirect light", negative=True)
    glossy = np.flatnonzero(stage.receivers.degrees > 0)
    require_sound(
        batch.angular,
        stage="estimate",
        quantity="angular detail",
        named=lambda k: named(int(glossy[k])),
        negative=True,
    )


def require_sound_results(
    scene: Scene,
    field: RadianceField,
    planes: tuple[PlaneValues, ...],
    observers: tuple[ObserverValues, ...],
) -> None:
    """Check what is about to be written. The error of a single replicate is unknown, infinity."""
    require = partial(require_sound, stage="fit", named=_node(scene, field.mesh))
    values = field.values
    for quantity in ("illuminance", "direct", "scalar_illuminance"):
        require(getattr(values, quantity), quantity=quantity)
    for quantity in ("light_vector", "radiance_sh"):
        require(getattr(values, quantity), quantity=quantity, negative=True)
    if not np.all(np.isposinf(values.std_error[~field.mesh.hidden])):
        require(values.std_error, quantity="standard error")
    for plane in planes:
        _require_sound_plane(plane)
    for eye in observers:
        found = np.array([eye.direct, eye.indirect])
        named = partial(_eye, eye.observer.name)
        require_sound(found, stage="fit", quantity="illuminance", named=named, negative=True)


def require_sound_picture(luminance: FloatArray, name: str) -> None:
    """Check the pixels (k,) of a picture that lie within its frame."""
    require_sound(
        luminance,
        stage="picture",
        quantity="luminance",
        named=lambda k: f"pixel {k} of observer {name!r}",
    )


def _require_sound_plane(plane: PlaneValues) -> None:
    for quantity in ("illuminance", "cylindrical"):
        require_sound(
            getattr(plane, quantity),
            stage="fit",
            quantity=quantity,
            named=lambda k: f"point {k} of plane {plane.plane.name!r}",
        )


def _eye(name: str, _: int) -> str:
    return f"observer {name!r}"


def _node(scene: Scene, mesh: NodeMesh) -> Named:
    def named(k: int) -> str:
        where = ", ".join(f"{coordinate:.4g}" for coordinate in mesh.positions[k])
        return f"node {k}, ({where}) m on {scene.materials[mesh.materials[k]].name!r},"

    return named


def _receiver(scene: Scene, stage: Stage) -> Named:
    node = _node(scene, stage.mesh)

    def named(k: int) -> str:
        if k < len(stage.mesh):
            return node(k)
        where = ", ".join(f"{coordinate:.4g}" for coordinate in stage.receivers.points[k])
        return f"the place ({where}) m"

    return named
