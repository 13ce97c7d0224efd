"""The photometric sphere: a point source in the middle, reflected light the same everywhere.

The sphere is an icosahedron, cut so often that it has 320 facets, with all corners on the unit sphere. Direct light
at a node x with normal n is I (-x . n) / |x|³, whatever facet it lies on. Reflected light is rho times the mean of E
over the surface, weighted by cos d omega / pi as seen from the node. On a sphere those weights are uniform in area;
on the polyhedron they differ from that by at most what flattening the facets does, 1 - d², d the least distance of a
facet, while E differs from its mean by at most the spread of direct light. Rho times the product of both bounds the
difference from the area's mean, which the balance of energy makes exactly Phi / (A (1 - rho)).
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from lelight.analytic.case import Case, at_nodes
from lelight.analytic.solids import icosphere, lamp, matt, scene
from lelight.scene import FloatArray, triangle_areas, triangle_normals

#: cd
INTENSITY = 100.0


def illuminance(
    positions: FloatArray,
    normals: FloatArray,
    *,
    reflectance: float,
    area: float,
    intensity: float = INTENSITY,
) -> FloatArray:
    """Exact illuminance (n,) in lx at points and normals (n, 3) of a polyhedron of ``area`` m²."""
    distance = np.linalg.norm(positions, axis=1)
    direct = intensity * -np.einsum("nx,nx->n", positions, normals) / distance**3
    return np.asarray(direct + reflectance / (1.0 - reflectance) * 4.0 * math.pi * intensity / area)


def allowance(corners: FloatArray, *, reflectance: float) -> float:
    """Bound what the derivation above leaves open, in lx, for facets (n, 3, 3): at most 4e-4 of all light."""
    middles = corners.mean(axis=1)
    distance = float(np.min(-np.einsum("nx,nx->n", middles, triangle_normals(corners))))
    spread = INTENSITY * max(distance**-2 - 1.0, 1.0 - distance)
    return reflectance * (1.0 - distance**2) * spread


def case(reflectance: float, *, target: float) -> Case:
    """All nodes of the sphere, and their mean."""
    made = scene(
        f"sphere, reflectance {reflectance:g}",
        icosphere(2, matt("sphere", reflectance)),
        luminaires=[lamp((0, 0, 0), INTENSITY)],
    )
    area = float(triangle_areas(made.corners).sum())
    exact = partial(illuminance, reflectance=reflectance, area=area)
    open_share = allowance(made.corners, reflectance=reflectance)
    return Case(
        name=f"sphere-{reflectance:g}",
        group="Photometric sphere",
        title=f"reflectance {reflectance:g}, source in the middle",
        basis="balance of energy in the polyhedron",
        scene=made,
        edge=0.6,
        target=target,
        tolerance=0.003,
        precision=0.0015,
        read=lambda run: at_nodes(run, exact, allowance=open_share),
    )
