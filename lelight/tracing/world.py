"""What is traced: geometry, reflection and emission of a scene, ready for rays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

import numpy as np

from lelight.channels import channel_matrix
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas
from lelight.tracing.emitters import Emitters, collect_emitters, housing_patterns
from lelight.tracing.rays import Hits, RayCaster
from lelight.tracing.reflection import Reflectances, collect_reflectances


@dataclass(frozen=True)
class WithoutHousing:
    """The scene without the materials of a housing; ``triangles`` (k,) numbers in the whole scene."""

    caster: RayCaster | None
    triangles: IntArray


@dataclass(frozen=True)
class World:
    """A scene as the estimators see it.

    Attributes
    ----------
    materials : (n_t,) int, material of each traced triangle
    normals : (n_t, 3) float, unit, front side
    area : float, m² of all triangles, one side
    without : the scene without each housing, in the order of `housing_patterns`
    """

    caster: RayCaster
    reflectances: Reflectances
    emitters: Emitters
    materials: IntArray
    normals: FloatArray
    area: float
    without: tuple[WithoutHousing, ...] = ()

    @property
    def channels(self) -> int:
        """Number of channels C."""
        return int(self.reflectances.diffuse.shape[1])

    def visible(self, origins: FloatArray, ends: FloatArray, *, housing: IntArray | None = None) -> BoolArray:
        """Say for pairs of points (k, 3), m, off their surfaces, whether nothing lies between.

        Parameters
        ----------
        housing : (k,) int, 0 where everything blocks, else the housing that does not
        """
        if housing is None or not self.without or not housing.any():
            return self.caster.visible(origins, ends)
        clear = np.ones(len(origins), dtype=np.bool_)
        for number in np.unique(housing):
            own = np.flatnonzero(housing == number)
            caster = self.without[number - 1].caster if number else self.caster
            if caster is not None:
                clear[own] = caster.visible(origins[own], ends[own])
        return clear

    def closest(
        self, origins: FloatArray, directions: FloatArray, *, housing: IntArray | None = None
    ) -> Hits:
        """Follow rays (k, 3) to the first surface that is not of their housing (k,); see `visible`."""
        if housing is None or not self.without or not housing.any():
            return self.caster.closest(origins, directions)
        parts = []
        order = []
        for number in np.unique(housing):
            own = np.flatnonzero(housing == number)
            order.append(own)
            parts.append(self._closest_without(int(number), origins[own], directions[own]))
        back = np.argsort(np.concatenate(order), kind="stable")
        return Hits(
            **{name: np.concatenate([vars(part)[name] for part in parts])[back] for name in vars(parts[0])}
        )

    def _closest_without(self, number: int, origins: FloatArray, directions: FloatArray) -> Hits:
        if number == 0:
            return self.caster.closest(origins, directions)
        left = self.without[number - 1]
        if left.caster is None:
            count = len(origins)
            nothing = np.full(count, -1, dtype=np.int64)
            return Hits(nothing, origins, np.zeros((count, 3)), np.zeros(count, dtype=np.bool_))
        hits = left.caster.closest(origins, directions)
        return replace(hits, triangle=np.where(hits.triangle < 0, -1, left.triangles[hits.triangle]))


def without_housing(scene: Scene, pattern: str) -> WithoutHousing:
    """Leave out the materials that a pattern matches."""
    named = np.array([fnmatchcase(material.name, pattern) for material in scene.materials])
    kept = np.flatnonzero(~named[scene.triangle_materials])
    caster = RayCaster(scene.vertices, scene.triangles[kept]) if len(kept) else None
    return WithoutHousing(caster, kept)


def build_world(scene: Scene, channels: int) -> World:
    """Prepare a scene for tracing in ``channels`` channels."""
    matrix = channel_matrix(channels)
    caster = RayCaster.of(scene)
    return World(
        caster=caster,
        reflectances=collect_reflectances(scene, matrix),
        emitters=collect_emitters(scene, matrix),
        materials=scene.triangle_materials,
        normals=caster.normals,
        area=float(triangle_areas(scene.corners).sum()),
        without=tuple(without_housing(scene, pattern) for pattern in housing_patterns(scene)),
    )
