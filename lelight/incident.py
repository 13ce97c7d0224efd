"""Light that arrives at nodes, by direction: what is left to be reflected once the walks are done."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lelight.harmonics.indices import terms
from lelight.scene import IntArray


@dataclass(frozen=True)
class IncidentLight:
    """Indirect light at g nodes, each arrival at its mirrored direction, in harmonics of the local frames.

    Attributes
    ----------
    nodes : (g,) int, rising
    degrees : (g,) int; degree to which a node keeps it
    coefficients : (g, T, C) float32, lx; T = (L + 1)², L the largest degree; zero beyond a node's own
    """

    nodes: IntArray
    degrees: IntArray
    coefficients: NDArray[np.float32]

    @property
    def packed(self) -> NDArray[np.float32]:
        """(sum of terms, C) float32: the coefficients that nodes keep, one node after the other."""
        return np.asarray(self.coefficients[_kept(self.degrees, self.coefficients.shape[1])])

    @classmethod
    def of_packed(cls, nodes: IntArray, degrees: IntArray, packed: NDArray[np.float32]) -> IncidentLight:
        """Undo `packed`."""
        width = terms(int(degrees.max(initial=0)))
        coefficients = np.zeros((len(nodes), width, packed.shape[1]), dtype=np.float32)
        coefficients[_kept(degrees, width)] = packed
        return cls(nodes, degrees, coefficients)


def _kept(degrees: IntArray, width: int) -> NDArray[np.bool_]:
    """Places (g, width) that nodes of these degrees use."""
    return np.asarray(np.arange(width) < ((degrees + 1) ** 2)[:, None])
