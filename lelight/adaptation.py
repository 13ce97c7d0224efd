"""The dynamic mesh: triangles over which light is not linear are cut, in rounds.

What is bent is found by direct light, which makes the edges of shadows and the spots of lamps; light that surfaces
exchange is smooth beside it. How far interpolation is off in the end is measured by probes, with all light.
"""

from __future__ import annotations

from concurrent.futures import Executor

import numpy as np

from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import ARRAY
from lelight.estimate.direct import direct_light, with_clear_share
from lelight.mesh.nearest import nearest_points
from lelight.mesh.nodes import NodeMesh
from lelight.receivers import ILLUMINANCE, Receivers, joined, space_receivers, with_surface
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.sampling import Stretch
from lelight.tracing.world import World

#: Rounds of refinement; two halve the edges where it is needed.
ROUNDS = 6
#: Points of a triangle where interpolation is held against light: its middle, and toward each corner.
PLACES: FloatArray = np.array([[2, 2, 2], [4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6.0
#: Shadow rays of each place, as power of two.
LOG2_RAYS = 5
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
    corners = mesh.vertices[mesh.triangles]
    flat = np.einsum("pc,mcx->mpx", PLACES, corners).reshape(-1, 3)
    patches = np.repeat(mesh.triangle_patches, len(PLACES))
    points, traced = nearest_points(flat, patches, world.caster.corners, labels)
    sides = np.repeat(mesh.triangle_sides, len(PLACES))[:, None]
    normals = sides * world.normals[traced]
    inside = _direct(world, points, normals, seed, executor, keep, f"{name} inside")
    inside = inside.reshape(-1, len(PLACES))
    at_nodes = _direct(world, mesh.positions, mesh.normals, seed, executor, keep, f"{name} at nodes")
    off = np.abs(np.einsum("pc,mc->mp", PLACES, at_nodes[mesh.triangles]) - inside).max(axis=1)
    mean = float(np.average(at_nodes, weights=np.where(mesh.hidden, 0.0, mesh.areas)))
    open_triangles = ~mesh.hidden[mesh.triangles].any(axis=1)
    return np.asarray(open_triangles & (off > tolerance * np.maximum(inside.max(axis=1), mean)))


def _direct(
    world: World,
    points: FloatArray,
    normals: FloatArray,
    seed: int,
    executor: Executor,
    keep: Keeper,
    name: str,
) -> FloatArray:
    """Direct illuminance (k,) lx at surface points, without noise where nothing is in the way."""
    receivers = joined([with_surface(space_receivers(points, normals))])

    def part(own: Receivers) -> FloatArray:
        shared = with_clear_share(world, own, seed=(seed, 21))
        moments, _ = direct_light(world, shared, samples=Stretch.of(LOG2_RAYS), seed=(seed, 22))
        return luminance_weighted(moments[:, ILLUMINANCE])

    return np.concatenate([np.zeros(0), *keep.map(executor, name, part, receivers.chunks(CHUNK), ARRAY)])
