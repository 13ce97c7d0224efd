"""What a Phong lobe shows of the emitters themselves, and of everything where it is almost a mirror.

The field keeps reflected light only, since small bright sources would ring and blur in harmonics. Their
images in glossy surfaces are computed when a direction is evaluated: sources drawn by what they can give, and
directions drawn from the lobe, combined by the balance heuristic.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.estimate.paths import NUMBERS, rotated_numbers, step
from lelight.estimate.pathstate import Paths, unknown_rows
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import hash_of
from lelight.tracing.emitters import Emitters
from lelight.tracing.reflection import Reflectances
from lelight.tracing.sampling import mirrored
from lelight.tracing.sobol import Stretch, sobol
from lelight.tracing.world import World

#: Share of its peak below which a Phong lobe shows nothing of an emitter.
FAINT = 1e-6


def only_specular(world: World) -> World:
    """Switch all Lambertian lobes off."""
    dark = np.zeros_like(world.reflectances.diffuse)
    share = np.zeros_like(world.reflectances.diffuse_share)
    return replace(world, reflectances=world.reflectances._replace(diffuse=dark, diffuse_share=share))


def highlights(
    glossy_world: World,
    *,
    points: FloatArray,
    normals: FloatArray,
    outgoing: FloatArray,
    materials: IntArray,
    identity: IntArray,
    log2_samples: int,
) -> tuple[FloatArray, Paths]:
    """Reflect emitters in the Phong lobes of surface points.

    Parameters
    ----------
    glossy_world : as `only_specular` makes it
    points, normals, outgoing : (k, 3) float; the normal and the direction on the side that is seen
    identity : (k,) int, on which the random numbers depend

    Returns
    -------
    radiance : (k, C) float, cd/m²
    paths : the surfaces that the lobes' own directions met, numbered by point, with throughput for the mean
    """
    table = sobol(NUMBERS, Stretch.of(log2_samples), seed=(int(hash_of((4,)) & np.uint64(0xFFFF)),))
    number = np.repeat(np.arange(len(points)), len(table))
    numbers = np.empty((len(number), NUMBERS))
    rotated_numbers(table, hash_of((5,)), identity, numbers)
    paths = Paths(
        number=number,
        points=points[number],
        normals=normals[number],
        outgoing=outgoing[number],
        materials=materials[number],
        triangles=np.zeros(len(number), dtype=np.int64),
        throughput=np.full((len(number), glossy_world.channels), 1.0 / len(table)),
        geometry=np.full(len(number), np.inf),
        rows=unknown_rows(len(number)),
    )
    radiance = np.zeros((len(points), glossy_world.channels))
    met, _ = step(glossy_world, paths, bound=0.0, numbers=numbers, radiance=radiance, roulette=False)
    return radiance, met


def sees_images(
    world: World, points: FloatArray, normals: FloatArray, outgoing: FloatArray, materials: IntArray
) -> BoolArray:
    """Say at which points (k,) a Phong lobe may show an emitter by more than `FAINT` of the lobe's peak.

    Whatever stands between is not looked at. Sources are taken for spheres around them.

    Parameters
    ----------
    points, normals, outgoing : (k, 3) float; the normal and the direction on the side that is seen
    """
    emitters = world.emitters
    middles = np.concatenate([emitters.sketch[:3].T, emitters.positions])
    radii = np.concatenate([emitters.sketch[6], emitters.sizes])
    seen = np.zeros(len(points), dtype=np.bool_)
    _find_images(emitters, world.reflectances, middles, radii, points, normals, outgoing, materials, seen)
    return seen


@njit(**COMPILED)
def _find_images(
    emitters: Emitters,
    reflectances: Reflectances,
    middles: FloatArray,
    radii: FloatArray,
    points: FloatArray,
    normals: FloatArray,
    outgoing: FloatArray,
    materials: IntArray,
    seen: BoolArray,
) -> None:
    triangles = len(emitters.areas)
    widest = np.arccos(FAINT ** (1.0 / np.maximum(reflectances.exponent, 1e-9)))
    for k in range(len(points)):
        nx, ny, nz = normals[k]
        ax, ay, az = mirrored(outgoing[k, 0], outgoing[k, 1], outgoing[k, 2], nx, ny, nz)
        limit = widest[materials[k]]
        for source in range(len(radii)):
            dx = middles[source, 0] - points[k, 0]
            dy = middles[source, 1] - points[k, 1]
            dz = middles[source, 2] - points[k, 2]
            radius = radii[source]
            if dx * nx + dy * ny + dz * nz + radius <= 0.0:
                continue
            if source < triangles and not emitters.both_sides[source]:
                ahead_x, ahead_y, ahead_z = emitters.normals[source]
                if dx * ahead_x + dy * ahead_y + dz * ahead_z >= 0.0:
                    continue
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            if distance <= radius:
                seen[k] = True
                break
            cos_alpha = (dx * ax + dy * ay + dz * az) / distance
            alpha = math.acos(min(max(cos_alpha, -1.0), 1.0))
            if alpha - math.asin(radius / distance) <= limit:
                seen[k] = True
                break
