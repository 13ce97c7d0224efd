"""How paths end soon: on the base field where they land, and on one chain vertex for what the base lacks there.

A path that leaves a surface by its Lambertian lobe stands for a receiver there. What arrives is split as at any other
(`local`, `nearfield`): below the bound it is the base, where the path lands, and the chains, of which the path asks one
vertex, drawn by its flux; only what lies above the bound is left for the path to go on for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numba import njit

from lelight.channels import luminance_weighted
from lelight.compilation import COMPILED, LEAF
from lelight.estimate.guide import Guide
from lelight.estimate.pathstate import Paths, add_clear
from lelight.estimate.split import above, lobe_shares
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import DIFFUSE_LOBE, SPECULAR_LOBE, ChainVertices
from lelight.tracing.reflection import Reflectances, lobe
from lelight.tracing.sampling import mirrored
from lelight.tracing.world import World

#: Uniform numbers of one surface of a path: which vertex, whether to ask it, whether to take up what lies above.
END_NUMBERS = 3
#: Vertices that would give less than this share of the mean luminance of all surfaces, were all light spread over
#: them, are asked by Russian roulette; so are paths taken up that carry less than this share of a ray's light.
FAINT_VERTEX, FAINT_PATH = 0.25, 0.1
#: Most that a vertex may give by the bounded kernel, over the illuminance of all light spread over all surfaces.
STRONGEST = 3.0
#: Least and most that chains carry, of the emitters' flux, where paths end on them.
LEAST_LACK, MOST_LACK = 1e-3, 0.5


class SurfaceLuminance(Protocol):
    """A field that can say what a surface sends out, the same in every direction."""

    @property
    def guide(self) -> Guide | None:
        """Where light comes from at receivers, if that is known."""

    def luminance_at(
        self, triangles: IntArray, points: FloatArray, front: BoolArray
    ) -> tuple[FloatArray, IntArray]:
        """Luminance (k, C) in cd/m² of points (k, 3) on sides of triangles (k,), and the guide's row (k,) there."""


@dataclass(frozen=True)
class PathEnds:
    """What paths end on.

    Attributes
    ----------
    base : field that holds most of the light
    vertices : of the chains that carry what it lacks
    chances : (v,) float, rising to 1; of being drawn before or at each vertex
    bound : float, 1/m², b of the split at the surfaces of paths
    """

    base: SurfaceLuminance
    vertices: ChainVertices
    chances: FloatArray
    bound: float

    @classmethod
    def of(cls, world: World, base: SurfaceLuminance, vertices: ChainVertices, bound: float) -> PathEnds:
        """Draw vertices by what they reflect."""
        sums = np.cumsum(reflected_flux(world, vertices))
        whole = float(sums[-1]) if len(sums) else 0.0
        return cls(base, vertices, sums / whole if whole > 0.0 else np.zeros(0), bound)


def reflected_flux(world: World, vertices: ChainVertices) -> FloatArray:
    """Flux (v,) in lm that vertices send back, whatever its sign."""
    kd, ks = world.reflectances.diffuse_share, world.reflectances.specular_share
    albedo = np.where(vertices.lobes & DIFFUSE_LOBE, kd[vertices.materials], 0.0)
    albedo += np.where(vertices.lobes & SPECULAR_LOBE, ks[vertices.materials], 0.0)
    return luminance_weighted(np.abs(vertices.flux)) * albedo


def path_bound(world: World, vertices: ChainVertices) -> float:
    """Bound b in 1/m² at the surfaces of paths; 0 where they had better go on until they are absorbed.

    A vertex stands for all of them, so b is less the more they carry. Where they carry more than half of what the
    emitters send, they are no end for a path.

    Parameters
    ----------
    vertices : of other chains than the estimate's: its bound must not depend on what it bounds
    """
    sent, reflected = float(world.emitters.power.sum()), float(reflected_flux(world, vertices).sum())
    if reflected > MOST_LACK * sent:
        return 0.0
    return STRONGEST * math.pi * sent / (world.area * max(reflected, LEAST_LACK * sent))


def bounded_base(
    world: World, base: SurfaceLuminance, paths: Paths, bound: float
) -> tuple[FloatArray, Paths]:
    """Take the base's luminance (k, C) times the share of the kernel below the bound, min(1, b/G).

    The paths come back with their rows of the base's guide.
    """
    front = _fronts(paths.normals, world.normals, paths.triangles)
    luminance, rows = base.luminance_at(paths.triangles, paths.points, front)
    _keep_below(luminance, paths.geometry, bound)
    return luminance, replace(paths, rows=rows)


@njit(**COMPILED)
def _fronts(normals: FloatArray, triangle_normals: FloatArray, triangles: IntArray) -> BoolArray:
    """Say on which surfaces (k,) a normal is that of the triangle's front."""
    front = np.empty(len(triangles), dtype=np.bool_)
    for k in range(len(triangles)):
        t = triangles[k]
        along = 0.0
        for axis in range(3):
            along += normals[k, axis] * triangle_normals[t, axis]
        front[k] = along > 0.0
    return front


@njit(**LEAF)
def _keep_below(luminance: FloatArray, geometry: FloatArray, bound: float) -> None:
    """Multiply (k, C) by the share of the kernel (k,) below the bound, in place."""
    for k in range(len(geometry)):
        if geometry[k] > bound:
            for c in range(luminance.shape[1]):
                luminance[k, c] *= bound / geometry[k]


def taken_up(world: World, paths: Paths, bound: float, numbers: FloatArray) -> IntArray:
    """Choose the paths (k,) at whose surfaces something lies above the bound, faint ones by Russian roulette.

    The throughput of those that are taken up for others is raised in place.
    """
    kept = np.zeros(len(paths.number), dtype=np.bool_)
    _take_up(
        world.reflectances,
        paths.materials,
        paths.geometry,
        paths.throughput,
        bound,
        numbers,
        world.emitters.weights,
        kept,
    )
    return np.flatnonzero(kept)


@njit(**LEAF)
def _take_up(
    reflectances: Reflectances,
    materials: IntArray,
    geometry: FloatArray,
    throughput: FloatArray,
    bound: float,
    numbers: FloatArray,
    weights: FloatArray,
    kept: BoolArray,
) -> None:
    for k in range(len(materials)):
        m = materials[k]
        share_d, share_s = lobe_shares(reflectances, m, bound, geometry[k])
        reflected = reflectances.diffuse_share[m] * share_d + reflectances.specular_share[m] * share_s
        carried = 0.0
        for c in range(throughput.shape[1]):
            carried += weights[c] * throughput[k, c] * reflected
        survival = min(1.0, carried / FAINT_PATH)
        if numbers[k] < survival:
            kept[k] = True
            for c in range(throughput.shape[1]):
                throughput[k, c] /= survival


def add_drawn_vertices(
    world: World, paths: Paths, ends: PathEnds, bound: float, numbers: FloatArray, radiance: FloatArray
) -> int:
    """Add what one drawn vertex gives each path's surface for its Lambertian lobe; returns the shadow rays."""
    if not len(ends.chances):
        return 0
    light, number = np.empty_like(paths.throughput), np.empty(len(paths.number), dtype=np.int64)
    origins, targets = np.empty_like(paths.points), np.empty_like(paths.points)
    vertices = ends.vertices
    lit: int = _draw_vertices(
        ends.chances,
        vertices.points,
        vertices.normals,
        vertices.incoming,
        vertices.flux,
        vertices.materials,
        vertices.lobes,
        world.reflectances,
        paths.points,
        paths.normals,
        paths.materials,
        paths.throughput,
        paths.geometry,
        bound,
        ends.bound,
        numbers,
        world.emitters.weights,
        FAINT_VERTEX * float(world.emitters.power.sum()) / (math.pi * world.area),
        world.caster.offset,
        paths.number,
        number,
        light,
        origins,
        targets,
    )
    add_clear(radiance, number[:lit], light[:lit], world.visible(origins[:lit], targets[:lit]))
    return lit


@njit(**LEAF)
def _draw_vertices(
    chances: FloatArray,
    points: FloatArray,
    normals: FloatArray,
    incoming: FloatArray,
    flux: FloatArray,
    materials: IntArray,
    lobes: IntArray,
    reflectances: Reflectances,
    at: FloatArray,
    at_normals: FloatArray,
    at_materials: IntArray,
    throughput: FloatArray,
    geometry: FloatArray,
    bound: float,
    split: float,
    numbers: FloatArray,
    weights: FloatArray,
    faint: float,
    offset: float,
    own_number: IntArray,
    number: IntArray,
    light: FloatArray,
    origins: FloatArray,
    ends: FloatArray,
) -> int:
    """Write what drawn vertices give those paths that they can light, one after the other; returns how many."""
    lit = 0
    diffuse, specular, exponents = reflectances.diffuse, reflectances.specular, reflectances.exponent
    for k in range(len(at)):
        share = above(bound, geometry[k]) / math.pi
        if share <= 0.0:
            continue
        i = min(np.searchsorted(chances, numbers[k, 0], side="right"), len(chances) - 1)
        chance = chances[i] - (chances[i - 1] if i > 0 else 0.0)
        dx, dy, dz = at[k, 0] - points[i, 0], at[k, 1] - points[i, 1], at[k, 2] - points[i, 2]
        cos_vertex = dx * normals[i, 0] + dy * normals[i, 1] + dz * normals[i, 2]
        cos_here = -(dx * at_normals[k, 0] + dy * at_normals[k, 1] + dz * at_normals[k, 2])
        if cos_vertex <= 0.0 or cos_here <= 0.0 or chance <= 0.0:
            continue
        square = dx * dx + dy * dy + dz * dz
        kernel = cos_vertex * cos_here / (square * square)
        m = materials[i]
        by_diffuse = min(kernel, split) / math.pi if lobes[i] & DIFFUSE_LOBE else 0.0
        by_specular = 0.0
        if lobes[i] & SPECULAR_LOBE:
            mx, my, mz = mirrored(
                incoming[i, 0], incoming[i, 1], incoming[i, 2], normals[i, 0], normals[i, 1], normals[i, 2]
            )
            cos_alpha = (dx * mx + dy * my + dz * mz) / math.sqrt(square)
            by_specular = min(math.pi * lobe(exponents[m], cos_alpha) * kernel, split) / math.pi
        strength = 0.0
        for c in range(light.shape[1]):
            reflected = diffuse[m, c] * by_diffuse + specular[m, c] * by_specular
            onward = throughput[k, c] * diffuse[at_materials[k], c] * share
            light[lit, c] = flux[i, c] * reflected / chance * onward
            strength += weights[c] * abs(light[lit, c])
        survival = min(1.0, strength / faint)
        if not numbers[k, 1] < survival:
            continue
        for c in range(light.shape[1]):
            light[lit, c] /= survival
        for axis in range(3):
            origins[lit, axis] = at[k, axis] + offset * at_normals[k, axis]
            ends[lit, axis] = points[i, axis] + offset * normals[i, axis]
        number[lit] = own_number[k]
        lit += 1
    return lit
