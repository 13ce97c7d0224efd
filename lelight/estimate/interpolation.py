"""Error of interpolation, measured at probe points between the nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lelight.scene import FloatArray, IntArray


@dataclass(frozen=True)
class InterpolationError:
    """What interpolated illuminance is off by between the nodes, relative to the mean illuminance.

    Relative to the mean and not to each place: in a shadow that a triangle crosses, the relative error has no
    bound and says nothing about the light in the room.

    Attributes
    ----------
    probes : int, places where it was measured
    rms : float, root mean square by area, noise of the estimates taken off
    mean : float, signed
    mean_std_error : float, of the mean, from the spread of the replicates
    """

    probes: int
    rms: float
    mean: float
    mean_std_error: float


def interpolation_error(
    at_nodes: FloatArray, at_probes: FloatArray, *, nodes: IntArray, weights: FloatArray
) -> InterpolationError | None:
    """Compare interpolated with estimated illuminance.

    Parameters
    ----------
    at_nodes : (R, n) float, lx, by each replicate
    at_probes : (R, k) float, lx, estimated at the probes by each replicate
    nodes, weights : (k, 3), what a value at each probe is interpolated from

    Returns
    -------
    InterpolationError, or None without probes, light or a second replicate
    """
    count, probes = at_probes.shape
    level = float(at_probes.mean()) if probes else 0.0
    if count < 2 or not level > 0.0:
        return None
    off = (np.einsum("kc,rkc->rk", weights, at_nodes[:, nodes]) - at_probes) / level
    noise = off.var(axis=0, ddof=1) / count
    of_replicates = off.mean(axis=1)
    return InterpolationError(
        probes=probes,
        rms=float(np.sqrt(max(0.0, np.mean(off.mean(axis=0) ** 2 - noise)))),
        mean=float(of_replicates.mean()),
        mean_std_error=float(of_replicates.std(ddof=1) / np.sqrt(count)),
    )
