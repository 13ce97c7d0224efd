"""The material of the last bounce, changed after the run.

What nodes reflect is a product of the light that arrives and of their own lobes (`lelight.harmonics.zonal`), so one
accumulation serves every reflectance and exponent. Only what a surface sends to the eye changes: light that
surfaces have received from each other, and with it every illuminance, stays that of the materials that were
computed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lelight.errors import OutputError
from lelight.estimate.angularharmonics import harmonic_truncation
from lelight.estimate.lobes import stored_lobe
from lelight.field import RadianceField
from lelight.harmonics.dark import without_dark
from lelight.harmonics.indices import terms
from lelight.harmonics.zonal import largest_exponent, reflected
from lelight.incident import IncidentLight
from lelight.plan import make_plan
from lelight.reading.inputfile import quoted
from lelight.scene import IntArray, Scene
from lelight.storeddegree import BLUNT_EXPONENT, EPS, stored_degree
from lelight.tracing.world import World, build_world


def changed_materials(before: Scene, after: Scene) -> IntArray:
    """Materials (k,) that reflect differently in two scenes."""
    pairs = zip(before.materials, after.materials, strict=True)
    return np.flatnonzero(
        [
            not np.array_equal(a.diffuse, b.diffuse)
            or not np.array_equal(a.specular, b.specular)
            or a.exponent != b.exponent
            or a.reflectance_spectrum is not b.reflectance_spectrum
            for a, b in pairs
        ]
    )


def relit(field: RadianceField, scene: Scene) -> RadianceField:
    """Let surfaces reflect by the materials of another scene, which differs from the field's in them only.

    Raises
    ------
    OutputError
        where the field does not keep what the new materials need
    """
    changed = changed_materials(field.scene, scene)
    if make_plan(scene).channels > field.world.channels:
        raise OutputError("a coloured material in a grey run; run `lelight calc` with a colour in the scene")
    world = build_world(scene, field.world.channels)
    lobes = np.array([stored_degree(material) for material in scene.materials], dtype=np.int64)
    for material in changed:
        _require_kept(field, scene, int(material), int(lobes[material]))
    values = field.values
    # Nodes on sides that no observer sees keep no directions: there view rays are reflected.
    keeping = np.zeros(len(field.mesh), dtype=np.bool_)
    if field.incident is not None:
        keeping[field.incident.nodes] = True
    of_changed = np.isin(field.mesh.materials, changed)
    sh_degree = np.where(of_changed, lobes[field.mesh.materials] * keeping, values.sh_degree)
    width = max(terms(int(sh_degree.max(initial=0))), values.radiance_sh.shape[1])
    radiance = np.zeros((len(field.mesh), width, field.world.channels), dtype=np.float32)
    radiance[:, : values.radiance_sh.shape[1]] = values.radiance_sh
    for material in changed:
        own = np.flatnonzero(field.mesh.materials == material)
        radiance[own] = 0.0
        reflection = _reflection(field, world, lobes, own, int(material))
        radiance[own, : reflection.shape[1]] = reflection
    return replace(
        field,
        scene=scene,
        world=world,
        values=replace(
            values,
            radiance_sh=radiance,
            sh_degree=sh_degree,
            truncation=_truncation(field, world, lobes, changed),
        ),
    )


def _truncation(
    field: RadianceField, world: World, lobes: IntArray, changed: IntArray
) -> NDArray[np.float32]:
    """State anew what the degrees of the changed materials leave out (n,)."""
    errors = field.values.truncation.copy()
    own = np.isin(field.mesh.materials, changed)
    errors[own] = 0.0
    incident = field.incident
    if incident is not None and len(incident.nodes):
        kept = np.flatnonzero(own[incident.nodes])
        nodes = incident.nodes[kept]
        coefficients = incident.coefficients[kept].astype(np.float64)
        errors[nodes] = harmonic_truncation(
            coefficients, field.mesh.materials[nodes], world.reflectances, lobes
        )
    return errors


def _reflection(
    field: RadianceField, world: World, lobes: IntArray, nodes: IntArray, material: int
) -> NDArray[np.float64]:
    """Coefficients (k, T, C) of what nodes of a material reflect."""
    reflectances = world.reflectances
    specular, degree = stored_lobe(reflectances, lobes, material)
    light = np.zeros((len(nodes), terms(degree), world.channels))
    if degree and field.incident is not None:
        _, at, kept = np.intersect1d(nodes, field.incident.nodes, return_indices=True)
        light[at] = field.incident.coefficients[kept, : terms(degree)]
    radiance = reflected(
        light,
        field.values.illuminance[nodes],
        diffuse=reflectances.diffuse[material],
        specular=specular,
        exponent=float(reflectances.exponent[material]),
    )
    return without_dark(radiance)


def _require_kept(field: RadianceField, scene: Scene, material: int, degree: int) -> None:
    """Refuse lobes for which nodes keep too little."""
    own = np.flatnonzero(field.mesh.materials == material)
    kept = _kept_degree(field.incident, own)
    if degree <= kept or not len(own):
        return
    name, exponent = quoted(scene.materials[material].name), scene.materials[material].exponent
    if kept == 0:
        kept_so_far = "no angular distribution"
    else:
        enough = max(BLUNT_EXPONENT, largest_exponent(kept, eps=EPS))
        kept_so_far = f"degree {kept}, enough for exponents up to {enough:.3g}"
    raise OutputError(
        f"{name} was computed with {kept_so_far}; exponent {exponent:g} needs degree {degree}: "
        f"run `lelight calc` with --relightable {exponent:g}"
    )


def _kept_degree(incident: IncidentLight | None, nodes: IntArray) -> int:
    """Degree to which those of the nodes (k,) that keep arriving light keep it, 0 where none does."""
    if incident is None:
        return 0
    kept = incident.degrees[np.isin(incident.nodes, nodes)]
    return int(kept.min()) if len(kept) else 0
