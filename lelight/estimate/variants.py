"""Ways to estimate the indirect light, side by side: which chains, which bound, what the receivers do themselves.

All share the chains (`tracing.chains`, `defect`), the pair kernel (`local`) and the rays from the receiver's side
(`nearfield`); a variant only says how they are put together. The first three are unbiased; the others are what
the literature compares with, and say by what they are wrong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Estimator = Literal["base", "emitters", "paths", "raw", "clamped", "averaged", "gather", "shortened"]


@dataclass(frozen=True)
class Variant:
    """How indirect light is put together.

    Attributes
    ----------
    on_base : whether a base field is solved, and chains carry what it lacks
    chains : whether chains light the receivers
    bounded : whether the kernel of the chains is bounded
    averaged : whether a receiver is spread over a disc (Kalos 1963)
    near : what rays from the receiver bring: what lies above the bound, all, the base alone, or nothing
    nodes : vertices that a chain from the emitters has at the most; None for as many as it makes
    bias : what replicates cannot see, empty where nothing is wrong
    """

    on_base: bool = False
    chains: bool = True
    bounded: bool = True
    averaged: bool = False
    near: Literal["rest", "all", "base", "none"] = "none"
    nodes: int | None = None
    bias: str = ""

    def chain_bound(self, bound: float) -> float:
        """Bound of the chains' kernel in 1/m²."""
        return bound if self.bounded else math.inf

    def near_bound(self, bound: float) -> float:
        """Bound in 1/m² above which rays from the receiver bring light."""
        return {"rest": bound, "all": 0.0, "base": math.inf, "none": math.inf}[self.near]


VARIANTS: dict[Estimator, Variant] = {
    "base": Variant(on_base=True, near="rest"),
    "emitters": Variant(near="rest"),
    "paths": Variant(chains=False, near="all"),
    "raw": Variant(
        bounded=False,
        bias="Raw local estimation: spikes near edges have no variance, so the error there is not to be trusted.",
    ),
    "clamped": Variant(bias="Clamped local estimation: light from nearer than the bound is missing."),
    "averaged": Variant(
        bounded=False,
        averaged=True,
        bias="Averaged local estimation: values are means over a disc around the node.",
    ),
    "gather": Variant(
        on_base=True,
        chains=False,
        near="base",
        bias="Gathering alone: interpolation and noise of the base field stay in the result.",
    ),
    "shortened": Variant(
        on_base=True,
        near="base",
        bias="Without residual paths: of what the base field lacks, light from nearer than the bound is missing.",
    ),
}

#: For scenes in which nothing reflects.
DIRECT_ONLY = Variant(chains=False)
