"""Light of the emitters on paths: drawn at every surface, and met by Phong lobes on their own.

The Lambertian lobe takes direct light from the drawn source only; the Phong lobe combines it with what its own
direction meets, by the balance heuristic (Veach & Guibas 1995).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.estimate.pathstate import Paths, add_clear
from lelight.estimate.split import above, lobe_probability, lobe_shares
from lelight.scene import FloatArray, IntArray
from lelight.tracing.drawing import (
    LOCAL_CHOICE_LIMIT,
    chosen,
    drawn_density,
    rough_cdfs,
    shines,
    source_housing,
    toward_face,
)
from lelight.tracing.emitters import Emitters
from lelight.tracing.lamps import toward_lamp
from lelight.tracing.reflection import Reflectances, lobe, lobe_density
from lelight.tracing.sampling import mirrored
from lelight.tracing.world import World

#: Paths for which the choice of sources is laid out at once; bounds memory, does not change results.
PATHS_AT_ONCE = 256


def add_drawn_sources(
    world: World, paths: Paths, bound: float, numbers: FloatArray, radiance: FloatArray
) -> int:
    """Add the light of one drawn source at each path's surface; returns the shadow rays."""
    light = np.empty_like(paths.throughput)
    origins, ends = np.empty_like(paths.points), np.empty_like(paths.points)
    housing, number = np.zeros(len(light), dtype=np.int64), np.empty(len(light), dtype=np.int64)
    lit: int = _draw_sources(
        world.emitters,
        world.reflectances,
        paths.points,
        paths.normals,
        paths.outgoing,
        paths.materials,
        paths.throughput,
        paths.geometry,
        bound,
        numbers,
        world.caster.offset,
        paths.number,
        number,
        light,
        origins,
        ends,
        housing,
    )
    clear = world.visible(origins[:lit], ends[:lit], housing=housing[:lit])
    add_clear(radiance, number[:lit], light[:lit], clear)
    return lit


@njit(**COMPILED)
def _draw_sources(
    emitters: Emitters,
    reflectances: Reflectances,
    points: FloatArray,
    normals: FloatArray,
    outgoing: FloatArray,
    materials: IntArray,
    throughput: FloatArray,
    geometry: FloatArray,
    bound: float,
    numbers: FloatArray,
    offset: float,
    own_number: IntArray,
    number: IntArray,
    light: FloatArray,
    origins: FloatArray,
    ends: FloatArray,
    housing: IntArray,
) -> int:
    """Write what drawn sources give those paths that they can light, one after the other; returns how many."""
    # Single arrays: handing all emitters or materials on costs more than what is done with them.
    corners, faces, areas = emitters.corners, emitters.normals, emitters.areas
    both_sides, luminance, intensity = emitters.both_sides, emitters.luminance, emitters.intensity
    diffuse, specular, exponent = reflectances.diffuse, reflectances.specular, reflectances.exponent
    triangles, lit = len(corners), 0
    # Among very many sources the choice is the same at every place: one row serves all.
    everywhere = len(emitters.power) > LOCAL_CHOICE_LIMIT
    cdfs = np.empty((1 if everywhere else min(PATHS_AT_ONCE, len(points)), len(emitters.power)))
    for k in range(len(points)):
        row = 0 if everywhere else k % PATHS_AT_ONCE
        if row == 0 and (k == 0 or not everywhere):
            last = min(k + len(cdfs), len(points))
            rough_cdfs(emitters, points[k:last], normals[k:last], cdfs)
        cdf = cdfs[row]
        m = materials[k]
        share_d, share_s = lobe_shares(reflectances, m, bound, geometry[k])
        p_diffuse = lobe_probability(reflectances, m, share_d, share_s)
        if p_diffuse < 0.0 or not cdf[-1] > 0.0:
            continue
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        nx, ny, nz = normals[k, 0], normals[k, 1], normals[k, 2]
        source, share = chosen(cdf, numbers[k, 0])
        u, v = numbers[k, 1], numbers[k, 2]
        if source < triangles:
            d, end, factor, density = toward_face(
                corners, faces, areas, both_sides, source, x, y, z, u, v, offset
            )
        else:
            d, end, factor, density = toward_lamp(emitters, source - triangles, x, y, z, u, v, offset)
        cos_theta = d[0] * nx + d[1] * ny + d[2] * nz
        if factor <= 0.0 or cos_theta <= 0.0:
            continue
        phong = 0.0
        if p_diffuse < 1.0:
            n = exponent[m]
            ax, ay, az = mirrored(outgoing[k, 0], outgoing[k, 1], outgoing[k, 2], nx, ny, nz)
            cos_alpha = d[0] * ax + d[1] * ay + d[2] * az
            peak = lobe(n, cos_alpha)
            phong = peak * above(bound, math.pi * peak * geometry[k])
            if phong > 0.0 and density > 0.0:
                drawn = share * density
                phong *= drawn / (drawn + (1.0 - p_diffuse) * lobe_density(n, cos_alpha))
        brightest = 0.0
        for c in range(light.shape[1]):
            reflected = diffuse[m, c] * share_d / math.pi + specular[m, c] * phong
            strength = luminance[source, c] if source < triangles else intensity[source - triangles, c]
            light[lit, c] = throughput[k, c] * strength * factor / share * cos_theta * reflected
            brightest = max(brightest, light[lit, c])
        if brightest <= 0.0:
            continue
        number[lit], housing[lit] = own_number[k], source_housing(emitters, source)
        origins[lit, 0], origins[lit, 1], origins[lit, 2] = x + offset * nx, y + offset * ny, z + offset * nz
        ends[lit, 0], ends[lit, 1], ends[lit, 2] = end
        lit += 1
    return lit


def add_met_emitters(
    world: World, left: Paths, met: Paths, density: FloatArray, radiance: FloatArray
) -> None:
    """Add emission that Phong lobes met by themselves, weighted against drawing the same source."""
    _weigh_met_emitters(
        world.emitters,
        left.points,
        left.normals,
        met.outgoing,
        met.triangles,
        met.throughput,
        density,
        met.number,
        radiance,
    )


@njit(**COMPILED)
def _weigh_met_emitters(
    emitters: Emitters,
    points: FloatArray,
    normals: FloatArray,
    back: FloatArray,
    triangles: IntArray,
    throughput: FloatArray,
    density: FloatArray,
    number: IntArray,
    radiance: FloatArray,
) -> None:
    cdf = np.empty((1, len(emitters.power)))
    for k in range(len(points)):
        source = emitters.of_triangle[triangles[k]]
        if density[k] <= 0.0 or source < 0:
            continue
        d = (-back[k, 0], -back[k, 1], -back[k, 2])
        if not shines(emitters, source, d):
            continue
        rough_cdfs(emitters, points[k : k + 1], normals[k : k + 1], cdf)
        drawn = 0.0
        if cdf[0, -1] > 0.0:
            drawn = drawn_density(emitters, cdf[0], source, points[k, 0], points[k, 1], points[k, 2], d)
        weight = density[k] / (density[k] + drawn)
        for c in range(radiance.shape[1]):
            radiance[number[k], c] += weight * throughput[k, c] * emitters.luminance[source, c]
