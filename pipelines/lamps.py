"""What figures must know of the lamps of a scene: spectrum, coverage of the ceiling, light at an eye."""

from __future__ import annotations

import math

import numpy as np

from lelight.channels import is_spectral, luminance_weighted
from lelight.field import RadianceField
from lelight.metrics.figure import Figure
from lelight.metrics.position import sight_frame
from lelight.pipelines.eyes import sources_seen
from lelight.scene import FloatArray, Observer, PointLuminaire, Scene, Spectrum, triangle_areas
from lelight.spectral.bands import lamp_mixture

#: Cosine to the vertical above which a surface is level.
_LEVEL = 0.9


def lamps_of(field: RadianceField) -> Spectrum | None:
    """Mixture of the spectra of a scene's lamps by their flux; None where no bands are carried."""
    if not is_spectral(field.world.channels):
        return None
    emitters = field.world.emitters
    fluxes = luminance_weighted(emitters.flux)
    triangles = len(emitters.areas)
    of_triangle = np.flatnonzero(emitters.of_triangle >= 0)
    materials = np.zeros(triangles, dtype=np.int64)
    materials[emitters.of_triangle[of_triangle]] = field.world.materials[of_triangle]
    by_material = np.bincount(materials, weights=fluxes[:triangles], minlength=len(field.scene.materials))
    emitting = [by_material[k] for k, material in enumerate(field.scene.materials) if material.emits]
    return lamp_mixture(field.scene, np.array([*emitting, *fluxes[triangles:]]))


def ceiling_coverage(field: RadianceField) -> float:
    """Luminous area that faces down over the floor's area, both as seen from above; 0 without a floor."""
    scene, normals = field.scene, field.world.normals
    areas = triangle_areas(scene.corners)
    emits = np.array([material.emits for material in scene.materials])[scene.triangle_materials]
    heights = scene.corners[:, :, 2].max(axis=1)
    low, tall = float(heights.min()), float(np.ptp(scene.vertices[:, 2]))
    floor = ~emits & (np.abs(normals[:, 2]) > _LEVEL) & (heights <= low + 0.1 * tall)
    ground = float(areas[floor].sum())
    lit = float((areas * np.maximum(-normals[:, 2], 0.0))[emits].sum())
    return lit / ground if ground > 0 else 0.0


def maintenance_figure(scene: Scene) -> Figure:
    """Maintenance factor that is in the figures: that of the luminaires; luminous surfaces have none."""
    factors = sorted({lamp.maintenance for lamp in scene.luminaires})
    surfaces = any(material.emits for material in scene.materials)
    method = "applied to the luminaires' intensity; luminances of surfaces are taken as written"
    clause = "EN 12464-1, maintenance factor; CIE 97"
    if not factors:
        return Figure(1.0, "1", None, method, clause=clause, note="no luminaire with a maintenance factor")
    note = "" if len(factors) == 1 else f"least of {', '.join(f'{factor:g}' for factor in factors)}"
    if surfaces:
        note = f"{note}; luminous surfaces: 1".removeprefix("; ")
    return Figure(factors[0], "1", None, method, clause=clause, note=note)


def source_illuminances(field: RadianceField, observer: Observer) -> tuple[FloatArray, FloatArray]:
    """Illuminance (n,) lx that each lamp gives at an eye across its line of sight, and directions (n, 3)."""
    forward = sight_frame(observer)[0]
    found = [
        (source.luminance * source.solid_angle * float(source.direction @ forward), source.direction)
        for source in sources_seen(field, observer)
        if source.solid_angle > 0
    ]
    for lamp in (each for each in field.scene.luminaires if isinstance(each, PointLuminaire)):
        found += _of_point(field, lamp, observer, forward)
    kept = [(light, direction) for light, direction in found if light > 0]
    return (
        np.array([light for light, _ in kept]),
        np.array([direction for _, direction in kept]).reshape(-1, 3),
    )


def _of_point(
    field: RadianceField, lamp: PointLuminaire, observer: Observer, forward: FloatArray
) -> list[tuple[float, FloatArray]]:
    """Light of a point luminaire at an eye, nothing where it is hidden."""
    ray = lamp.position - observer.position
    distance = float(np.linalg.norm(ray))
    seen = bool(field.world.caster.visible(observer.position[None], lamp.position[None])[0])
    if not seen or distance == 0 or not math.isfinite(distance):
        return []
    intensity = float(luminance_weighted(lamp.intensity))
    return [(intensity * float(ray @ forward) / distance**3, ray / distance)]
