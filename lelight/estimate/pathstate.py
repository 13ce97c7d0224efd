"""Paths under way: where each stands, and following them to the next surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lelight.scene import FloatArray, IntArray
from lelight.tracing.world import World


@dataclass(frozen=True)
class Paths:
    """k paths under way, each at a surface that it has just met.

    Attributes
    ----------
    number : (k,) int, which of the caller's rays the path belongs to
    points, normals : (k, 3) float; the normal on the side that was met
    outgoing : (k, 3) float, unit, back toward where the path came from
    materials, triangles : (k,) int
    throughput : (k, C) float
    geometry : (k,) float, 1/m²; G between the surface and the point looked from, inf where nothing is split
    """

    number: IntArray
    points: FloatArray
    normals: FloatArray
    outgoing: FloatArray
    materials: IntArray
    triangles: IntArray
    throughput: FloatArray
    geometry: FloatArray

    @classmethod
    def at(cls, points: FloatArray, normals: FloatArray, *, channels: int) -> Paths:
        """Stand at surface points (k, 3) whose material does not matter, looking along the normals."""
        none = np.zeros(len(points), dtype=np.int64)
        ones = np.ones((len(points), channels))
        return cls(
            np.arange(len(points)), points, normals, normals, none, none, ones, np.full(len(points), np.inf)
        )


def meet(
    world: World, number: IntArray, origins: FloatArray, directions: FloatArray, throughput: FloatArray
) -> tuple[Paths, IntArray]:
    """Follow rays to surfaces; returns the paths there and which of the rays they are."""
    hits = world.caster.closest(origins, directions)
    kept = np.flatnonzero(hits.triangle >= 0)
    paths = Paths(
        number=number,
        points=hits.points,
        normals=hits.normals,
        outgoing=-directions,
        materials=world.materials[hits.triangle],
        triangles=hits.triangle,
        throughput=throughput,
        geometry=np.full(len(number), np.inf),
    )
    return chosen_paths(paths, kept), kept


def chosen_paths(paths: Paths, kept: IntArray) -> Paths:
    """Keep some of the paths, named in order."""
    if len(kept) == len(paths.number):
        return paths
    return Paths(
        paths.number[kept],
        paths.points[kept],
        paths.normals[kept],
        paths.outgoing[kept],
        paths.materials[kept],
        paths.triangles[kept],
        paths.throughput[kept],
        paths.geometry[kept],
    )


def kernel_between(points: FloatArray, cosines: FloatArray, met: Paths) -> FloatArray:
    """G = cos cos' / r² (k,) in 1/m² between points (k, 3), cosines (k,) at them, and the surfaces met from there."""
    square = np.sum((met.points - points) ** 2, axis=1)
    cos_surface = np.einsum("kx,kx->k", met.outgoing, met.normals)
    return np.asarray(cos_surface * cosines / np.maximum(square, 1e-300))
