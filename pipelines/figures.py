"""Every figure of a run as ``metrics.json`` holds it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lelight.calculation import Calculation
from lelight.channels import luminance_weighted
from lelight.metrics.colour_figures import colour_figures, without_spectra
from lelight.metrics.exceptional import exceptional_figures
from lelight.metrics.eye import eye_figures, further_picture_figures
from lelight.metrics.figure import Figure
from lelight.metrics.grid import grid_rule
from lelight.metrics.outdoor import outdoor_figures
from lelight.metrics.surfaces import kinds_of, surface_figures
from lelight.metrics.sweep import largest, rose
from lelight.metrics.table import metrics, observer_figures, plane_figures, room_figures
from lelight.metrics.zones import zone_figures
from lelight.pipelines.eyes import Sight, glare_share
from lelight.pipelines.lamps import ceiling_coverage, lamps_of, maintenance_figure, source_illuminances
from lelight.results import ObserverValues, PlaneValues
from lelight.scene import FloatArray, Spectrum


def figures(run: Calculation, sights: tuple[Sight, ...], stems: dict[str, dict[str, str]]) -> dict[str, Any]:
    """Rate planes, observers and the room.

    Parameters
    ----------
    stems : by ``planes`` and ``observers``, the file stem of each name
    """
    lamps = lamps_of(run.field)
    observers = {
        values.observer.name: _observer_figures(run, values, sight, lamps)
        for values, sight in zip(_looking(run, sights), sights, strict=True)
    }
    planes = {values.plane.name: _plane_figures(values, lamps) for values in run.planes}
    table = metrics(planes, observers, room=_room(run))
    for values in run.planes:
        table["planes"][values.plane.name] |= _plane(values, stems["planes"])
    for sight, seen in zip(sights, _looking(run, sights), strict=True):
        name = sight.observer.name
        table["observers"][name] |= _observer(sight, stems["observers"])
        table.setdefault("views", {})[name] = _view(sight, seen)
    return table


def _looking(run: Calculation, sights: tuple[Sight, ...]) -> tuple[ObserverValues, ...]:
    """Observers that took a picture: all, or none where the plan leaves pictures out."""
    return run.observers if sights else ()


def _plane_figures(values: PlaneValues, lamps: Spectrum | None) -> dict[str, Figure]:
    bands = None if values.band_replicates is None else values.band_replicates.mean(axis=1)
    return plane_figures(values) | _colour(bands, lamps, values.plane.target.get("ra"))


def _colour(bands: FloatArray | None, lamps: Spectrum | None, target_ra: float | None) -> dict[str, Figure]:
    if bands is None or lamps is None:
        return without_spectra()
    return colour_figures(bands, lamps, target_ra=target_ra)


def _observer_figures(
    run: Calculation, values: ObserverValues, sight: Sight, lamps: Spectrum | None
) -> dict[str, Figure]:
    target_ugr = _strictest(run, "ugr", least=True)
    found = observer_figures(values, sight.sources, target_ugr=target_ugr, picture=sight.glare)
    found |= further_picture_figures(sight.glare, values.indirect_replicates)
    if values.turned_indirect is not None:
        petals = rose(sight.turned, values.turned_indirect)
        found["ugr_max"] = largest(petals, batches=len(values.turned_indirect), target=target_ugr)
    coverage = ceiling_coverage(run.field)
    found |= exceptional_figures(values, sight.sources, ceiling_coverage=coverage)
    found |= eye_figures(values) | zone_figures(sight.zones) | _outdoor(run, values)
    return found | _colour(values.band_replicates, lamps, None)


def _outdoor(run: Calculation, values: ObserverValues) -> dict[str, Figure]:
    outdoor = run.scene.outdoor
    if outdoor is None:
        return {}
    (ground,) = [each.replicates for each in run.planes if each.plane.name == outdoor.plane]
    illuminance, directions = source_illuminances(run.field, values.observer)
    return outdoor_figures(values.observer, illuminance, directions, ground, outdoor)


def _plane(values: PlaneValues, stems: Mapping[str, str]) -> dict[str, Any]:
    """Say beside a plane's figures which file and which grid they are of."""
    rows, columns = values.shape
    plane = values.plane
    lengths = float(np.linalg.norm(plane.u)), float(np.linalg.norm(plane.v))
    return {
        "file": stems[plane.name],
        "grid": {"rows": rows, "columns": columns, "rule": grid_rule(*lengths), "wall_band": plane.wall_band},
    }


def _view(sight: Sight, values: ObserverValues) -> dict[str, Any]:
    """Gather what is no single figure: UGR by bearing, luminance statistics, and the distribution (research)."""
    petals = [] if values.turned_indirect is None else rose(sight.turned, values.turned_indirect)
    return {"rose": petals, "luminance": sight.zones, "distribution": sight.distribution}


def _observer(sight: Sight, stems: Mapping[str, str]) -> dict[str, Any]:
    return {
        "file": stems[sight.observer.name],
        "position": sight.observer.position.tolist(),
        "direction": sight.observer.direction.tolist(),
        "sources": [
            source.to_json() | {"share": glare_share(source, sight.sources)} for source in sight.sources
        ],
    }


def _room(run: Calculation) -> dict[str, Figure]:
    field = run.field
    replicates = run.replicates.at_nodes
    found = room_figures(
        field.mesh.areas,
        field.illuminance,
        luminance_weighted(field.reflected_exitance),
        field.mesh.hidden,
        replicates,
    )
    return found | _surfaces(run, replicates) | {"maintenance_factor": maintenance_figure(run.scene)}


def _surfaces(run: Calculation, replicates: FloatArray) -> dict[str, Figure]:
    """Walls, ceiling and floor; hidden nodes are not there."""
    mesh = run.field.mesh
    emits = np.array([material.emits for material in run.scene.materials])[mesh.materials]
    kinds = kinds_of(mesh.positions, mesh.normals, mesh.patches, emits=emits | mesh.hidden)
    targets = {
        key: found
        for key in ("wall_illuminance", "ceiling_illuminance")
        if (found := _strictest(run, key, least=False)) is not None
    }
    return surface_figures(kinds, mesh.areas, replicates, targets=targets)


def _strictest(run: Calculation, key: str, *, least: bool) -> float | None:
    """Strictest of what the planes require."""
    asked = [plane.target[key] for plane in run.scene.planes if key in plane.target]
    if not asked:
        return None
    return min(asked) if least else max(asked)
