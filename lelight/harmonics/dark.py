"""No light below zero over the horizon, by projections in turn.

A series that ends at some degree rings, and an unbiased estimate of little light scatters about it; either may leave
directions in which a surface would take light away. Light that is nowhere below zero, and light of a degree, are two
convex sets: going from the nearest of the one to the nearest of the other leads to what is both, and every step leads
nearer to all light that is, so that errors shrink (L. G. Gubin, B. T. Polyak, E. V. Raik, USSR Comp. Math. 7(6), 1967).
"""

from __future__ import annotations

import ducc0
import numpy as np

from lelight.harmonics.indices import degree_of, degrees, terms
from lelight.harmonics.moments import plane
from lelight.harmonics.transform import complex_form, real_form
from lelight.scene import FloatArray

#: Least radiance on the grid that is left as it is, as share of the peak; in between nothing is below -1e-3 then.
LEAST_SHARE = -8e-4
#: Rows of directions a degree, pole to pole: sixteen in a ripple.
ROWS_PER_DEGREE = 8
#: Lifting ends where nothing on the grid is below this share of the peak.
LIFTED_SHARE = -2e-4
#: Steps in turn at most, and how far they go beyond the nearest light without anything below zero (1: not).
MOST_STEPS, RELAXATION = 30, 1.8
ZENITH = np.array([0.0, 0.0, 1.0])


def without_dark(radiance: FloatArray) -> FloatArray:
    """Lift expansions that go below `LEAST_SHARE` of their peak over the horizon, to `LIFTED_SHARE` at least.

    Their luminous exitance stays; where even that is not above zero nothing is left.

    Parameters
    ----------
    radiance : (k, T, C) float, local frames

    Returns
    -------
    (k, T, C) float, a copy; all that is nowhere dark has its own bits
    """
    bright = np.array(radiance)
    if bright.shape[1] == 1:
        return bright
    for node, channel in np.argwhere(_least_bound(bright) < 0.0):
        own = bright[node, :, channel]
        used = int(degrees(degree_of(len(own)))[np.flatnonzero(own).max(initial=0)])
        bright[node, : terms(used), channel] = _lifted(own[: terms(used)], used)
    return bright


def _least_bound(radiance: FloatArray) -> FloatArray:
    """Bound from below (k, C) by the largest value that each degree can have (addition theorem)."""
    degree = degree_of(radiance.shape[1])
    starts = np.arange(degree + 1) ** 2
    sizes = np.sqrt(np.add.reduceat(np.square(radiance, dtype=np.float64), starts, axis=1))
    largest = sizes * np.sqrt((2.0 * np.arange(degree + 1) + 1.0) / (4.0 * np.pi))[:, None]
    return np.asarray(radiance[:, 0] / np.sqrt(4.0 * np.pi) - largest[:, 1:].sum(axis=1))


def _lifted(radiance: FloatArray, degree: int) -> FloatArray:
    """Do as `without_dark` for one expansion (T,)."""
    seen = _on_grid(radiance, degree)
    if _is_above(seen, LEAST_SHARE):
        return radiance
    mean = _mean(radiance)
    if mean <= 0.0:
        return np.zeros_like(radiance)
    found = radiance
    for _ in range(MOST_STEPS):
        over = _over_horizon(seen)
        over -= RELAXATION * np.minimum(over, 0.0)
        found = _of_degree(seen, degree)
        seen = _on_grid(found, degree)
        if _is_above(seen, LIFTED_SHARE):
            break
    return _with_mean(found, _over_horizon(seen), mean)


def _with_mean(radiance: FloatArray, over: FloatArray, mean: float) -> FloatArray:
    """Scale to a mean over the horizon; what is still dark is drawn to it in all directions."""
    scale = mean / _mean(radiance)
    least, peak = scale * float(over.min()), scale * float(over.max())
    # mean + share (least - mean) is LIFTED_SHARE of mean + share (peak - mean).
    above = mean * (1.0 - LIFTED_SHARE)
    share = min(1.0, above / (above - least + LIFTED_SHARE * peak))
    drawn = radiance * (scale * share)
    drawn[0] += mean * (1.0 - share) * np.sqrt(4.0 * np.pi)
    return np.asarray(drawn)


def _mean(radiance: FloatArray) -> float:
    """Mean over the horizon, weighed by the cosine: exitance over pi."""
    return float(plane(radiance[:, None], ZENITH)[0]) / np.pi


def _is_above(seen: FloatArray, share: float) -> bool:
    """Whether nothing over the horizon is below a share of the peak there."""
    over = _over_horizon(seen)
    return bool(over.min() >= share * over.max())


def _over_horizon(seen: FloatArray) -> FloatArray:
    """Rows of the grid from zenith to horizon."""
    return seen[: len(seen) // 2 + 1]


def _on_grid(radiance: FloatArray, degree: int) -> FloatArray:
    """Values of one expansion (T,) in rows of directions from zenith to nadir."""
    rows = ROWS_PER_DEGREE * (degree + 1)
    return np.asarray(
        ducc0.sht.synthesis_2d(
            alm=complex_form(radiance, degree)[None],
            spin=0,
            lmax=degree,
            geometry="CC",
            ntheta=rows + 1,
            nphi=2 * rows,
            nthreads=1,
        )[0]
    )


def _of_degree(seen: FloatArray, degree: int) -> FloatArray:
    """Expansion (T,) nearest to values on the grid."""
    found = ducc0.sht.analysis_2d(map=seen[None], spin=0, lmax=degree, geometry="CC", nthreads=1)[0]
    return real_form(found, degree)
