"""What is traced: geometry, reflection and emission of a scene, ready for rays."""

from __future__ import annotations

from dataclasses import dataclass

from lelight.channels import channel_matrix
from lelight.scene import FloatArray, IntArray, Scene, triangle_areas
from lelight.tracing.emitters import Emitters, collect_emitters
from lelight.tracing.rays import RayCaster
from lelight.tracing.reflection import Reflectances, collect_reflectances


@dataclass(frozen=True)
class World:
    """A scene as the estimators see it.

    Attributes
    ----------
    materials : (n_t,) int, material of each traced triangle
    normals : (n_t, 3) float, unit, front side
    area : float, m² of all triangles, one side
    """

    caster: RayCaster
    reflectances: Reflectances
    emitters: Emitters
    materials: IntArray
    normals: FloatArray
    area: float

    @property
    def channels(self) -> int:
        """Number of channels C."""
        return int(self.reflectances.diffuse.shape[1])


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
    )
