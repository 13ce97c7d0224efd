"""Which chain vertices a receiver asks: weak ones by Russian roulette, before any ray is traced.

A pair that would give a receiver less than a threshold if nothing were in between is kept with a probability in
proportion to what it would give, and counts as much more. Shares are added up along the vertices and a pair is kept
whenever the sum passes a whole number (systematic sampling), so every receiver asks nearly the number it is meant to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.channels import luminance_weighted
from lelight.compilation import COMPILED, LEAF
from lelight.receivers import Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.chains import DIFFUSE_LOBE, SPECULAR_LOBE, ChainVertices
from lelight.tracing.sampling import uniform
from lelight.tracing.world import World

#: Share of the vertices that a receiver asks. About half of them face it; asking a twelfth instead takes a quarter of
#: the time and adds a tenth to the variance (office and corridor, 180 vertices). Chosen by a tree a vertex costs more,
#: and a fourth of that is enough. As more chains are walked more are asked, or the error would stop falling.
ASKED_SHARE, ASKED_BY_TREE = 1.0 / 12.0, 1.0 / 48.0
#: Few enough vertices are all asked.
LEAST_ASKED = 12.0
#: Vertices that tell what a receiver would get of all in the open.
SKETCHED = 64
#: Least that a receiver is taken to get in the open, as a share of all light spread over all surfaces.
DARKEST = 1e-3


def vertices_asked(count: int, *, by_tree: bool) -> float:
    """Say how many of so many vertices a receiver asks."""
    return max(LEAST_ASKED, (ASKED_BY_TREE if by_tree else ASKED_SHARE) * count)


@dataclass(frozen=True)
class Thinning:
    """How the pairs of some receivers and vertices are thinned out.

    Attributes
    ----------
    asked : float, how many pairs a receiver is to keep, about
    strengths : (2, v) float, lm that each vertex reflects by its Lambertian and its Phong lobe, see `lobe_strengths`
    threshold : (r,) float, illuminance in lx below which a receiver's pairs are thinned out, 0 for none
    passed : (r,) float in [0, 1), sum of shares since a pair was kept; changed while vertices are gone through
    """

    asked: float
    strengths: FloatArray
    threshold: FloatArray
    passed: FloatArray

    @classmethod
    def of(
        cls,
        world: World,
        receivers: Receivers,
        vertices: ChainVertices,
        *,
        bound: float,
        asked: float,
        key: np.uint64,
    ) -> Thinning:
        """Let receivers ask about so many vertices.

        The threshold is the geometric mean of what a receiver would get in the open and what it would get were all
        light spread over all surfaces, over the number asked: dark places ask fewer, but not too few.
        """
        strengths = lobe_strengths(world, vertices)
        threshold = np.zeros(len(receivers))
        if asked < len(vertices):
            stride = max(1, len(vertices) // SKETCHED)
            _add_unshadowed(
                np.arange(0, len(vertices), stride),
                vertices.points,
                vertices.normals,
                strengths.sum(axis=0),
                receivers.points,
                receivers.normals,
                receivers.on_surface,
                bound,
                threshold,
            )
            spread = float(strengths.sum()) / world.area
            threshold = np.sqrt(np.maximum(threshold * stride, DARKEST * spread) * spread) / asked
        return cls(asked, strengths, threshold, starting_sums(key, receivers.identity))


def lobe_strengths(world: World, vertices: ChainVertices) -> FloatArray:
    """Flux (2, v) in lm that vertices reflect by either lobe, whatever its sign: the luminous one where all is grey.

    In colour half of it goes by the channels alike, each in proportion to its sum over all vertices: what only one
    channel carries, hardly luminous perhaps, is asked in its own right.
    """
    reflectances, m = world.reflectances, vertices.materials
    diffuse = np.where((vertices.lobes & DIFFUSE_LOBE != 0)[:, None], reflectances.diffuse[m], 0.0)
    specular = np.where((vertices.lobes & SPECULAR_LOBE != 0)[:, None], reflectances.specular[m], 0.0)
    reflected = np.abs(vertices.flux) * np.stack([diffuse, specular])
    luminous = luminance_weighted(reflected)
    if world.channels == 1:
        return luminous
    total = np.maximum(reflected.sum(axis=(0, 1)), np.finfo(np.float64).tiny)
    alike = luminous.sum() * np.mean(reflected / total, axis=2)
    return np.asarray(0.5 * (luminous + alike))


@njit(**LEAF)
def _add_unshadowed(
    number: IntArray,
    points: FloatArray,
    normals: FloatArray,
    reflected: FloatArray,
    at: FloatArray,
    at_normals: FloatArray,
    on_surface: BoolArray,
    bound: float,
    illuminance: FloatArray,
) -> None:
    """Add the illuminance (r,) in lx that vertices would give with nothing in between, all their lobes Lambertian."""
    for i in number:
        px, py, pz = points[i]
        nx, ny, nz = normals[i]
        for r in range(len(at)):
            dx, dy, dz = at[r, 0] - px, at[r, 1] - py, at[r, 2] - pz
            square = dx * dx + dy * dy + dz * dz
            cos_vertex = (dx * nx + dy * ny + dz * nz) / math.sqrt(square)
            cos_receiver = 1.0
            if on_surface[r]:
                along = dx * at_normals[r, 0] + dy * at_normals[r, 1] + dz * at_normals[r, 2]
                cos_receiver = -along / math.sqrt(square)
            if cos_vertex > 0.0 and cos_receiver > 0.0:
                illuminance[r] += reflected[i] / math.pi * min(cos_vertex * cos_receiver / square, bound)


@njit(**COMPILED)
def starting_sums(key: np.uint64, identity: IntArray) -> FloatArray:
    """Draw the sums of shares (r,) in [0, 1) that receivers begin with."""
    sums = np.empty(len(identity))
    for r in range(len(identity)):
        sums[r] = uniform(key, np.uint64(identity[r]))
    return sums
