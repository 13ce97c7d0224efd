"""What observers see: a luminance picture each, and the glare of the known emitters."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lelight.camera import Fisheye
from lelight.channels import luminance_weighted
from lelight.field import RadianceField
from lelight.luminaires import Luminaire
from lelight.metrics.cie117 import EmitterPatch, GlareSource, glare_sources, point_source
from lelight.metrics.distribution import luminance_distribution
from lelight.metrics.luminaireglare import luminaire_source
from lelight.metrics.picture import PictureGlare, picture_glare
from lelight.metrics.zones import statistics, threshold_luminance, zone_statistics
from lelight.places import turned
from lelight.scene import BoolArray, FloatArray, Observer, PointLuminaire, Threshold
from lelight.soundness import require_sound_picture
from lelight.tracing.world import World

#: Rays to an opening end this many surface offsets before it.
CLEARANCE = 4.0


#: Threshold of glare sources in pictures where the scene names none, that of evalglare.
USUAL_THRESHOLD = Threshold(2000.0)


@dataclass(frozen=True)
class Sight:
    """What one observer sees.

    Attributes
    ----------
    luminance : (h, w) float, cd/m², equi-angular fisheye of 180°; nan outside its disc
    view : Radiance's view options
    sources : the luminous openings as the eye sees them
    glare : ratings taken from the picture
    zones : luminance statistics of task, surround and background, and of the whole view
    distribution : of luminance over the view, research
    turned : sources seen by each of 24 lines of sight, turned by 15 degrees, itself first
    """

    observer: Observer
    luminance: FloatArray
    view: str
    sources: tuple[GlareSource, ...]
    glare: PictureGlare
    zones: dict[str, dict[str, float]]
    distribution: dict[str, Any]
    turned: tuple[tuple[GlareSource, ...], ...]


def look(field: RadianceField, observer: Observer, *, size: int, samples: int, executor: Executor) -> Sight:
    """Take an observer's picture of ``size`` pixels square, ``samples`` rays a pixel, and rate it."""
    camera = Fisheye(observer.position, observer.direction)
    luminance = field.picture(camera, size, size, samples=samples, executor=executor)
    require_sound_picture(luminance[camera.mask(size, size)], observer.name)
    directions = np.zeros((size, size, 3))
    directions[camera.mask(size, size)] = camera.rays(size, size)[1]
    shown, solid_angles = np.nan_to_num(luminance), camera.solid_angles(size, size)
    threshold = threshold_luminance(
        observer.threshold or USUAL_THRESHOLD, shown, solid_angles, directions, observer
    )
    glare = picture_glare(shown, solid_angles, directions, observer, threshold=threshold)
    inside = solid_angles > 0
    zones = zone_statistics(shown, solid_angles, directions, observer)
    zones["view"] = statistics(shown[inside], solid_angles[inside])
    turned_eyes = [replace(observer, direction=direction) for direction in turned(observer.direction)]
    seen = tuple(sources_seen(field, eye) for eye in turned_eyes)
    return Sight(
        observer,
        luminance,
        camera.view(size, size),
        seen[0],
        glare,
        zones,
        luminance_distribution(shown, solid_angles),
        seen,
    )


def sources_seen(field: RadianceField, observer: Observer) -> tuple[GlareSource, ...]:
    """See openings first, luminaires after them."""

    def visible(origins: FloatArray, targets: FloatArray) -> BoolArray:
        back = origins - targets
        distance = np.linalg.norm(back, axis=1, keepdims=True)
        ends = targets + CLEARANCE * field.world.caster.offset * back / distance
        return field.world.caster.visible(origins, ends)

    openings = glare_sources(list(emitter_patches(field)), observer, visible)
    lamps = enumerate(field.scene.luminaires)
    return openings + tuple(_lamp_source(field, lamp, number, observer) for number, lamp in lamps)


def _lamp_source(field: RadianceField, lamp: Luminaire, number: int, observer: Observer) -> GlareSource:
    """See one luminaire; its own housing hides nothing of it."""
    if isinstance(lamp, PointLuminaire):
        return point_source(lamp, observer)
    housing = int(field.world.emitters.housings[number])

    def visible(origins: FloatArray, targets: FloatArray) -> BoolArray:
        back = origins - targets
        distance = np.linalg.norm(back, axis=1, keepdims=True)
        # The opening may lie flush in a ceiling: end on the eye's side of it.
        side = np.sign(back @ lamp.axes[2])[:, None] * lamp.axes[2]
        ends = targets + CLEARANCE * field.world.caster.offset * (back / distance + side)
        return field.world.visible(origins, ends, housing=np.full(len(ends), housing))

    return luminaire_source(lamp, observer, visible)


def emitter_patches(field: RadianceField) -> Iterator[EmitterPatch]:
    """List the connected luminous patches of the scene, named by material and number."""
    emitters = field.world.emitters
    triangles = np.flatnonzero(emitters.of_triangle >= 0)
    numbers: dict[str, int] = {}
    for patch in np.unique(field.labels[triangles]):
        own = triangles[field.labels[triangles] == patch]
        material = field.scene.materials[field.world.materials[own[0]]]
        numbers[material.name] = numbers.get(material.name, 0) + 1
        yield EmitterPatch(
            name=f"{material.name} {numbers[material.name]}",
            corners=field.world.caster.corners[own],
            luminance=_luminance(field.world, int(own[0])),
            sides=material.emission_sides,
        )


def _luminance(world: World, triangle: int) -> float:
    return float(luminance_weighted(world.emitters.luminance[world.emitters.of_triangle[triangle]]))


def glare_share(source: GlareSource, sources: tuple[GlareSource, ...]) -> float:
    """Part of the sum of L² omega / p² that one source contributes."""
    total = math.fsum(s.glare for s in sources)
    return source.glare / total if total > 0 else 0.0
