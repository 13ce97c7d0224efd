"""A first field, solved on the mesh, that the estimate stands on.

Each node sends out rays once; what nodes gather where these meet the mesh is a sparse operator A, and the field
e = E_direct + A e is solved at almost no cost. It is a draft: it carries the noise of its rays
and the error of interpolation. The batches put that right, whatever it is: they estimate what is missing.
"""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lelight.channels import luminance_weighted
from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import form_of
from lelight.compilation import COMPILED, LEAF
from lelight.estimate.cells import Cells
from lelight.estimate.direct import direct_light_and_sight
from lelight.estimate.gmres import gmres
from lelight.estimate.guide import Guide, cells_of, densities, sides_for
from lelight.estimate.nearfield import hemisphere_rays
from lelight.mesh.locate import Locator, interpolate
from lelight.mesh.neighbours import alike
from lelight.mesh.nodes import NodeMesh
from lelight.receivers import ILLUMINANCE, Receivers
from lelight.scene import BoolArray, FloatArray, IntArray
from lelight.tracing.rays import Float32Array
from lelight.tracing.sight import Shares, shares
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World

#: Rays of each node, as power of two: more make the draft smoother, and the batches' work lighter. Few nodes have the
#: more, many the fewer, so that all of them together are at most so many.
MOST_LOG2_RAYS, LEAST_LOG2_RAYS, LOG2_ALL_RAYS = 8, 5, 21
LOG2_DIRECT = 6
#: The solution stops where this share of the direct light is left; steps of the solver, and starts anew.
SETTLED = 1e-8
RESTART, MOST_RESTARTS = 40, 25
CHUNK = 1024
#: The base holds direct light up to so many times its mean over the surface.
BRIGHTEST_SPOT = 10.0
#: A surface this many times brighter still has spots that rays hardly find.
SPOT = 10.0


@dataclass(frozen=True)
class BaseField:
    """Illuminance on the mesh, taken as given by the estimators.

    Attributes
    ----------
    labels : (n_t,) int, patch of each traced triangle
    locator : finds the nodes around a surface point
    illuminance : (n, C) float, lx at the nodes
    lit : (n_patches, 2) bool, sides that receive light
    diffuse : (n_materials, C) float, kd
    materials : (n_t,) int of each traced triangle
    spots : whether lamps make spots on surfaces, too small and too bright for rays to find
    guide : where light comes from at the nodes; None where that was not asked
    starts : where chains that carry what it lacks start; None where nothing reflects, or before that is measured
    """

    labels: IntArray
    locator: Locator
    illuminance: FloatArray
    lit: BoolArray
    diffuse: FloatArray
    materials: IntArray
    spots: bool = False
    guide: Guide | None = None
    starts: Cells | None = None

    def illuminance_at(self, triangles: IntArray, points: FloatArray, front: BoolArray) -> FloatArray:
        """Interpolate the field (k, C), lx, at points (k, 3) on traced triangles (k,)."""
        return interpolate(self.illuminance, *self._around(triangles, points, front))

    def luminance_at(
        self, triangles: IntArray, points: FloatArray, front: BoolArray
    ) -> tuple[FloatArray, IntArray]:
        """Tell what the Lambertian lobes make of it (k, C), cd/m², and the node (k,) of most weight, -1 if none."""
        nodes, weights = self._around(triangles, points, front)
        light = interpolate(self.illuminance, nodes, weights)
        _reflect(light, self.diffuse, self.materials, triangles)
        return light, _heaviest(nodes, weights)

    def _around(
        self, triangles: IntArray, points: FloatArray, front: BoolArray
    ) -> tuple[IntArray, FloatArray]:
        """Nodes (k, 3) around points (k, 3) and their weights; none where all are hidden, as under a cupboard.

        What the base said there would be lacking, and chains start from it that light what nobody sees.
        """
        sides = np.where(front, 1, -1)
        return self.locator.find(points, self.labels[triangles], sides, stand_in=False)


@njit(**COMPILED)
def _heaviest(nodes: IntArray, weights: FloatArray) -> IntArray:
    """Node (k,) with the largest weight of each three (k, 3), -1 where none has any."""
    heaviest = np.full(len(nodes), -1, dtype=np.int64)
    for k in range(len(nodes)):
        most = 0.0
        for corner in range(3):
            if weights[k, corner] > most:
                most, heaviest[k] = weights[k, corner], nodes[k, corner]
    return heaviest


@njit(**LEAF)
def _reflect(light: FloatArray, diffuse: FloatArray, materials: IntArray, triangles: IntArray) -> None:
    """Make luminance of illuminance (k, C), in place."""
    for k in range(len(light)):
        m = materials[triangles[k]]
        for c in range(light.shape[1]):
            light[k, c] *= diffuse[m, c] / math.pi


def solve_base(
    world: World,
    mesh: NodeMesh,
    receivers: Receivers,
    *,
    labels: IntArray,
    lit: BoolArray,
    seed: int,
    executor: Executor,
    keep: Keeper | None = None,
    name: str = "base",
) -> BaseField:
    """Solve for the illuminance at all nodes of the mesh; gloss reflects as if it were Lambertian here.

    Parameters
    ----------
    receivers : those of the nodes, in their order
    keep, name : remembers what was found under this name, if anything shall
    """
    locator = Locator(mesh)
    keep = keep or Keeper()

    def solve() -> _Solved:
        seen = np.flatnonzero(~mesh.hidden)
        log2_rays = log2_rays_for(len(seen))
        parts = keep.map(
            executor,
            f"{name}/rows",
            lambda own: _rows(world, locator, receivers[own], labels, seed, log2_rays),
            [seen[first : first + CHUNK] for first in range(0, len(seen), CHUNK)],
            form_of(_Rows),
        )
        return _solution(world, mesh, _Rows.stacked(list(parts)).among(len(mesh), seen))

    solved = keep.once(name, solve, form_of(_Solved))
    return BaseField(
        labels=labels,
        locator=locator,
        illuminance=solved.illuminance,
        lit=lit,
        diffuse=world.reflectances.diffuse,
        materials=world.materials,
        spots=solved.spots,
        guide=Guide.of(solved.density, solved.sight, mesh.positions, mesh.normals, hidden=mesh.hidden),
    )


@dataclass(frozen=True)
class _Rows:
    """Direct light of some nodes, and what their rays met, node by node.

    Attributes
    ----------
    direct : (r, C) float
    sent : (r, cells) uint8, rays into each cell of the guide
    counts : (r,) int, rays of each node that met something
    cells : (h,) int, of the guide, that each of those went into
    nodes, weights : (h, 3) int and float, around the place that it met; weights are shares of one ray. What few rays
        have drawn needs no double precision
    asked, clear : (r, S) uint8, rays that went to each source, and those of them that met nothing
    """

    direct: FloatArray
    sent: NDArray[np.uint8]
    counts: NDArray[np.int32]
    cells: NDArray[np.int32]
    nodes: NDArray[np.int32]
    weights: Float32Array
    asked: NDArray[np.uint8]
    clear: NDArray[np.uint8]

    @classmethod
    def stacked(cls, parts: list[_Rows]) -> _Rows:
        """Put the rows of all nodes one after the other."""
        return cls(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(cls)))

    def among(self, count: int, seen: IntArray) -> _Rows:
        """Rows of so many nodes, those that there are being of these (r,), in order; the others met nothing."""
        if len(seen) == count:
            return self
        of_nodes = {}
        for name in ("direct", "sent", "counts", "asked", "clear"):
            own = getattr(self, name)
            of_nodes[name] = np.zeros((count, *own.shape[1:]), dtype=own.dtype)
            of_nodes[name][seen] = own
        return replace(self, **of_nodes)


@dataclass(frozen=True)
class _Solved:
    """Illuminance (n, C), whether there are spots, and the guide's density (n, s, s) and sight (n, S)."""

    illuminance: FloatArray
    spots: bool
    density: Float32Array
    sight: Shares


def _solution(world: World, mesh: NodeMesh, rows: _Rows) -> _Solved:
    """Solve for the illuminance, and tell by it where light comes from."""
    direct = rows.direct
    # The spot that a close lamp makes is left to the chains, which light leads there; rays would miss it.
    most = BRIGHTEST_SPOT * np.average(direct, axis=0, weights=mesh.visible_areas)
    spots = bool(np.any(direct[~mesh.hidden] > SPOT * most))
    direct = np.minimum(direct, most)
    albedo = world.reflectances.diffuse + world.reflectances.specular
    reflected = albedo[mesh.materials]
    illuminance = _solved(rows, direct, reflected)
    light, exitance = np.zeros(rows.sent.shape), luminance_weighted(reflected * illuminance)
    _add_to_cells(rows.weights, rows.nodes, rows.counts, rows.cells, exitance, light)
    around = alike(mesh.positions, mesh.normals, left_out=mesh.hidden)
    return _Solved(
        illuminance, spots, densities(light, rows.sent, around), shares(rows.asked, rows.clear, around)
    )


def log2_rays_for(nodes: float) -> int:
    """Rays of each of so many nodes, as power of two."""
    return int(np.clip(LOG2_ALL_RAYS - math.log2(max(nodes, 1.0)), LEAST_LOG2_RAYS, MOST_LOG2_RAYS))


def _rows(
    world: World, locator: Locator, receivers: Receivers, labels: IntArray, seed: int, log2_rays: int
) -> _Rows:
    """Trace the rays of some nodes."""
    direct, asked, clear = direct_light_and_sight(
        world, receivers, samples=Stretch.of(LOG2_DIRECT), seed=(seed, 7)
    )
    origins, directions, owner, numbers = hemisphere_rays(
        world, receivers, samples=Stretch.of(log2_rays), seed=(seed, 8)
    )
    hits = world.caster.closest(origins, directions)
    met = np.flatnonzero(hits.triangle >= 0)
    triangle = hits.triangle[met]
    sides = np.where(hits.front[met], 1, -1)
    nodes, weights = locator.find(hits.points[met], labels[triangle], sides)
    across = sides_for(log2_rays)
    cells = cells_of(numbers, across)
    sent = np.bincount(owner * across**2 + cells, minlength=len(receivers) * across**2)
    return _Rows(
        direct=direct[:, ILLUMINANCE],
        sent=sent.reshape(-1, across**2).astype(np.uint8),
        counts=np.bincount(owner[met], minlength=len(receivers)).astype(np.int32),
        cells=cells[met].astype(np.int32),
        nodes=nodes.astype(np.int32),
        weights=(weights / 2**log2_rays).astype(np.float32),
        asked=asked,
        clear=clear,
    )


@njit(**LEAF)
def _gather(
    weights: Float32Array,
    nodes: NDArray[np.int32],
    counts: NDArray[np.int32],
    exitance: FloatArray,
    gathered: FloatArray,
) -> None:
    """Write what nodes (n,) gather by their rays where each node sends out (n,)."""
    h = 0
    for i in range(len(counts)):
        total = 0.0
        for _ in range(counts[i]):
            for corner in range(3):
                total += weights[h, corner] * exitance[nodes[h, corner]]
            h += 1
        gathered[i] = total


@njit(**LEAF)
def _add_to_cells(
    weights: Float32Array,
    nodes: NDArray[np.int32],
    counts: NDArray[np.int32],
    cells: NDArray[np.int32],
    exitance: FloatArray,
    light: FloatArray,
) -> None:
    """Add what nodes gather to the cells (n, cells) that it came through."""
    h = 0
    for i in range(len(counts)):
        for _ in range(counts[i]):
            for corner in range(3):
                light[i, cells[h]] += weights[h, corner] * exitance[nodes[h, corner]]
            h += 1


def _solved(rows: _Rows, direct: FloatArray, albedo: FloatArray) -> FloatArray:
    """Find the fixed point e = direct + A (albedo e), (n, C), channel by channel.

    Walls that reflect nearly all need a few dozen steps of GMRES, where plain iteration needs thousands.
    """
    illuminance = np.empty_like(direct)
    for c in range(direct.shape[1]):
        scale = float(direct[:, c].max(initial=0.0))
        own = direct[:, c] / scale if scale > 0.0 else direct[:, c]
        found = gmres(
            partial(_without_reflection, rows, albedo[:, c]),
            own,
            settled=SETTLED,
            restart=RESTART,
            most=MOST_RESTARTS,
        )
        illuminance[:, c] = np.maximum(found, 0.0) * scale
    return illuminance


def _without_reflection(rows: _Rows, albedo: FloatArray, illuminance: FloatArray) -> FloatArray:
    """Take from an illuminance (n,) what is gathered from the others: e - A (albedo e)."""
    gathered = np.empty_like(illuminance)
    _gather(rows.weights, rows.nodes, rows.counts, albedo * illuminance, gathered)
    return illuminance - gathered
