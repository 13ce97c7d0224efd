"""Light on walls, ceiling and floor, EN 12464-1, from the field at the nodes.

Which patch is a wall follows from its shape: upright and at least half as high as the scene. Ceilings face
down in the upper quarter, floors face up in the lowest tenth of the scene's height. Furniture is neither.
"""

from __future__ import annotations

import numpy as np

from lelight.metrics.extremes import CROSS_FITTED, counted, least_over_mean
from lelight.metrics.figure import Figure, from_replicates, ratio, stated
from lelight.scene import BoolArray, FloatArray, IntArray

#: Cosines of the normal to the vertical: below the first upright, above the second level.
UPRIGHT, LEVEL = 0.1, 0.9
#: Shares of the scene's height.
WALL_HEIGHT, CEILING_FROM, FLOOR_TO = 0.5, 0.75, 0.1
#: Least uniformity of walls and ceiling.
UNIFORMITY = 0.10
SURFACES = ("wall", "ceiling", "floor")


def kinds_of(
    positions: FloatArray, normals: FloatArray, patches: IntArray, *, emits: BoolArray
) -> dict[str, IntArray]:
    """Nodes of each kind of surface.

    Parameters
    ----------
    positions, normals : (n, 3) float
    patches : (n,) int
    emits : (n,) bool; luminous surfaces are left out

    Returns
    -------
    Indices of nodes by ``wall``, ``ceiling``, ``floor``
    """
    heights = positions[:, 2]
    low, tall = float(heights.min()), max(float(np.ptp(heights)), 1e-12)
    upright = np.abs(normals[:, 2]) < UPRIGHT
    walls = upright & (_patch_heights(heights, patches) >= WALL_HEIGHT * tall)
    ceilings = (normals[:, 2] < -LEVEL) & (heights >= low + CEILING_FROM * tall)
    floors = (normals[:, 2] > LEVEL) & (heights <= low + FLOOR_TO * tall)
    return {
        name: np.flatnonzero(chosen & ~emits)
        for name, chosen in zip(SURFACES, (walls, ceilings, floors), strict=True)
    }


def _patch_heights(heights: FloatArray, patches: IntArray) -> FloatArray:
    """Extent in z (n,) of the patch that each node is on."""
    count = int(patches.max()) + 1
    lowest, highest = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(lowest, patches, heights)
    np.maximum.at(highest, patches, heights)
    return np.asarray((highest - lowest)[patches])


def surface_figures(
    kinds: dict[str, IntArray],
    areas: FloatArray,
    replicates: FloatArray,
    *,
    targets: dict[str, float],
) -> dict[str, Figure]:
    """Mean illuminance and uniformity of walls, ceiling and floor.

    Parameters
    ----------
    kinds : indices of nodes, as `kinds_of` finds them, hidden ones left out
    areas : (n,) float, m²
    replicates : (R, n) float, lx
    targets : ``wall_illuminance`` and ``ceiling_illuminance``, lx, where they are required
    """
    figures: dict[str, Figure] = {}
    for name, nodes in kinds.items():
        if len(nodes):
            figures |= _of_surface(
                name, areas[nodes], replicates[:, nodes], targets.get(f"{name}_illuminance")
            )
    return figures


def _of_surface(name: str, areas: FloatArray, batches: FloatArray, target: float | None) -> dict[str, Figure]:
    clause = f"EN 12464-1, {name} illuminance"
    mean, mean_error = from_replicates(lambda e: ratio(float(areas @ e), float(areas.sum())), batches)
    method = "mean by area over the nodes"
    uniformity, error = least_over_mean(batches)
    return {
        f"{name}_illuminance": stated(
            mean, mean_error, batches=len(batches), unit="lx", method=method, clause=clause, target=target
        ),
        f"{name}_uniformity": stated(
            uniformity,
            error,
            batches=counted(len(batches)),
            unit="1",
            method=f"least / mean of the nodes; {CROSS_FITTED}",
            clause=f"{clause} (0.10, from memory)",
            target=UNIFORMITY if target is not None and name != "floor" else None,
            undefined="not defined: no light reaches it",
        ),
    }
