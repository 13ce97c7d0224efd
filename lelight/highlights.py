"""What a Phong lobe shows of the emitters themselves, and of everything where it is almost a mirror.

The field keeps reflected light only, since small bright sources would ring and blur in harmonics. Their
images in glossy surfaces are computed when a direction is evaluated: sources drawn by what they can give, and
directions drawn from the lobe, combined by the balance heuristic.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lelight.estimate.paths import NUMBERS, rotated_numbers, step
from lelight.estimate.pathstate import Paths
from lelight.scene import FloatArray, IntArray
from lelight.tracing.chains import hash_of
from lelight.tracing.sampling import Stretch, sobol
from lelight.tracing.world import World


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
    )
    radiance = np.zeros((len(points), glossy_world.channels))
    met, _ = step(glossy_world, paths, bound=0.0, numbers=numbers, radiance=radiance, roulette=False)
    return radiance, met
