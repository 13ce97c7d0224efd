"""What a case with a known answer is, and how a run is read against it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lelight.calculation import Calculation
from lelight.estimate.variants import Estimator
from lelight.scene import FloatArray, Scene

#: Stands for no error at all where a difference is divided by it.
TINY = 1e-300
#: How much less well than the mean a single node need be known.
NODE_SLACK = 10.0


@dataclass(frozen=True)
class Readings:
    """What a run found at k places, beside what is exact there.

    Attributes
    ----------
    labels : k names of places
    reference : (k,) float, exact values
    allowance : (k,) float >= 0, what the reference itself may be off (a disc for a plane, a quadrature)
    found, std_error : (k,) float; the error is zero where nothing is sampled
    freedom : float, degrees of freedom of the standard error
    tested : int, how many values the rows are chosen from; k where all are shown
    slack : (k,) float, factor on the case's tolerance and precision: single nodes of many are not each as
        well known as their mean
    """

    labels: tuple[str, ...]
    reference: FloatArray
    allowance: FloatArray
    found: FloatArray
    std_error: FloatArray
    freedom: float
    tested: int
    slack: FloatArray


@dataclass(frozen=True)
class Case:
    """A scene whose light is known, and how well it is to be met.

    Attributes
    ----------
    name : short, the same for ever
    group, title : heading under which it stands, and what it is
    basis : where the exact values come from
    quantity, unit : of the values
    edge, target, estimator : of the run, see `lelight.settings.Settings`
    tolerance : largest difference from the reference, as a share of it
    precision : largest standard error that still tells something, as a share of the reference
    read : takes the places' values from a run
    """

    name: str
    group: str
    title: str
    basis: str
    scene: Scene
    edge: float
    target: float
    tolerance: float
    precision: float
    read: Callable[[Calculation], Readings]
    quantity: str = "illuminance"
    unit: str = "lx"
    estimator: Estimator = "base"


def at_probes(
    labels: Sequence[str], reference: FloatArray, *, allowance: FloatArray | float = 0.0
) -> Callable[[Calculation], Readings]:
    """Read the planes of the scene, each a single point (`solids.probe`), against values (k,)."""

    def read(run: Calculation) -> Readings:
        return Readings(
            labels=tuple(labels),
            reference=np.asarray(reference, dtype=float),
            allowance=np.broadcast_to(np.asarray(allowance, dtype=float), np.shape(reference)),
            found=np.array([plane.illuminance[0] for plane in run.planes]),
            std_error=np.array([plane.std_error[0] for plane in run.planes]),
            freedom=_freedom(run),
            tested=len(labels),
            slack=np.ones(len(labels)),
        )

    return read


def sums_of_probes(
    labels: Sequence[str],
    weights: FloatArray,
    reference: FloatArray,
    *,
    allowance: FloatArray | float = 0.0,
) -> Callable[[Calculation], Readings]:
    """Read weighted sums (k, p) over the p single-point planes; their error is that of the sums by batch."""

    def read(run: Calculation) -> Readings:
        by_batch = np.column_stack([plane.replicates[:, 0] for plane in run.planes]) @ weights.T
        return Readings(
            labels=tuple(labels),
            reference=np.asarray(reference, dtype=float),
            allowance=np.broadcast_to(np.asarray(allowance, dtype=float), np.shape(reference)),
            found=by_batch.mean(axis=0),
            std_error=by_batch.std(axis=0, ddof=1) / np.sqrt(len(by_batch)),
            freedom=_freedom(run),
            tested=len(labels),
            slack=np.ones(len(labels)),
        )

    return read


def _freedom(run: Calculation) -> float:
    return len(run.planes[0].replicates) - 1.0


def at_nodes(
    run: Calculation,
    reference: Callable[[FloatArray, FloatArray], FloatArray],
    *,
    allowance: float = 0.0,
    places: dict[str, tuple[float, float, float]] | None = None,
) -> Readings:
    """Read all visible nodes, and show the mean, the worst nodes and those nearest to some places.

    Parameters
    ----------
    reference : exact illuminance (n,) for positions and normals (n, 3)
    allowance : float, lx, what it may be off
    places : label and coordinates (m); the node nearest to each is shown
    """
    mesh = run.field.mesh
    seen = np.flatnonzero(~mesh.hidden)
    areas, positions = mesh.areas[seen], mesh.positions[seen]
    # The errors that a run states; a node's own spread alone misses what hardly any of its few rays has met.
    found, std_error = run.replicates.mean[seen], run.field.std_error[seen]
    exact = np.broadcast_to(reference(positions, mesh.normals[seen]), found.shape)
    off = np.maximum(np.abs(found - exact) - allowance, 0.0)
    rows = {
        f"largest |t| of {len(found)} nodes": np.argmax(off / np.maximum(std_error, TINY)),
        "largest difference of a node": np.argmax(off / exact),
    }
    for label, place in (places or {}).items():
        rows[label] = np.argmin(np.linalg.norm(positions - np.array(place), axis=1))
    chosen = np.array(list(rows.values()))
    means = np.average(np.array(run.replicates.at_nodes)[:, seen], axis=1, weights=areas)
    return Readings(
        labels=("mean over the surface", *rows),
        reference=np.append(np.average(exact, weights=areas), exact[chosen]),
        allowance=np.full(len(rows) + 1, allowance),
        found=np.append(means.mean(), found[chosen]),
        std_error=np.append(means.std(ddof=1) / np.sqrt(len(means)), std_error[chosen]),
        freedom=run.replicates.count - 1.0,
        tested=len(found) + 1,
        slack=np.append(1.0, np.full(len(rows), NODE_SLACK)),
    )
