"""Every figure of a run as ``metrics.json`` holds it."""

from __future__ import annotations

from typing import Any

from lelight.calculation import Calculation
from lelight.channels import luminance_weighted
from lelight.metrics.table import metrics, observer_figures, plane_figures, room_figures
from lelight.pipelines.eyes import Sight, glare_share


def figures(run: Calculation, sights: tuple[Sight, ...], stems: dict[str, dict[str, str]]) -> dict[str, Any]:
    """Rate planes, observers and the room.

    Parameters
    ----------
    stems : by ``planes`` and ``observers``, the file stem of each name
    """
    target_ugr = min((p.target["ugr"] for p in run.scene.planes if "ugr" in p.target), default=None)
    observers = {
        values.observer.name: observer_figures(
            values, sight.sources, target_ugr=target_ugr, picture=sight.glare
        )
        for values, sight in zip(run.observers, sights, strict=True)
    }
    planes = {values.plane.name: plane_figures(values) for values in run.planes}
    table = metrics(planes, observers, room=_room(run))
    for values in run.planes:
        rows, columns = values.shape
        entry = table["planes"][values.plane.name]
        entry["file"] = stems["planes"][values.plane.name]
        entry["grid"] = {"rows": rows, "columns": columns}
    for sight in sights:
        table["observers"][sight.observer.name] |= _observer(sight, stems["observers"])
    return table


def _observer(sight: Sight, stems: dict[str, str]) -> dict[str, Any]:
    return {
        "file": stems[sight.observer.name],
        "position": sight.observer.position.tolist(),
        "direction": sight.observer.direction.tolist(),
        "sources": [
            source.to_json() | {"share": glare_share(source, sight.sources)} for source in sight.sources
        ],
    }


def _room(run: Calculation) -> dict[str, Any]:
    field = run.field
    return room_figures(
        field.mesh.areas,
        field.illuminance,
        luminance_weighted(field.reflected_exitance),
        field.mesh.hidden,
        run.replicates.at_nodes,
    )
