"""Paths under way: where each stands, and following them to the next surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.compilation import COMPILED, LEAF
from lelight.scene import BoolArray, FloatArray, IntArray
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
    rows : (k,) int, of the guide at the surface, -1 where none is known
    """

    number: IntArray
    points: FloatArray
    normals: FloatArray
    outgoing: FloatArray
    materials: IntArray
    triangles: IntArray
    throughput: FloatArray
    geometry: FloatArray
    rows: IntArray

    @classmethod
    def at(cls, points: FloatArray, normals: FloatArray, *, channels: int) -> Paths:
        """Stand at surface points (k, 3) whose material does not matter, looking along the normals."""
        none = np.zeros(len(points), dtype=np.int64)
        ones = np.ones((len(points), channels))
        split = np.full(len(points), np.inf)
        return cls(
            np.arange(len(points)),
            points,
            normals,
            normals,
            none,
            none,
            ones,
            split,
            unknown_rows(len(points)),
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
        rows=unknown_rows(len(number)),
    )
    return chosen_paths(paths, kept), kept


def unknown_rows(count: int) -> IntArray:
    """Rows (count,) of the guide where none is known."""
    return np.full(count, -1, dtype=np.int64)


def chosen_paths(paths: Paths, kept: IntArray) -> Paths:
    """Keep some of the paths, named in order."""
    if len(kept) == len(paths.number):
        return paths
    return Paths(
        *_chosen(
            paths.number,
            paths.points,
            paths.normals,
            paths.outgoing,
            paths.materials,
            paths.triangles,
            paths.throughput,
            paths.geometry,
            paths.rows,
            kept,
        )
    )


@njit(**COMPILED)
def _chosen(
    number: IntArray,
    points: FloatArray,
    normals: FloatArray,
    outgoing: FloatArray,
    materials: IntArray,
    triangles: IntArray,
    throughput: FloatArray,
    geometry: FloatArray,
    rows: IntArray,
    kept: IntArray,
) -> tuple[
    IntArray, FloatArray, FloatArray, FloatArray, IntArray, IntArray, FloatArray, FloatArray, IntArray
]:
    """Copy the rows of paths that are kept; one call, since paths are thinned out at every surface."""
    count, channels = len(kept), throughput.shape[1]
    out_number, out_geometry = np.empty(count, dtype=np.int64), np.empty(count)
    out_materials, out_triangles = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    out_points, out_normals, out_outgoing = np.empty((count, 3)), np.empty((count, 3)), np.empty((count, 3))
    out_throughput, out_rows = np.empty((count, channels)), np.empty(count, dtype=np.int64)
    for k in range(count):
        own = kept[k]
        out_number[k], out_geometry[k], out_rows[k] = number[own], geometry[own], rows[own]
        out_materials[k], out_triangles[k] = materials[own], triangles[own]
        for axis in range(3):
            out_points[k, axis] = points[own, axis]
            out_normals[k, axis] = normals[own, axis]
            out_outgoing[k, axis] = outgoing[own, axis]
        for c in range(channels):
            out_throughput[k, c] = throughput[own, c]
    return (
        out_number,
        out_points,
        out_normals,
        out_outgoing,
        out_materials,
        out_triangles,
        out_throughput,
        out_geometry,
        out_rows,
    )


def kernel_between(points: FloatArray, cosines: FloatArray, met: Paths) -> FloatArray:
    """G = cos cos' / r² (k,) in 1/m² between points (k, 3), cosines (k,) at them, and the surfaces met from there."""
    return np.asarray(_kernel(points, cosines, met.points, met.normals, met.outgoing))


@njit(**COMPILED)
def _kernel(
    points: FloatArray,
    cosines: FloatArray,
    met_points: FloatArray,
    met_normals: FloatArray,
    outgoing: FloatArray,
) -> FloatArray:
    kernel = np.empty(len(points))
    for k in range(len(points)):
        square, cos_surface = 0.0, 0.0
        for axis in range(3):
            square += (met_points[k, axis] - points[k, axis]) ** 2
            cos_surface += outgoing[k, axis] * met_normals[k, axis]
        kernel[k] = cos_surface * cosines[k] / max(square, 1e-300)
    return kernel


@njit(**LEAF)
def add_clear(radiance: FloatArray, number: IntArray, light: FloatArray, clear: BoolArray) -> None:
    """Add the light (k, C) of rays that nothing blocks to the radiance (n, C) of the paths they belong to."""
    for k in range(len(number)):
        if clear[k]:
            for c in range(light.shape[1]):
                radiance[number[k], c] += light[k, c]
