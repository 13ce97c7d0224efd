"""The dynamic mesh: triangles over which light is not linear are cut, in rounds.

First by direct light, which makes the edges of shadows and the spots of lamps; then by the light that surfaces
exchange, gathered from a base field: it bends in corners and under what stands close to a surface. How far
interpolation is off in the end is measured by probes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

import numpy as np

from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import ARRAY
from lelight.estimate.base import BaseField
from lelight.estimate.direct import direct_light, with_clear_share
from lelight.estimate.nearfield import near_field
from lelight.estimate.turns import Turn
from lelight.mesh.locate import interpolate
from lelight.mesh.nearest import nearest_points
from lelight.mesh.nodes import NodeMesh
from lelight.receivers import ILLUMINANCE, Receivers, node_receivers, space_receivers, with_surface
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World

#: Rounds of refinement by direct light, then by exchanged light; two halve the edges where it is needed.
ROUNDS, ROUNDS_OF_EXCHANGE = 6, 4
#: Points of a triangle where interpolation is held against light: its middle, and toward each corner.
PLACES: FloatArray = np.array([[2, 2, 2], [4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6.0
MIDDLE = PLACES[:1]
#: Shadow rays of each place, and rays that gather exchanged light in each half of the trial, as powers of two.
LOG2_RAYS, LOG2_GATHERED = 5, 6
CHUNK = 1024


def bent(
    world: World,
    mesh: NodeMesh,
    labels: IntArray,
    *,
    tolerance: float,
    seed: int,
    executor: Executor,
    keep: Keeper | None = None,
    name: str = "bent",
) -> BoolArray:
    """Say over which triangles (m,) of the mesh interpolated direct light is off by more than the tolerance.

    Parameters
    ----------
    labels : (n_t,) int, patch of each traced triangle
    tolerance : relative to the direct illuminance there, or to its mean where that is more
    keep, name : remembers what was found under this name, if anything shall
    """
    keep = keep or Keeper()
    places = [_inside(world, mesh, labels, PLACES), node_receivers(mesh)]
    light = partial(_direct, world, seed, len(places[0]))
    inside, at_nodes = (
        _by_chunks(light, own, executor, keep, f"{name} {what}")
        for own, what in zip(places, ("inside", "at nodes"), strict=True)
    )
    inside = inside.reshape(-1, len(PLACES))
    off = np.abs(np.einsum("pc,mc->mp", PLACES, at_nodes[mesh.triangles]) - inside).max(axis=1)
    return _beyond(mesh, off, tolerance, inside.max(axis=1), at_nodes)


def bent_by_exchange(
    world: World,
    base: BaseField,
    mesh: NodeMesh,
    labels: IntArray,
    *,
    tolerance: float,
    seed: int,
    executor: Executor,
    keep: Keeper | None = None,
    name: str = "exchange",
) -> BoolArray:
    """Say over which triangles (m,) of the mesh interpolated light from surfaces is off by more than the tolerance.

    All places send their rays out alike, so that noise cuts a triangle seldom; and two halves of them must agree.

    Parameters
    ----------
    base : what surfaces send out; its nodes need not be those of the mesh
    labels : (n_t,) int, patch of each traced triangle
    tolerance : relative to all light there by the base, or to its mean where that is more
    keep, name : remembers what was found under this name, if anything shall
    """
    keep = keep or Keeper()
    places = [_all_alike(each) for each in (_inside(world, mesh, labels, MIDDLE), node_receivers(mesh))]
    off = []
    for half in (0, 1):
        light = partial(_exchanged, world, replace(base, guide=None), (seed, 23 + half))
        inside, at_nodes = (
            _by_chunks(light, own, executor, keep, f"{name} {half}/{what}") for what, own in enumerate(places)
        )
        off.append(at_nodes[mesh.triangles].mean(axis=1) - inside)
    least = np.where(off[0] * off[1] > 0.0, np.minimum(*np.abs(off)), 0.0)
    found = base.locator.find(mesh.positions, mesh.patches, mesh.sides)
    level = luminance_weighted(interpolate(base.illuminance, *found))
    return _beyond(mesh, least, tolerance, level[mesh.triangles].mean(axis=1), level)


def _beyond(
    mesh: NodeMesh, off: FloatArray, tolerance: float, level: FloatArray, at_nodes: FloatArray
) -> BoolArray:
    """Triangles (m,) without hidden nodes where ``off`` exceeds the tolerance of the light there or on average."""
    mean = float(np.average(at_nodes, weights=mesh.visible_areas))
    return np.asarray(mesh.open_triangles & (off > tolerance * np.maximum(level, mean)))


def _inside(world: World, mesh: NodeMesh, labels: IntArray, places: FloatArray) -> Receivers:
    """Receivers (m * p,) at places (p, 3), in barycentric coordinates, in the triangles; hidden where a node is."""
    flat = np.einsum("pc,mcx->mpx", places, mesh.vertices[mesh.triangles]).reshape(-1, 3)
    patches = np.repeat(mesh.triangle_patches, len(places))
    points, traced = nearest_points(flat, patches, world.caster.corners, labels)
    normals = np.repeat(mesh.triangle_sides, len(places))[:, None] * world.normals[traced]
    receivers = with_surface(space_receivers(points, normals))
    return replace(receivers, hidden=np.repeat(~mesh.open_triangles, len(places)))


def _all_alike(receivers: Receivers) -> Receivers:
    """Let all send rays out in the same directions over their normals."""
    return replace(receivers, identity=np.zeros_like(receivers.identity))


def _by_chunks(
    light: Callable[[Receivers], FloatArray],
    receivers: Receivers,
    executor: Executor,
    keep: Keeper,
    name: str,
) -> FloatArray:
    """Illuminance (k,) lx at receivers, as many at once as a thread takes."""
    return np.concatenate([np.zeros(0), *keep.map(executor, name, light, receivers.chunks(CHUNK), ARRAY)])


def _exchanged(world: World, base: BaseField, seed: tuple[int, int], own: Receivers) -> FloatArray:
    """Illuminance (k,) lx by what surfaces send out."""
    together = (Turn.of_all(Stretch.of(LOG2_GATHERED), len(own)),)
    moments, _, _ = near_field(world, own, bound=math.inf, together=together, seed=seed, base=base)
    return luminance_weighted(moments[:, ILLUMINANCE])


def _direct(world: World, seed: int, among: int, own: Receivers) -> FloatArray:
    """Direct illuminance (k,) lx, of so many places in all, without noise where nothing is in the way."""
    shared = with_clear_share(world, own, seed=(seed, 21), among=among)
    moments, _ = direct_light(world, shared, samples=Stretch.of(LOG2_RAYS), seed=(seed, 22))
    return luminance_weighted(moments[:, ILLUMINANCE])
