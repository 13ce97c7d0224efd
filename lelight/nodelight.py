"""The luminance body of a node: what it sends in every direction of its hemisphere, and its parts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lelight.channels import luminance_weighted
from lelight.errors import OutputError
from lelight.field import RadianceField
from lelight.harmonics.basis import evaluate
from lelight.harmonics.frames import to_local, to_scene
from lelight.harmonics.indices import degree_of
from lelight.scene import FloatArray

#: Steps of the zenith angle from the normal to the horizon, and of the azimuth, in degrees.
ZENITH_STEP, AZIMUTH_STEP = 3, 5


@dataclass(frozen=True)
class Parts:
    """Luminance in k directions, luminance-weighted, in cd/m².

    Attributes
    ----------
    stored : (k,) float, reflected light as the node keeps it
    images : (k,) float, emitters mirrored in its gloss, sampled when asked for
    emitted : float
    """

    stored: FloatArray
    images: FloatArray
    emitted: float

    @property
    def total(self) -> FloatArray:
        """(k,) float, cd/m²."""
        return np.asarray(self.stored + self.images + self.emitted)


@dataclass(frozen=True)
class LuminanceBody:
    """What one node looks like from every side.

    Attributes
    ----------
    node : int, its number in the mesh
    zenith : (z,) float, rad from the normal, up to the horizon
    azimuth : (a,) float, rad about the normal, from the x axis of the node's frame toward its y axis
    directions : (z, a, 3) float, unit, scene axes, away from the surface
    luminance, images : (z, a) float, cd/m²; all of it, and the emitters' images in it
    emitted : float, cd/m²
    """

    node: int
    zenith: FloatArray
    azimuth: FloatArray
    directions: FloatArray
    luminance: FloatArray
    images: FloatArray
    emitted: float

    @property
    def brightest(self) -> tuple[int, int]:
        """Place in the grid of the largest luminance."""
        zenith, azimuth = np.unravel_index(int(np.argmax(self.luminance)), self.luminance.shape)
        return int(zenith), int(azimuth)

    @property
    def exitance(self) -> float:
        """Flux per area that leaves over the horizon in lm/m², by the trapezoidal rule over the grid."""
        ring = self.luminance.mean(axis=1) * 2.0 * math.pi
        return float(np.trapezoid(ring * np.sin(self.zenith) * np.cos(self.zenith), self.zenith))


def nearest_node(field: RadianceField, place: FloatArray, *, facing: FloatArray | None = None) -> int:
    """Find the visible node that is nearest to a place (3,) in m.

    Parameters
    ----------
    facing : (3,) float, a direction into which its surface looks; tells the sides of a thin wall apart

    Raises
    ------
    OutputError
        where no node looks that way
    """
    mesh = field.mesh
    allowed = ~mesh.hidden
    if facing is not None:
        allowed &= mesh.normals @ facing > 0.0
    chosen = np.flatnonzero(allowed)
    if not len(chosen):
        raise OutputError("no visible node looks that way; give another --facing")
    return int(chosen[np.argmin(np.linalg.norm(mesh.positions[chosen] - place, axis=1))])


def seen_from(field: RadianceField, node: int, directions: FloatArray) -> Parts:
    """Luminance of a node in directions (k, 3), unit, scene axes, away from the surface."""
    mesh, count = field.mesh, len(directions)
    coefficients = field.values.radiance_sh[node].astype(np.float64)
    local = to_local(directions, mesh.normals[node], mesh.frames_x[node])
    stored = evaluate(degree_of(len(coefficients)), local) @ coefficients
    images = field.images(
        np.tile(mesh.positions[node], (count, 1)),
        np.tile(mesh.normals[node], (count, 1)),
        directions,
        np.full(count, np.flatnonzero(field.labels == mesh.patches[node])[0]),
    )
    return Parts(
        luminance_weighted(stored),
        luminance_weighted(images),
        float(luminance_weighted(field.emission[node])),
    )


def luminance_body(field: RadianceField, node: int) -> LuminanceBody:
    """Look at a node from all sides."""
    zenith = np.radians(np.arange(0, 90 + ZENITH_STEP, ZENITH_STEP))
    azimuth = np.radians(np.arange(0, 360, AZIMUTH_STEP))
    theta, phi = np.meshgrid(zenith, azimuth, indexing="ij")
    local = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    directions = to_scene(local, field.mesh.normals[node], field.mesh.frames_x[node])
    parts = seen_from(field, node, directions.reshape(-1, 3))
    return LuminanceBody(
        node=node,
        zenith=zenith,
        azimuth=azimuth,
        directions=directions,
        luminance=parts.total.reshape(theta.shape),
        images=parts.images.reshape(theta.shape),
        emitted=parts.emitted,
    )
