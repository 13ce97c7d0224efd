"""A short walk before the run: which sides of which patches light reaches, and which nodes are buried.

Light reaches a place where a walk from it, that nothing absorbs, comes to see an emitter. Inside a closed
piece of furniture no walk ever does; at the dark end of a corridor one soon will.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from lelight.checkpoint.keeper import Keeper
from lelight.checkpoint.records import ARRAY
from lelight.estimate.direct import direct_light
from lelight.estimate.nearfield import hemisphere_rays
from lelight.estimate.paths import hashed_numbers
from lelight.estimate.pathstate import Paths, chosen_paths, meet
from lelight.mesh.enclosures import enclosures
from lelight.mesh.nodes import NodeMesh
from lelight.receivers import ILLUMINANCE, Receivers, space_receivers, surface_receivers, with_surface
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas
from lelight.tracing.chains import emission_chains, hash_of
from lelight.tracing.rays import Hits
from lelight.tracing.sampling import cosine_directions
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World

#: Chains of the pilot walk, as power of two.
LOG2_PILOT_CHAINS = 13
#: Places on each side that the pilot walk did not visit, from which walks are sent out.
PLACES_PER_SIDE = 4
#: Rays from each place that tell whether it lies in a solid, as power of two.
LOG2_LOOKS = 2
#: Walks from a place or node, as power of two, and their longest; most find light at once.
ONE_WALK, FEW_WALKS = (0, 4), (2, 32)
#: Likewise, from nodes for which those found no light: the far end of a corridor is not the inside of a cupboard.
MANY_WALKS = (4, 96)
#: How near a node lies to a surface that it touches, in distances at which rays start.
TOUCHING = 2.5
#: How far such a node steps toward the middle of a triangle, and the rays that tell how much room is above.
STEP_ASIDE, LOG2_ROOM_RAYS = 0.1, 5
#: Shadow rays to the emitters, as power of two, from places that no walk found light for: a slit as wide as a
#: pixel lets one of a few hundred through.
LOG2_SLIT_RAYS = 10
#: Receivers asked at once.
CHUNK = 512


def lit_sides(
    scene: Scene,
    world: World,
    *,
    labels: IntArray,
    seed: int,
    executor: Executor,
    keep: Keeper | None = None,
) -> BoolArray:
    """Say which sides of the patches receive light, (n_patches, 2): front, back.

    Parameters
    ----------
    labels : (n_t,) int, patch of each traced triangle
    keep : remembers what was found out, if anything shall
    """
    walks = _Walks(world, executor, keep or Keeper(), "sides")
    lit = np.zeros((int(labels.max()) + 1, 2), dtype=np.bool_)
    vertices = emission_chains(world, Stretch.of(LOG2_PILOT_CHAINS), seed=(seed, 0))
    lit[labels[vertices.triangles], np.where(vertices.front, 0, 1)] = True
    inner = _enclosed(scene, world, labels, seed)
    patches, sides = np.nonzero(~lit & ~inner)
    if len(patches):
        places, owner = _places(scene, labels, patches, sides, seed)
        outside = np.flatnonzero(~_within(world, places, labels, inner, seed))
        places, owner = places[outside], owner[outside]
        for ask in (
            partial(walks.reached, walks=ONE_WALK, seed=(seed, 8)),
            partial(walks.reached, walks=FEW_WALKS, seed=(seed, 1)),
            partial(walks.seen_through_slits, seed=(seed, 4)),
        ):
            found = owner[ask(places)]
            lit[patches[found], sides[found]] = True
            # One place is enough for a side.
            left = np.flatnonzero(~lit[patches[owner], sides[owner]])
            places, owner = places[left], owner[left]
    return lit & open_sides(world, labels)


def _enclosed(scene: Scene, world: World, labels: IntArray, seed: int) -> BoolArray:
    """Sides (n_patches, 2) that look into a closed solid.

    A surface that cuts through itself may be turned inside out somewhere: from an inner side no ray gets out, none
    meets the solid's outside, and half of them meet its inside. Others may meet what stands in the solid or touches it.
    """
    found = enclosures(scene)
    count = int(labels.max()) + 1
    inner = np.stack([np.bincount(labels, ~found.inner[:, side], count) == 0 for side in (0, 1)], axis=1)
    patches, sides = np.nonzero(inner)
    places, owner = _places(scene, labels, patches, sides, seed)
    hits, place = _first_looks(world, places, seed)
    side = owner[place]
    solid = found.solid[np.unique(labels, return_index=True)[1][patches[side]]]
    met = np.maximum(hits.triangle, 0)
    own = (hits.triangle >= 0) & (found.solid[met] == solid)
    within = found.inner[met, np.where(hits.front, 0, 1)]
    out = np.bincount(side, (hits.triangle < 0) | (own & ~within), len(patches)) > 0
    sound = ~out & (
        2 * np.bincount(side, own & within, len(patches)) >= np.bincount(side, minlength=len(patches))
    )
    inner[patches[~sound], sides[~sound]] = False
    return inner


def _within(world: World, places: Receivers, labels: IntArray, inner: BoolArray, seed: int) -> BoolArray:
    """Say which places (k,) lie within solids, as the foot of a book does in the board that it stands on."""
    hits, place = _first_looks(world, places, seed)
    walls = (hits.triangle >= 0) & inner[labels[hits.triangle], np.where(hits.front, 0, 1)]
    return np.asarray(np.bincount(place, walls, len(places)) > 0)


def _first_looks(world: World, places: Receivers, seed: int) -> tuple[Hits, IntArray]:
    """Send a few rays from each place: what they meet, and from which place (k,) each went."""
    origins, directions, place, _ = hemisphere_rays(
        world, places, samples=Stretch.of(LOG2_LOOKS), seed=(seed, 6)
    )
    return world.caster.closest(origins, directions), place


def open_sides(world: World, labels: IntArray) -> BoolArray:
    """Sides (n_patches, 2) that are sides of their own; labels (n_t,) are the patches of the traced triangles."""
    sides = np.ones((int(labels.max()) + 1, 2), dtype=np.bool_)
    # The back of a face that lies back to back with another is the other's front.
    sides[:, 1] = False
    sides[labels[world.caster.backs < 0], 1] = True
    return sides


def buried(
    world: World,
    mesh: NodeMesh,
    *,
    seed: int,
    executor: Executor,
    keep: Keeper | None = None,
    name: str = "buried",
) -> BoolArray:
    """Nodes (n,) that no light can reach: they lie where solids touch, or inside them.

    Parameters
    ----------
    keep, name : remembers what was found out under this name, if anything shall
    """
    walks = _Walks(world, executor, keep or Keeper(), name)
    receivers = surface_receivers(mesh, np.zeros(len(mesh), dtype=np.int64))
    dark = ~walks.reached(receivers, ONE_WALK, (seed, 7))
    dark[dark] = ~walks.reached(receivers[dark], FEW_WALKS, (seed, 2))
    dark[dark] = ~walks.reached(receivers[dark], MANY_WALKS, (seed, 3))
    dark[dark] = ~walks.seen_through_slits(receivers[dark], (seed, 5))
    return dark


def stepped_aside(world: World, mesh: NodeMesh) -> NodeMesh:
    """Move nodes that lie on another surface a little way into that triangle around them which has most room above.

    A floor patch that runs on under a cupboard has nodes in the plane of its front: one step out there is the
    room's light, one step in the dark.
    """
    touched = np.flatnonzero(touching(world, mesh))
    if not len(touched):
        return mesh
    triangle, corner = np.nonzero(np.isin(mesh.triangles, touched))
    node = mesh.triangles[triangle, corner]
    middles = mesh.vertices[mesh.triangles[triangle]].mean(axis=1)
    places = mesh.positions[node] + STEP_ASIDE * (middles - mesh.positions[node])
    moved = replace(
        mesh, **{name: getattr(mesh, name)[node] for name in ("normals", "frames_x")}, positions=places
    )
    room = np.where(touching(world, moved), -1.0, _room_above(world, moved))
    best = np.lexsort((room, node))
    best = best[np.append(node[best][1:] != node[best][:-1], True)]
    best = best[room[best] >= 0.0]
    positions = mesh.positions.copy()
    positions[node[best]] = places[best]
    return replace(mesh, positions=positions)


def _room_above(world: World, mesh: NodeMesh) -> FloatArray:
    """Mean distance (n,) in m that light can come from over each place."""
    places = with_surface(space_receivers(mesh.positions, mesh.normals))
    origins, directions, owner, _ = hemisphere_rays(
        world, places, samples=Stretch.of(LOG2_ROOM_RAYS), seed=(0, 6)
    )
    hits = world.caster.closest(origins, directions)
    reach = np.linalg.norm(hits.points - origins, axis=1)
    reach[hits.triangle < 0] = 2.0 / world.caster.scale
    return np.asarray(np.bincount(owner, reach, minlength=len(places)) / 2**LOG2_ROOM_RAYS)


def touching(world: World, mesh: NodeMesh) -> BoolArray:
    """Nodes (n,) that lie on another surface, as where the front of a cupboard meets the floor.

    Such a node is half in one space and half in the other; what it gets is for rounding to decide.
    """
    across = np.cross(mesh.normals, mesh.frames_x)
    places = world.caster.leave(mesh.positions, mesh.normals)
    reach = TOUCHING * world.caster.offset
    touched = np.zeros(len(mesh), dtype=np.bool_)
    for angle in np.arange(4) * np.pi / 4:
        way = reach * (np.cos(angle) * mesh.frames_x + np.sin(angle) * across)
        touched |= ~world.caster.visible(places - way, places + way)
    return touched


@dataclass(frozen=True)
class _Walks:
    """Walks and looks from surface receivers (r,), by as many threads as there are."""

    world: World
    executor: Executor
    keep: Keeper
    name: str

    def seen_through_slits(self, receivers: Receivers, seed: tuple[int, ...]) -> BoolArray:
        """Say from which any of many points of the emitters is in sight."""
        ask = partial(_sees_emitter, self.world, seed=seed, log2_samples=LOG2_SLIT_RAYS)
        return self._asked(ask, receivers.chunks(max(1, CHUNK >> LOG2_SLIT_RAYS // 2)), seed)

    def reached(self, receivers: Receivers, walks: tuple[int, int], seed: tuple[int, ...]) -> BoolArray:
        """`reached_by_light` for many."""
        ask = partial(reached_by_light, self.world, walks=walks, seed=seed)
        return self._asked(ask, receivers.chunks(CHUNK), seed)

    def _asked(
        self, ask: Callable[[Receivers], BoolArray], chunks: list[Receivers], seed: tuple[int, ...]
    ) -> BoolArray:
        parts = self.keep.map(self.executor, f"mesh/{self.name} {seed[-1]}", ask, chunks, ARRAY)
        return np.concatenate([np.zeros(0, dtype=np.bool_), *parts])


def reached_by_light(
    world: World, receivers: Receivers, *, walks: tuple[int, int], seed: tuple[int, ...]
) -> BoolArray:
    """Say which surface receivers (r,) light can reach, by unabsorbed walks from them.

    Parameters
    ----------
    walks : how many from each, as power of two, and how many surfaces one visits at most
    """
    log2_walks, longest = walks
    reached = np.zeros(len(receivers), dtype=np.bool_)
    origins, directions, owner, _ = hemisphere_rays(
        world, receivers, samples=Stretch.of(log2_walks), seed=seed
    )
    reached |= _sees_emitter(world, receivers, seed)
    identity = receivers.identity[owner] * 2**log2_walks + np.arange(len(owner)) % 2**log2_walks
    walkers, _ = meet(world, np.arange(len(owner)), origins, directions, np.ones((len(owner), 1)))
    for depth in range(longest):
        walkers = chosen_paths(walkers, np.flatnonzero(~reached[owner[walkers.number]]))
        if not len(walkers.number):
            break
        own = identity[walkers.number]
        places = with_surface(space_receivers(walkers.points, walkers.normals))
        places = replace(places, identity=own)
        bright = _shines_back(world, walkers) | _sees_emitter(world, places, (*seed, depth))
        reached[owner[walkers.number[bright]]] = True
        walkers = _onward(world, walkers, hashed_numbers(hash_of((*seed, 1)), own, depth))
    return reached


def _onward(world: World, walkers: Paths, numbers: FloatArray) -> Paths:
    directions = cosine_directions(numbers[:, :2], walkers.normals)
    origins = world.caster.leave(walkers.points, walkers.normals)
    return meet(world, walkers.number, origins, directions, walkers.throughput)[0]


def _sees_emitter(
    world: World, receivers: Receivers, seed: tuple[int, ...], *, log2_samples: int = 0
) -> BoolArray:
    """Say from which surface receivers (r,) a drawn point of an emitter is in sight."""
    moments, _ = direct_light(world, receivers, samples=Stretch.of(log2_samples), seed=seed)
    return np.asarray(moments[:, ILLUMINANCE].max(axis=1) > 0.0)


def _shines_back(world: World, walkers: Paths) -> BoolArray:
    """Say which walkers stand on an emitter that shines toward where they came from."""
    emitters = world.emitters
    source = emitters.of_triangle[walkers.triangles]
    front = np.einsum("kx,kx->k", walkers.normals, world.normals[walkers.triangles]) > 0
    both = emitters.both_sides[np.maximum(source, 0)] if len(emitters.areas) else np.zeros_like(front)
    return np.asarray((source >= 0) & (front | both))


def _places(
    scene: Scene, labels: IntArray, patches: IntArray, sides: IntArray, seed: int
) -> tuple[Receivers, IntArray]:
    """Draw places by area on the sides in question; also which side (index into ``patches``) each is on."""
    rng = np.random.default_rng((seed, PLACES_PER_SIDE))
    order = np.argsort(labels, kind="stable")
    reach = np.cumsum(triangle_areas(scene.corners)[order])
    last = np.searchsorted(labels[order], patches, side="right") - 1
    first = np.searchsorted(labels[order], patches, side="left")
    below = np.where(first > 0, reach[first - 1], 0.0)
    owner = np.repeat(np.arange(len(patches)), PLACES_PER_SIDE)
    at = below[owner] + rng.random(len(owner)) * (reach[last] - below)[owner]
    triangle = order[np.clip(np.searchsorted(reach, at), first[owner], last[owner])]
    root, v = np.sqrt(rng.random(len(owner))), rng.random(len(owner))
    weights = np.stack([1.0 - root, root * (1.0 - v), root * v], axis=1)
    corners = scene.vertices[scene.triangles[triangle]]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    normals = np.where(sides[owner] == 0, 1.0, -1.0)[:, None] * cross / np.maximum(length, 1e-300)
    points = np.einsum("kc,kcx->kx", weights, corners)
    return with_surface(space_receivers(points, normals)), owner
