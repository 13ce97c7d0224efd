"""Scenes of a user's whose light is known exactly, recognised by what they are, not by their name."""

from __future__ import annotations

import math

import numpy as np

from lelight.analytic import sobolev, sphere
from lelight.fielderror import Exact
from lelight.scene import FloatArray, PointLuminaire, Scene, triangle_areas, triangle_normals

#: What counts as equal: of radii and places as share of the scene's size, of reflectances and luminances.
SAME = 1e-3


def known_illuminance(scene: Scene) -> tuple[str, Exact] | None:
    """Name of the problem and its exact illuminance; None for an ordinary scene."""
    if any(m.glossy or np.ptp(m.diffuse) > 0 for m in scene.materials):
        return None
    return _furnace(scene) or _sphere(scene) or _discs(scene)


def _lamp(scene: Scene) -> tuple[FloatArray, float] | None:
    """Place and intensity of the only source, an isotropic point; None where there is another."""
    if any(m.emits for m in scene.materials) or len(scene.luminaires) != 1:
        return None
    (lamp,) = scene.luminaires
    return (lamp.position, float(lamp.intensity[0])) if isinstance(lamp, PointLuminaire) else None


def _furnace(scene: Scene) -> tuple[str, Exact] | None:
    """Recognise closed surfaces that all reflect and emit alike: E = pi L / (1 - rho) everywhere."""
    first = scene.materials[0]
    alike = all(
        np.array_equal(m.diffuse, first.diffuse) and np.array_equal(m.luminance, first.luminance)
        for m in scene.materials
    )
    if not (alike and first.emits and not scene.luminaires and _closed(scene)):
        return None
    illuminance = math.pi * float(first.luminance[0]) / (1.0 - float(first.diffuse[0]))
    return "furnace: E = π L / (1 − ρ)", lambda points, _: np.full(len(points), illuminance)


def _closed(scene: Scene) -> bool:
    """Every edge is run through as often one way as the other, so no light gets out."""
    _, weld = np.unique(np.round(scene.vertices / (1e-9 * scene.diagonal)), axis=0, return_inverse=True)
    faces = weld.ravel()[scene.triangles]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    count = int(faces.max()) + 1
    way, back = np.sort(edges @ [count, 1]), np.sort(edges @ [1, count])
    return bool(np.array_equal(way, back))


def _sphere(scene: Scene) -> tuple[str, Exact] | None:
    """Recognise a closed sphere of one reflectance with an isotropic point in its middle."""
    lamp = _lamp(scene)
    if lamp is None or len(scene.materials) != 1 or not _closed(scene):
        return None
    middle, intensity = lamp
    reach = np.linalg.norm(scene.corners - middle, axis=2)
    inward = np.einsum("tx,tx->t", triangle_normals(scene.corners), scene.corners[:, 0] - middle) < 0
    if np.ptp(reach) > SAME * reach.max() or not inward.all():
        return None
    area = float(triangle_areas(scene.corners).sum())
    reflectance = float(scene.materials[0].diffuse[0])

    def exact(points: FloatArray, normals: FloatArray) -> FloatArray:
        return sphere.illuminance(
            points - middle, normals, reflectance=reflectance, area=area, intensity=intensity
        )

    return "photometric sphere: balance of energy", exact


def _discs(scene: Scene) -> tuple[str, Exact] | None:
    """Recognise Sobolev's problem: two parallel discs 2 m apart, an isotropic point on their axis."""
    lamp = _lamp(scene)
    if lamp is None:
        return None
    (x, y, z), intensity = lamp
    heights = scene.corners[..., 2]
    low, high = float(heights.min()), float(heights.max())
    level = np.minimum(np.abs(heights - low), np.abs(heights - high)).max() <= 1e-9
    reach = np.hypot(scene.corners[..., 0] - x, scene.corners[..., 1] - y)
    radius = float(reach.max())
    share = triangle_areas(scene.corners).sum() / (2.0 * math.pi * radius**2)
    if not (
        level and abs(high - low - sobolev.HEIGHT) < 1e-9 and low < z < high and abs(share - 1.0) < 5 * SAME
    ):
        return None
    upper = heights.mean(axis=1) > 0.5 * (low + high)
    reflectances = []
    for own in (~upper, upper):
        found = {float(scene.materials[m].diffuse[0]) for m in scene.triangle_materials[own]}
        if len(found) != 1:
            return None
        reflectances.append(found.pop())
    radii = np.linspace(0.0, radius, 401)
    tables = sobolev.discs(
        radii, source_height=z - low, reflectances=(reflectances[0], reflectances[1]), radius=radius
    )

    def exact(points: FloatArray, _: FloatArray) -> FloatArray:
        r = np.hypot(points[:, 0] - x, points[:, 1] - y)
        above = points[:, 2] > 0.5 * (low + high)
        heights_to = np.where(above, high - z, z - low)
        # Direct light is exact at every point; only the smooth rest is read off the table.
        rest = [
            table - sobolev.direct(height, radii)
            for table, height in zip(tables, (z - low, high - z), strict=True)
        ]
        spread = np.where(above, np.interp(r, radii, rest[1]), np.interp(r, radii, rest[0]))
        direct = heights_to / (r**2 + heights_to**2) ** 1.5
        return np.asarray(intensity * (direct + spread))

    return "Sobolev's problem on discs: integral equations", exact
