"""View rays: which surfaces they show, and all that can be said of these before reflected light is known.

Emitters and luminous openings are seen exactly where a ray meets them, and their images in Phong lobes are added at
once. Lobes taken for mirrors send the ray on: what the surfaces behind reflect, dimmed by the mirrors on the way,
belongs to the ray as well (the double local estimation of the method's paper, equations (12) and (13)).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lelight.estimate.pathstate import Paths, chosen_paths, meet
from lelight.highlights import highlights, only_specular, sees_images
from lelight.scene import BoolArray, FloatArray, IntArray, Scene
from lelight.tracing.openings import seen_openings
from lelight.tracing.world import World


@dataclass(frozen=True)
class Seen:
    """What k rays show.

    Attributes
    ----------
    radiance : (k, C) float, cd/m²; emission, and images of emitters
    surfaces : where light is reflected toward the rays; ``number`` is the ray, ``throughput`` what the mirrors between
        leave of it
    """

    radiance: FloatArray
    surfaces: Paths

    def with_reflected(self, reflected: FloatArray) -> FloatArray:
        """Radiance (k, C) when the surfaces reflect so much (s, C), cd/m²."""
        total = self.radiance.copy()
        np.add.at(total, self.surfaces.number, reflected * self.surfaces.throughput)
        return total


@dataclass(frozen=True)
class ViewRays:
    """Follows view rays through a scene.

    Attributes
    ----------
    scene, world : the scene as it was read, and as it is traced
    glossy_world : the same with Phong lobes only
    mirrors : (n_t, 2) bool, fronts and backs of triangles whose Phong lobes send rays on
    deepest : int, mirrors behind mirrors that are followed
    """

    scene: Scene
    world: World
    glossy_world: World
    mirrors: BoolArray
    deepest: int

    @classmethod
    def of(cls, scene: Scene, world: World, *, mirrors: BoolArray, deepest: int) -> ViewRays:
        """Prepare to look into a scene."""
        return cls(scene, world, only_specular(world), mirrors, deepest)

    def look(
        self,
        origins: FloatArray,
        directions: FloatArray,
        identity: IntArray,
        *,
        log2_images: int,
        log2_mirrored: int,
    ) -> Seen:
        """Follow rays from places (k, 3), m, along unit directions (k, 3).

        Parameters
        ----------
        identity : (k,) int, on which the random numbers of images depend
        log2_images, log2_mirrored : draws for the images of emitters in a lobe, and for all that a mirror shows, as
            powers of two
        """
        radiance = np.zeros((len(origins), self.world.channels))
        rays, luminance = seen_openings(self.world, self.scene, origins, directions)
        radiance[rays] = luminance
        others = np.setdiff1d(np.arange(len(origins)), rays)
        ones = np.ones((len(others), self.world.channels))
        met, _ = meet(self.world, others, origins[others], directions[others], ones)
        seen = self.reflecting(
            met, identity[met.number], log2_images=log2_images, log2_mirrored=log2_mirrored
        )
        radiance[met.number] = self.emitted(met) + seen.radiance
        return Seen(radiance, replace(seen.surfaces, number=met.number[seen.surfaces.number]))

    def reflecting(self, paths: Paths, identity: IntArray, *, log2_images: int, log2_mirrored: int) -> Seen:
        """Look at surfaces where rays have met them, at what they emit excepted; rays are numbered by ``paths``."""
        count = len(paths.number)
        radiance = np.zeros((count, self.world.channels))
        here = replace(paths, number=np.arange(count), throughput=np.ones_like(paths.throughput))
        surfaces = [here]
        for depth in range(self.deepest + 1):
            glossy = self.world.reflectances.specular_share[here.materials] > 0
            mirrored = glossy & self.on_mirrors(here)
            images = self._showing_images(here, np.flatnonzero(glossy & ~mirrored))
            self._add_images(radiance, here, images, identity, depth, log2_images)
            onward = self._add_images(
                radiance, here, np.flatnonzero(mirrored), identity, depth, log2_mirrored
            )
            if not len(onward.number) or depth == self.deepest:
                break
            here, log2_images, log2_mirrored = onward, 0, 0
            surfaces.append(here)
        return Seen(radiance, joined_paths(surfaces))

    def on_mirrors(self, paths: Paths) -> BoolArray:
        """Say which surfaces (k,) send rays on, where they are glossy."""
        return np.asarray(self.mirrors[paths.triangles, np.where(self._on_fronts(paths), 0, 1)])

    def _on_fronts(self, paths: Paths) -> BoolArray:
        return np.asarray(np.einsum("kx,kx->k", paths.normals, self.world.normals[paths.triangles]) > 0)

    def _showing_images(self, here: Paths, glossy: IntArray) -> IntArray:
        """Keep the surfaces in whose lobes an emitter may be seen."""
        own = chosen_paths(here, glossy)
        return np.asarray(
            glossy[sees_images(self.world, own.points, own.normals, own.outgoing, own.materials)]
        )

    def _add_images(
        self,
        radiance: FloatArray,
        here: Paths,
        chosen: IntArray,
        identity: IntArray,
        depth: int,
        log2_draws: int,
    ) -> Paths:
        """Add images of emitters in the lobes of some surfaces; returns the surfaces that the lobes' rays meet."""
        own = chosen_paths(here, chosen)
        images, met = highlights(
            self.glossy_world,
            points=own.points,
            normals=own.normals,
            outgoing=own.outgoing,
            materials=own.materials,
            identity=identity[own.number] * (self.deepest + 1) + depth,
            log2_samples=log2_draws,
        )
        np.add.at(radiance, own.number, images * own.throughput)
        return replace(
            met, number=own.number[met.number], throughput=met.throughput * own.throughput[met.number]
        )

    def emitted(self, paths: Paths) -> FloatArray:
        """Luminance (k, C) that surfaces emit toward where the paths came from."""
        emitters = self.world.emitters
        source = emitters.of_triangle[paths.triangles]
        front = self._on_fronts(paths)
        luminance = np.zeros((len(source), self.world.channels))
        shining = source >= 0
        shining[shining] &= front[shining] | emitters.both_sides[source[shining]]
        luminance[shining] = emitters.luminance[source[shining]]
        return luminance


def joined_paths(parts: list[Paths]) -> Paths:
    """Put paths one after the other."""
    columns = [vars(part) for part in parts]
    return Paths(**{name: np.concatenate([c[name] for c in columns]) for name in columns[0]})
