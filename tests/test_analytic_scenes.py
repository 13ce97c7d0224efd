"""Scenes whose light is known on paper: photometric spheres, the furnace, Sobolev's problem.

Every node is a t-test of the run's own batches against the exact value, with Šidák's correction over the nodes;
the same test must reject the value a wrong reflectance would give.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.special import j0, k1
from scipy.stats import t as student

from lelight.calculation import calculate
from lelight.mesh.nodes import NodeMesh
from lelight.reading.loading import load
from lelight.scene import FloatArray, Scene
from lelight.settings import Settings

SCENES = Path(__file__).parents[1] / "scenes"
#: Chance that one whole family of t-tests rejects the truth.
FAMILY_LEVEL = 0.01


@dataclass(frozen=True)
class Found:
    """Mean illuminance (n,) of the visible nodes in lx, its standard error, and how many batches gave it."""

    mesh: NodeMesh
    visible: np.ndarray[tuple[int], np.dtype[np.bool_]]
    mean: FloatArray
    std_error: FloatArray
    batches: int

    def worst(self, exact: FloatArray | float, *, model: FloatArray | float = 0.0) -> float:
        """Largest |t| of any node; ``model`` (n,) lx is what the exact value itself is uncertain by."""
        excess = np.maximum(np.abs(self.mean - exact) - model, 0.0)
        return float(np.max(excess / self.std_error))

    @property
    def critical(self) -> float:
        """|t| that the worst of n nodes exceeds with probability `FAMILY_LEVEL` (Šidák 1967)."""
        each = 1.0 - (1.0 - FAMILY_LEVEL) ** (1.0 / len(self.mean))
        return float(student.isf(each / 2.0, self.batches - 1))


def lit(scene: Scene, settings: Settings) -> Found:
    """Run a scene; the nodes that are not buried."""
    run = calculate(scene, settings)
    seen = ~run.field.mesh.hidden
    nodes = slice(0, len(seen))
    replicates = run.replicates
    return Found(
        run.field.mesh, seen, replicates.mean[nodes][seen], replicates.std_error[nodes][seen], replicates.count
    )
