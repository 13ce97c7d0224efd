"""How far one field is from another, or from a closed form: at points drawn once over the lit surfaces.

Statistical error and interpolation both count; relative differences are taken as those of a run's target are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lelight.channels import luminance_weighted
from lelight.estimate.replicates import DARK_SHARE
from lelight.harmonics.frames import to_local
from lelight.harmonics.indices import degree_of
from lelight.harmonics.synthesis import synthesise_at
from lelight.mesh.locate import Locator, interpolate
from lelight.mesh.nodes import NodeMesh
from lelight.results import NodeValues
from lelight.scene import FloatArray, IntArray, triangle_areas

#: Points over all surfaces, and directions at each in which glossy ones are looked at.
POINTS, DIRECTIONS = 4096, 4
#: Directions stay so far above the surface (cosine).
LOWEST = 0.1

#: Exact illuminance (k,) in lx at points (k, 3) with normals (k, 3).
Exact = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class SamplePoints:
    """Points drawn by area on sides of patches.

    Attributes
    ----------
    points, normals : (k, 3) float, m and unit length
    patches, sides : (k,) int
    directions : (k, d, 3) float, unit, away from the surface
    """

    points: FloatArray
    normals: FloatArray
    patches: IntArray
    sides: IntArray
    directions: FloatArray


def sample_points(mesh: NodeMesh, *, seed: int = 0, count: int = POINTS) -> SamplePoints:
    """Draw points on the triangles of visible nodes, and directions over each."""
    rng = np.random.default_rng((seed, count))
    # Where every triangle has a hidden corner, those count that have a visible one.
    wholly = mesh.open_triangles
    open_triangles = np.flatnonzero(wholly if wholly.any() else ~mesh.hidden[mesh.triangles].all(axis=1))
    corners = mesh.vertices[mesh.triangles[open_triangles]]
    reach = np.cumsum(triangle_areas(corners))
    u = (np.arange(count) + rng.random(count)) / count
    drawn = np.minimum(np.searchsorted(reach, u * reach[-1], side="right"), len(open_triangles) - 1)
    points = np.einsum("kc,kcx->kx", rng.dirichlet(np.ones(3), count), corners[drawn])
    triangles = open_triangles[drawn]
    normals = mesh.normals[mesh.triangles[triangles, 0]]
    directions = rng.normal(size=(count, DIRECTIONS, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    height = np.einsum("kdx,kx->kd", directions, normals)
    lift = np.maximum(np.abs(height), LOWEST) - height
    directions += lift[..., None] * normals[:, None]
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    return SamplePoints(
        points, normals, mesh.triangle_patches[triangles], mesh.triangle_sides[triangles], directions
    )


def illuminance_at(mesh: NodeMesh, values: NodeValues, at: SamplePoints) -> FloatArray:
    """Interpolate the illuminance (k,) in lx of a field there; 0 where it has no node on that side."""
    nodes, weights = Locator(mesh).find(at.points, at.patches, at.sides)
    return interpolate(luminance_weighted(values.illuminance)[:, None], nodes, weights)[:, 0]


def radiance_at(mesh: NodeMesh, values: NodeValues, at: SamplePoints) -> tuple[FloatArray, IntArray]:
    """Evaluate the stored radiance (k, d), cd/m², toward the directions; tell the degree (k,) that is kept there."""
    nodes, weights = Locator(mesh).find(at.points, at.patches, at.sides)
    degree = degree_of(values.radiance_sh.shape[1])
    found = []
    for number in range(at.directions.shape[1]):
        toward = at.directions[:, number]
        local = to_local(toward[:, None, :], mesh.normals[nodes], mesh.frames_x[nodes])
        seen = synthesise_at(values.radiance_sh, degree, nodes, weights, np.ascontiguousarray(local))
        found.append(luminance_weighted(np.asarray(seen)))
    return np.stack(found, axis=1), values.sh_degree[nodes[:, 0]]


def relative_rms(found: FloatArray, true: FloatArray) -> float:
    """Root mean square of differences over the true value, or over 5 % of its mean where that is more."""
    scale = np.maximum(true, DARK_SHARE * float(true.mean()))
    return float(np.sqrt(np.mean(((found - true) / scale) ** 2)))
