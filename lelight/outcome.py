"""What the replicates found, as a field, on planes and at eyes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lelight.estimate.angular import AngularDetail, HarmonicDetail
from lelight.estimate.interpolation import InterpolationError, interpolation_error
from lelight.estimate.replicates import Replicates, pooled_error
from lelight.field import RadianceField
from lelight.harmonics.dark import without_dark
from lelight.incident import IncidentLight
from lelight.preparation import Stage
from lelight.receivers import CYLINDRICAL, ILLUMINANCE, SCALAR, VECTOR
from lelight.results import NodeValues, ObserverValues, PlaneValues
from lelight.scene import FloatArray, IntArray, Scene


def found_field(
    scene: Scene, stage: Stage, replicates: Replicates, detail: AngularDetail | None
) -> RadianceField:
    """Means over the replicates as a field."""
    nodes = slice(0, len(stage.mesh))
    direct = replicates.direct[nodes] / replicates.count
    total = direct + replicates.indirect[nodes] / replicates.count
    # An unbiased estimate of almost nothing may come out below zero; light does not.
    total[:, [ILLUMINANCE, SCALAR]] = np.maximum(total[:, [ILLUMINANCE, SCALAR]], 0.0)
    values = NodeValues(
        illuminance=total[:, ILLUMINANCE],
        std_error=np.where(stage.mesh.hidden, 0.0, std_error_of_nodes(stage, replicates)),
        direct=np.maximum(direct[:, ILLUMINANCE], 0.0),
        scalar_illuminance=total[:, SCALAR],
        light_vector=total[:, VECTOR : VECTOR + 3],
        sh_degree=_stored_degrees(stage, detail),
        radiance_sh=_radiance(stage, replicates, detail, total[:, ILLUMINANCE]),
        truncation=_truncation(stage, replicates, detail),
    )
    incident = _incident(stage, replicates) if isinstance(detail, HarmonicDetail) else None
    return RadianceField(scene, stage.mesh, values, stage.labels, stage.world, incident)


def std_error_of_nodes(stage: Stage, replicates: Replicates) -> FloatArray:
    """Tell the standard error of the illuminance of all nodes (n,), lx, each steadied by its neighbours."""
    nodes = slice(0, len(stage.mesh))
    illuminance, std_error = replicates.mean[nodes], replicates.std_error[nodes]
    return pooled_error(illuminance, std_error, stage.neighbours, areas=stage.mesh.visible_areas)


def _stored_degrees(stage: Stage, detail: AngularDetail | None) -> IntArray:
    """Degree (n,) of the coefficients of each node."""
    keeping = stage.receivers.degrees[: len(stage.mesh)] > 0
    degrees: IntArray = np.where(keeping, stage.plan.lobes[stage.mesh.materials], 0)
    return degrees if detail is None else detail.stored_degrees(degrees)


def _truncation(stage: Stage, replicates: Replicates, detail: AngularDetail | None) -> NDArray[np.float32]:
    """State what the finite degree leaves out at each node (n,), 0 where nothing is glossy."""
    errors = np.zeros(len(stage.mesh), dtype=np.float32)
    if detail is None:
        return errors
    glossy = np.flatnonzero(stage.receivers.degrees > 0)
    errors[glossy] = detail.truncation(
        replicates.angular / replicates.count,
        receivers=stage.receivers[glossy],
        reflectances=stage.world.reflectances,
    )
    return errors


def _incident(stage: Stage, replicates: Replicates) -> IncidentLight:
    """Keep the mean of the arriving light, for materials to come."""
    nodes = np.flatnonzero(stage.receivers.degrees > 0)
    coefficients = (replicates.angular / replicates.count).astype(np.float32)
    return IncidentLight(nodes, stage.receivers.degrees[nodes], coefficients)


def _radiance(
    stage: Stage, replicates: Replicates, detail: AngularDetail | None, illuminance: FloatArray
) -> NDArray[np.float32]:
    """Coefficients (n, T, C) of what the nodes reflect: a constant on Lambertian ones."""
    reflectances = stage.world.reflectances
    constant: FloatArray = (
        reflectances.diffuse[stage.mesh.materials] * illuminance / np.pi * np.sqrt(4.0 * np.pi)
    )
    if detail is None:
        return np.asarray(constant[:, None, :], dtype=np.float32)
    glossy = np.flatnonzero(stage.receivers.degrees > 0)
    fitted = detail.coefficients(
        replicates.angular / replicates.count,
        receivers=stage.receivers[glossy],
        illuminance=illuminance[glossy],
        reflectances=reflectances,
    )
    radiance: NDArray[np.float32] = np.zeros(
        (len(stage.mesh), fitted.shape[1], fitted.shape[2]), dtype=np.float32
    )
    radiance[:, 0] = constant
    radiance[glossy] = without_dark(fitted)
    return radiance


def found_on_planes(scene: Scene, stage: Stage, replicates: Replicates) -> tuple[PlaneValues, ...]:
    """Read the planes' values and replicates off the totals."""
    by_batch = np.array(replicates.in_space)
    first = 0
    planes = []
    for number, (plane, (points, shape)) in enumerate(zip(scene.planes, stage.grids, strict=True)):
        own = slice(first, first + len(points))
        at = slice(len(stage.mesh) + own.start, len(stage.mesh) + own.stop)
        further = _further(stage, number, kinds=("vertical", "surrounding", "background"))
        vertical = by_batch[:, further.pop("vertical"), ILLUMINANCE]
        planes.append(
            PlaneValues(
                plane=plane,
                shape=shape,
                points=points,
                illuminance=np.maximum(replicates.mean[at], 0.0),
                std_error=replicates.std_error[at],
                cylindrical=np.maximum(by_batch[:, own, CYLINDRICAL].mean(axis=0), 0.0),
                replicates=by_batch[:, own, ILLUMINANCE],
                cylindrical_replicates=by_batch[:, own, CYLINDRICAL],
                moment_replicates=by_batch[:, own],
                vertical_replicates=vertical.reshape(len(by_batch), len(points), -1),
                area_replicates={kind: by_batch[:, place, ILLUMINANCE] for kind, place in further.items()},
                band_replicates=_bands(replicates, own),
            )
        )
        first += len(points)
    return tuple(planes)


def found_at_probes(stage: Stage, replicates: Replicates) -> InterpolationError | None:
    """Hold what is interpolated between the nodes against what was estimated there."""
    if replicates.count < 2:
        return None
    end = len(stage.receivers) - sum(len(places.points) for places in stage.further)
    return interpolation_error(
        replicates.at_nodes,
        np.array(replicates.illuminance)[:, end - len(stage.probes) : end],
        nodes=stage.probes.nodes,
        weights=stage.probes.weights,
    )


def found_at_eyes(scene: Scene, stage: Stage, replicates: Replicates) -> tuple[ObserverValues, ...]:
    """Read the eyes' illuminances off the totals."""
    indirect = np.array(replicates.indirect_in_space)[..., ILLUMINANCE]
    moments = np.array(replicates.in_space)
    total = moments[..., ILLUMINANCE]
    first = sum(len(points) for points, _ in stage.grids)
    return tuple(
        ObserverValues(
            observer=eye,
            direct=float(np.mean(total[:, k] - indirect[:, k])),
            indirect=float(np.mean(indirect[:, k])),
            indirect_replicates=indirect[:, k],
            moment_replicates=moments[:, k],
            turned_indirect=_turned(stage, indirect, k, k - first),
            turned_total=_turned(stage, total, k, k - first),
            band_replicates=_bands(replicates, k),
        )
        for k, eye in enumerate(scene.observers, start=first)
    )


def _turned(stage: Stage, illuminance: FloatArray, own: int, number: int) -> FloatArray:
    """Illuminance (R, 24) of an eye, of its own line of sight and of those it could turn to."""
    rest = _further(stage, number, kinds=("turned",))["turned"]
    return np.concatenate([illuminance[:, [own]], illuminance[:, rest]], axis=1)


def _further(stage: Stage, owner: int, *, kinds: tuple[str, ...]) -> dict[str, slice]:
    """Where the further places of a plane or an eye stand among the receivers in space."""
    first = len(stage.receivers) - len(stage.mesh) - sum(len(places.points) for places in stage.further)
    found = {}
    for places in stage.further:
        if places.owner == owner and places.kind in kinds:
            found[str(places.kind)] = slice(first, first + len(places.points))
        first += len(places.points)
    return found


def _bands(replicates: Replicates, at: slice | int) -> FloatArray | None:
    """Illuminance in bands by batch, (R, ..., C), where the run carries spectral bands."""
    if not replicates.bands_in_space:
        return None
    return np.array([bands[at] for bands in replicates.bands_in_space])
