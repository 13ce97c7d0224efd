"""Everything that emits: luminous triangles, isotropic points and photometric luminaires, as arrays.

Sources are numbered triangles first, then points; a photometric luminaire is a point with a table and an
opening. How light is drawn from them is told in ``tracing.drawing`` and ``tracing.lamps``.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from lelight.channels import luminance_weighted, luminance_weights
from lelight.luminaires import Luminaire, PhotometricLuminaire
from lelight.mesh.doubles import backs
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas, triangle_normals
from lelight.spectral.bands import emission_in_channels
from lelight.tracing.distributions import Distributions, collect_distributions

#: Numbers in the sketch of a triangle.
SKETCH = 10


class Emitters(NamedTuple):
    """Sources as arrays, T triangles and P points, C channels.

    Attributes
    ----------
    corners : (T, 3, 3) float, m
    normals : (T, 3) float, unit, front side
    areas : (T,) float, m²
    luminance : (T, C) float, cd/m²
    both_sides : (T,) bool
    positions : (P, 3) float, m
    intensity : (P, C) float, cd of an isotropic point; factor on its table's intensities of a photometric one
    power : (T + P,) float, lm of each source, luminance-weighted
    power_cdf : (T + P,) float, cumulative share of power
    weights : (C,) float, luminance weights of the channels
    of_triangle : (n_t,) int, number of the source that a scene triangle is, or -1
    sketch : (10, T) float, for the choice of sources: middle (3), normal (3), radius in m around it, area over
        pi in m², pi times the largest intensity, 1 where both sides emit
    tables : (P,) int, distribution of a point, or -1 where it is isotropic
    distributions : the tables
    axes : (P, 3, 3) float, rows C0, C90 and up of a photometric point
    edges : (P, 2, 3) float, m, of the figure over which a near one is spread
    round : (P,) bool, whether that figure is an ellipse
    sizes : (P,) float, m, largest extent of the opening
    housings : (P,) int, which of the scene's surfaces do not block it: 0 all do, else see `housing_patterns`
    """

    corners: FloatArray
    normals: FloatArray
    areas: FloatArray
    luminance: FloatArray
    both_sides: BoolArray
    positions: FloatArray
    intensity: FloatArray
    power: FloatArray
    power_cdf: FloatArray
    weights: FloatArray
    of_triangle: IntArray
    sketch: FloatArray
    tables: IntArray
    distributions: Distributions
    axes: FloatArray
    edges: FloatArray
    round: BoolArray
    sizes: FloatArray
    housings: IntArray

    @property
    def flux(self) -> FloatArray:
        """(T + P, C) float, lm: luminous flux of each source and channel."""
        faces = np.where(self.both_sides, 2.0, 1.0) * math.pi * self.areas
        return np.concatenate([faces[:, None] * self.luminance, self.solid_flux[:, None] * self.intensity])

    @property
    def solid_flux(self) -> FloatArray:
        """(P,) float, lm of a point for a factor of 1: 4 pi where it is isotropic, else its table's flux."""
        of_table = np.append(self.distributions.flux, 4.0 * math.pi)
        return np.asarray(of_table[self.tables])


def collect_emitters(scene: Scene, channels: FloatArray) -> Emitters:
    """Gather the sources of a scene.

    Parameters
    ----------
    channels : (3, C) float; turns linear RGB into the channels that are carried
    """
    material_luminance = emission_in_channels(
        [m.luminance for m in scene.materials], [m.emission_spectrum for m in scene.materials], channels
    )
    emitting = np.flatnonzero(material_luminance[scene.triangle_materials].max(axis=1) > 0)
    both = np.array([m.emission_sides == "both" for m in scene.materials])
    corners = scene.vertices[scene.triangles[emitting]]
    materials = scene.triangle_materials[emitting]
    of_triangle = np.full(len(scene.triangles), -1, dtype=np.int64)
    of_triangle[emitting] = np.arange(len(emitting))
    count = channels.shape[1]
    unweighted = Emitters(
        corners=corners,
        normals=triangle_normals(corners),
        areas=triangle_areas(corners),
        luminance=material_luminance[materials],
        # The back of a face that lies back to back with another is the other's front.
        both_sides=both[materials] & (backs(scene.vertices, scene.triangles)[emitting] < 0),
        positions=scene.lamp_positions,
        intensity=emission_in_channels(
            [_strength(lamp) for lamp in scene.luminaires],
            [lamp.spectrum for lamp in scene.luminaires],
            channels,
        ),
        power=np.empty(0),
        power_cdf=np.empty(0),
        weights=luminance_weights(count),
        of_triangle=of_triangle,
        sketch=np.empty((SKETCH, 0)),
        **_lamp_arrays(scene),
    )
    power = luminance_weighted(unweighted.flux)
    whole = unweighted._replace(power=power, power_cdf=np.cumsum(power) / power.sum())
    return whole._replace(sketch=_sketch(whole))


def _strength(lamp: Luminaire) -> FloatArray:
    """Intensity (3,) of a point, or the factor on its table."""
    return np.full(3, lamp.factor) if isinstance(lamp, PhotometricLuminaire) else lamp.intensity


def housing_patterns(scene: Scene) -> tuple[str, ...]:
    """Patterns of materials that do not block the light of some luminaire, each once; luminaires count from 1."""
    named = [lamp.housing for lamp in scene.luminaires if isinstance(lamp, PhotometricLuminaire)]
    return tuple(dict.fromkeys(pattern for pattern in named if pattern))


def _lamp_arrays(scene: Scene) -> dict[str, Any]:
    """Tables, axes and openings of the points."""
    lamps = scene.luminaires
    count = len(lamps)
    photometries = {
        id(lamp.photometry): lamp.photometry for lamp in lamps if isinstance(lamp, PhotometricLuminaire)
    }
    number = {key: k for k, key in enumerate(photometries)}
    patterns = ("", *housing_patterns(scene))
    arrays: dict[str, Any] = {
        "tables": np.full(count, -1, dtype=np.int64),
        "distributions": collect_distributions(list(photometries.values())),
        "axes": np.tile(np.eye(3), (count, 1, 1)),
        "edges": np.zeros((count, 2, 3)),
        "round": np.zeros(count, dtype=np.bool_),
        "sizes": np.zeros(count),
        "housings": np.zeros(count, dtype=np.int64),
    }
    for k, lamp in enumerate(lamps):
        if isinstance(lamp, PhotometricLuminaire):
            first, second, round_ = lamp.figure()
            arrays["tables"][k] = number[id(lamp.photometry)]
            arrays["axes"][k] = lamp.axes
            arrays["edges"][k] = first, second
            arrays["round"][k] = round_
            arrays["sizes"][k] = lamp.photometry.opening.size
            arrays["housings"][k] = patterns.index(lamp.housing)
    return arrays


def _sketch(emitters: Emitters) -> FloatArray:
    """Boil each triangle down to ten numbers; see `Emitters`."""
    triangles = len(emitters.areas)
    sketch = np.zeros((SKETCH, triangles))
    middle = emitters.corners.mean(axis=1)
    sketch[:3] = middle.T
    sketch[3:6] = emitters.normals.T
    sketch[6] = np.linalg.norm(emitters.corners - middle[:, None], axis=2).max(axis=1, initial=0.0)
    sketch[7] = emitters.areas / math.pi
    sketch[8] = emitters.power[:triangles] / np.where(emitters.both_sides, 2.0, 1.0)
    sketch[9] = emitters.both_sides
    return sketch
