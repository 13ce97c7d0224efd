"""The radiance field: what every surface of the scene looks like from every side.

It holds, for each node, illuminance with its standard error and the reflected radiance in spherical
harmonics; between nodes it interpolates. Emission and the images of emitters in glossy surfaces are added
when a direction is evaluated.
"""

from __future__ import annotations

import math
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from lelight.camera import Camera, as_picture, stratified_offsets
from lelight.channels import luminance_weighted
from lelight.errors import OutputError
from lelight.estimate.pathstate import Paths, chosen_paths
from lelight.harmonics.bynode import synthesise_by_node
from lelight.harmonics.frames import to_local
from lelight.harmonics.indices import degree_of
from lelight.harmonics.synthesis import synthesise_at
from lelight.incident import IncidentLight
from lelight.mesh.locate import Locator
from lelight.mesh.nearest import TriangleGrid
from lelight.mesh.nodes import NodeMesh
from lelight.mesh.patches import patches
from lelight.results import NodeValues
from lelight.scene import FloatArray, IntArray, Scene
from lelight.spectral.bands import BANDS
from lelight.tracing.world import World, build_world
from lelight.viewrays import Seen, ViewRays
from lelight.writing.fieldfile import read_field, write_field

#: Rays evaluated at once by one thread.
CHUNK = 1 << 15
#: Draws for the image of the emitters in a glossy surface, as power of two: for a single direction, and for
#: all the rays of a pixel together.
LOG2_HIGHLIGHTS, LOG2_HIGHLIGHTS_OF_PIXEL = 6, 3
#: A point lies on a surface when it is no further from it than this many ray offsets.
SURFACE_OFFSETS = 10.0
#: Mirrors behind mirrors that are followed.
DEEPEST_MIRROR = 4


@dataclass(frozen=True)
class RadianceField:
    """Reflected light on the nodes of a mesh, to be evaluated anywhere.

    Attributes
    ----------
    scene : what was lit
    mesh, values : the nodes, and the light at them
    labels : (n_t,) int, patch of each triangle of the scene
    world : the traced scene
    incident : arriving light, from which `lelight.relighting` makes other materials; None where it is not kept
    """

    scene: Scene
    mesh: NodeMesh
    values: NodeValues
    labels: IntArray
    world: World
    incident: IncidentLight | None = None

    @property
    def illuminance(self) -> FloatArray:
        """(n,) float, lx at the nodes, luminance-weighted."""
        return luminance_weighted(self.values.illuminance)

    @property
    def std_error(self) -> FloatArray:
        """(n,) float, lx: one standard error of `illuminance`."""
        return self.values.std_error

    @property
    def reflected_exitance(self) -> FloatArray:
        """(n, C) float, lm/m², including what the Phong lobe would send below the horizon."""
        reflectances = self.world.reflectances
        albedo = reflectances.diffuse[self.mesh.materials] + reflectances.specular[self.mesh.materials]
        return albedo * self.values.illuminance

    @property
    def exitance(self) -> FloatArray:
        """(n, C) float, lm/m²: reflected and emitted."""
        return self.reflected_exitance + math.pi * self.emission

    @property
    def luminance_along_normal(self) -> FloatArray:
        """(n, C) float, cd/m² of each node seen along its normal, without highlights of emitters."""
        up = np.zeros((len(self.mesh), 1, 3))
        up[..., 2] = 1.0
        nodes = np.arange(len(self.mesh))[:, None]
        degree = degree_of(self.values.radiance_sh.shape[1])
        reflected = synthesise_at(self.values.radiance_sh, degree, nodes, np.ones((len(nodes), 1)), up)
        return np.asarray(reflected) + self.emission

    @property
    def emission(self) -> FloatArray:
        """(n, C) float, cd/m² that nodes emit, the same in all directions."""
        luminance = np.zeros((len(self.scene.materials), self.world.channels))
        emitters = self.world.emitters
        source_materials = self.world.materials[np.flatnonzero(emitters.of_triangle >= 0)]
        luminance[source_materials] = emitters.luminance
        both = np.array([m.emission_sides == "both" for m in self.scene.materials])
        shines = both[self.mesh.materials] | (self.mesh.sides > 0)
        return luminance[self.mesh.materials] * shines[:, None]

    def radiance(self, points: FloatArray, directions: FloatArray) -> FloatArray:
        """Radiance L(r, l) of light that passes a point in a direction, emission included.

        On a surface that is what the surface sends out; in space it is what the surface behind the point
        sends (the double local estimation of the method's paper).

        Parameters
        ----------
        points : (k, 3) float, m, scene axes
        directions : (k, 3) float; where the light travels to, away from the surface

        Returns
        -------
        (k, C) float, cd/m²
        """
        directions = _unit(np.asarray(directions, dtype=np.float64))
        points = np.asarray(points, dtype=np.float64)
        triangle = self._surface_at(points)
        on, off = np.flatnonzero(triangle >= 0), np.flatnonzero(triangle < 0)
        radiance = np.zeros((len(points), self.world.channels))
        chunk = CHUNK >> LOG2_HIGHLIGHTS
        for first in range(0, len(on), chunk):
            own = on[first : first + chunk]
            paths = self._standing(points[own], directions[own], triangle[own])
            seen = self._view_rays.reflecting(
                paths, own, log2_images=LOG2_HIGHLIGHTS, log2_mirrored=LOG2_HIGHLIGHTS
            )
            radiance[own] = self._view_rays.emitted(paths) + seen.with_reflected(self.stored(seen.surfaces))
        radiance[off] = self.seen(points[off], -directions[off])
        return radiance

    def _surface_at(self, points: FloatArray) -> IntArray:
        """Triangle (k,) on which a point lies, -1 where none is within a few ray offsets."""
        one_group = np.zeros(len(points), dtype=np.int64)
        triangle, weights = self._surface_grid.find(points, one_group)
        nearest = np.einsum("kc,kcx->kx", weights, self.world.caster.corners[triangle])
        near = np.linalg.norm(points - nearest, axis=1) <= SURFACE_OFFSETS * self.world.caster.offset
        return np.where(near, triangle, -1)

    def _standing(self, points: FloatArray, outgoing: FloatArray, triangles: IntArray) -> Paths:
        """Stand on triangles, on the side that directions (k, 3) leave."""
        normals = self.world.normals[triangles]
        along = np.einsum("kx,kx->k", outgoing, normals)
        return replace(
            Paths.at(points, np.where(along[:, None] < 0, -normals, normals), channels=self.world.channels),
            outgoing=outgoing,
            materials=self.world.materials[triangles],
            triangles=triangles,
        )

    def seen(
        self,
        origins: FloatArray,
        directions: FloatArray,
        *,
        log2_highlights: int = LOG2_HIGHLIGHTS,
        executor: Executor | None = None,
    ) -> FloatArray:
        """Radiance (k, C) in cd/m² seen from places (k, 3), m, along unit directions (k, 3).

        Parameters
        ----------
        log2_highlights : draws for the image of emitters in a glossy surface, as power of two
        """
        if executor is None:
            with ThreadPoolExecutor(max_workers=1) as own:
                return self.seen(origins, directions, log2_highlights=log2_highlights, executor=own)
        size = CHUNK >> max(0, log2_highlights - LOG2_HIGHLIGHTS_OF_PIXEL)
        chunks = [slice(first, first + size) for first in range(0, len(origins), size)]
        parts = executor.map(
            lambda chunk: self._seen_chunk(origins, directions, chunk, log2_highlights), chunks
        )
        return np.concatenate([np.zeros((0, self.world.channels)), *parts])

    def _seen_chunk(
        self, origins: FloatArray, directions: FloatArray, chunk: slice, log2_highlights: int
    ) -> FloatArray:
        rays = np.arange(len(origins))[chunk]
        seen = self._view_rays.look(
            origins[chunk],
            directions[chunk],
            rays,
            log2_images=log2_highlights,
            log2_mirrored=log2_highlights,
        )
        return seen.with_reflected(self.stored(seen.surfaces))

    def picture(
        self, camera: Camera, width: int, height: int, *, samples: int, executor: Executor
    ) -> FloatArray:
        """Luminance (height, width) in cd/m², the mean of ``samples`` rays a pixel; nan where no pixel is."""
        total = np.zeros(int(camera.mask(width, height).sum()))
        log2_highlights = max(0, LOG2_HIGHLIGHTS_OF_PIXEL - round(math.log2(samples)))
        for x, y in stratified_offsets(samples):
            origins, directions = camera.rays(width, height, offset=(float(x), float(y)))
            seen = self.seen(origins, directions, log2_highlights=log2_highlights, executor=executor)
            total += luminance_weighted(seen)
        return as_picture(total / samples, camera.mask(width, height))

    def stored(self, paths: Paths) -> FloatArray:
        """Radiance (k, C) interpolated from the nodes, without any image of an emitter."""
        front = np.einsum("kx,kx->k", paths.normals, self.world.normals[paths.triangles]) > 0
        sides = np.where(front, 1, -1)
        nodes, weights = self._locator.find(paths.points, self.labels[paths.triangles], sides)
        illuminance = np.einsum("kj,kjc->kc", weights, self.values.illuminance[nodes])
        radiance: FloatArray = self.world.reflectances.diffuse[paths.materials] * illuminance / math.pi
        degrees = self._stored_at(paths)
        for degree in np.unique(degrees[degrees > 0]):
            own = np.flatnonzero(degrees == degree)
            radiance[own] = self._synthesised(int(degree), paths.outgoing[own], nodes[own], weights[own])
        return radiance

    def images(
        self, points: FloatArray, normals: FloatArray, outgoing: FloatArray, triangles: IntArray
    ) -> FloatArray:
        """Images (k, C) of emitters in glossy surfaces, and of everything where lobes are too sharp to store.

        Parameters
        ----------
        points, normals, outgoing : (k, 3) float; the normal on the side that is seen
        triangles : (k,) int, on which the points lie
        """
        count = len(points)
        paths = replace(
            Paths.at(points, normals, channels=self.world.channels),
            outgoing=outgoing,
            materials=self.world.materials[triangles],
            triangles=triangles,
        )
        seen = self._view_rays.reflecting(
            paths, np.arange(count), log2_images=LOG2_HIGHLIGHTS, log2_mirrored=LOG2_HIGHLIGHTS
        )
        behind = chosen_paths(seen.surfaces, np.arange(count, len(seen.surfaces.number)))
        return Seen(seen.radiance, behind).with_reflected(self.stored(behind))

    def _synthesised(
        self, degree: int, outgoing: FloatArray, nodes: IntArray, weights: FloatArray
    ) -> FloatArray:
        local = to_local(outgoing[:, None, :], self.mesh.normals[nodes], self.mesh.frames_x[nodes])
        return synthesise_by_node(
            self.values.radiance_sh, degree, nodes, weights, np.ascontiguousarray(local)
        )

    @cached_property
    def _locator(self) -> Locator:
        return Locator(self.mesh)

    @cached_property
    def _surface_grid(self) -> TriangleGrid:
        corners = self.world.caster.corners
        return TriangleGrid(corners, np.zeros(len(corners), dtype=np.int64))

    @cached_property
    def _view_rays(self) -> ViewRays:
        return ViewRays.of(
            self.scene, self.world, mirrors=self._side_degrees[self.labels] == 0, deepest=DEEPEST_MIRROR
        )

    def _stored_at(self, paths: Paths) -> IntArray:
        """Degree (k,) of what the nodes around surface points keep, 0 where they keep no angular detail."""
        front = np.einsum("kx,kx->k", paths.normals, self.world.normals[paths.triangles]) > 0
        return self._side_degrees[self.labels[paths.triangles], np.where(front, 0, 1)]

    @cached_property
    def _side_degrees(self) -> IntArray:
        """Degree (n_patches, 2) of the nodes on front and back of each patch."""
        degrees = np.zeros((int(self.labels.max(initial=-1)) + 1, 2), dtype=np.int64)
        degrees[self.mesh.patches, np.where(self.mesh.sides > 0, 0, 1)] = self.values.sh_degree
        return degrees

    def save(self, path: str | Path, *, header: dict[str, object] | None = None) -> None:
        """Write the field as ``field.vtp``, which `load` reads back."""
        write_field(
            Path(path),
            self.mesh,
            self.values,
            exitance=self.exitance,
            luminance=self.luminance_along_normal,
            material_names=[m.name for m in self.scene.materials],
            header=header or {},
        )

    @classmethod
    def load(cls, path: str | Path, scene: Scene) -> RadianceField:
        """Read a field that `save` wrote, for the scene it was computed for."""
        mesh, values, _ = read_field(Path(path))
        channels = values.illuminance.shape[1]
        labels = patches(scene)
        _require_of_scene(Path(path), mesh, channels, scene, labels)
        return cls(scene, mesh, values, labels, build_world(scene, channels))


def _require_of_scene(path: Path, mesh: NodeMesh, channels: int, scene: Scene, labels: IntArray) -> None:
    """Refuse a field whose materials, patches or channels the scene does not have."""
    bounds = ((mesh.materials, len(scene.materials)), (mesh.patches, int(labels.max(initial=-1)) + 1))
    within = all(numbers.min(initial=0) >= 0 and numbers.max(initial=-1) < most for numbers, most in bounds)
    if not within or not set(np.unique(mesh.sides)) <= {-1, 1} or channels not in (1, 3, BANDS):
        raise OutputError(f"{path}: not of the scene {scene.name}: write it again with lelight calc")


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
