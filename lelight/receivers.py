"""Receivers: every place where arriving light is estimated, be it a node, a grid point or an eye.

On a surface only the hemisphere over the normal counts; in space the whole sphere does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lelight.mesh.nodes import NodeMesh
from lelight.scene import BoolArray, FloatArray, IntArray

#: Rows of the moments of arriving light: what they are and where they stand.
ILLUMINANCE, SCALAR, VECTOR, CYLINDRICAL = 0, 1, 2, 5
MOMENTS = 6


@dataclass(frozen=True)
class Receivers:
    """r places with a normal each.

    Attributes
    ----------
    points, normals : (r, 3) float, m and unit length
    frames_x : (r, 3) float, unit, x axis of the local frame
    on_surface : (r,) bool
    hidden : (r,) bool; nodes inside or under something, at which no light is estimated
    degrees : (r,) int; degree of the spherical harmonics that are kept of arriving light, 0 for none
    materials : (r,) int; -1 in space
    identity : (r,) int; number in the whole run, on which the receiver's random numbers depend
    clear_share : (r,) float; roughly how much of the emitters' light is not blocked, found beforehand
    direct_doublings, near_doublings : (r,) int; how much more often, as power of two, a receiver samples
        direct light and near field than a batch's effort says; found beforehand, negative for less
    rows : (r,) int; of the base's guide, -1 where none is known
    known_direct : (r, C) float, lx; the known share of the emitters' light (see `knowndirect`), by the guide's sight;
        (r, 1) and not a number where it is found anew whenever it is wanted
    """

    points: FloatArray
    normals: FloatArray
    frames_x: FloatArray
    on_surface: BoolArray
    hidden: BoolArray
    degrees: IntArray
    materials: IntArray
    identity: IntArray
    clear_share: FloatArray
    direct_doublings: IntArray
    near_doublings: IntArray
    rows: IntArray
    known_direct: FloatArray

    def __len__(self) -> int:
        """Count receivers."""
        return len(self.points)

    def __getitem__(self, chosen: slice | IntArray | BoolArray) -> Receivers:
        """Select some of them."""
        if isinstance(chosen, slice):
            return Receivers(**{name: column[chosen] for name, column in vars(self).items()})
        own = np.flatnonzero(chosen) if chosen.dtype == np.bool_ else chosen
        return Receivers(**{name: column.take(own, axis=0) for name, column in vars(self).items()})

    def chunks(self, size: int) -> list[Receivers]:
        """Cut into pieces of at most ``size``, in order."""
        return [self[slice(first, first + size)] for first in range(0, len(self), size)]


def node_receivers(mesh: NodeMesh) -> Receivers:
    """Take the nodes of a mesh, for what arrives at them and no more."""
    return replace(with_surface(space_receivers(mesh.positions, mesh.normals)), hidden=mesh.hidden)


def surface_receivers(mesh: NodeMesh, degrees: IntArray) -> Receivers:
    """Take the nodes of a mesh; ``degrees`` (n,) says what angular detail each keeps."""
    return replace(
        node_receivers(mesh),
        frames_x=mesh.frames_x,
        degrees=degrees,
        materials=mesh.materials,
    )


def space_receivers(points: FloatArray, normals: FloatArray, *, doublings: int = 0) -> Receivers:
    """Receivers in free space; the normals (r, 3) say on which plane illuminance is measured.

    Parameters
    ----------
    doublings : how much more often, as power of two, they sample than nodes do
    """
    none = np.zeros(len(points), dtype=np.int64)
    return Receivers(
        points=points,
        normals=normals,
        frames_x=np.zeros_like(points),
        on_surface=np.zeros(len(points), dtype=np.bool_),
        hidden=np.zeros(len(points), dtype=np.bool_),
        degrees=none,
        materials=none - 1,
        identity=np.arange(len(points)),
        clear_share=np.zeros(len(points)),
        direct_doublings=none + doublings,
        near_doublings=none + doublings,
        rows=none - 1,
        known_direct=np.full((len(points), 1), np.nan),
    )


def with_surface(receivers: Receivers) -> Receivers:
    """Take places for points of a surface: only what arrives over their normal counts."""
    return replace(receivers, on_surface=np.ones(len(receivers), dtype=np.bool_))


def joined(parts: list[Receivers]) -> Receivers:
    """Put receivers one after the other and number them anew."""
    columns = [vars(part) for part in parts]
    together = {name: np.concatenate([c[name] for c in columns]) for name in columns[0]}
    return Receivers(**together | {"identity": np.arange(len(together["points"]))})
