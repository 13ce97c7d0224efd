"""What is suspicious in a scene that can nevertheless be lit, and the table of its materials."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from lelight.reading.fronts import Caster, blind_fronts
from lelight.reading.inputfile import quoted
from lelight.reading.palette import listed
from lelight.scene import FloatArray, IntArray, Scene, triangle_areas

#: Positions closer than this share of the scene's diagonal are one.
WELDED = 1e-7

#: A triangle lower than this share of its longest edge is degenerate.
SLENDER = 1e-6

#: Share of incoming light that few real surfaces send back.
SUSPICIOUS_ALBEDO = 0.95


@dataclass(frozen=True)
class Finding:
    """Something to look at; a warning changes the light, a note may be meant."""

    rule: str
    severity: Literal["warning", "note"]
    text: str


@dataclass(frozen=True)
class MaterialRow:
    """One material of the table: faces, their area in m², and the values in use with where they come from."""

    name: str
    faces: int
    area: float
    reflectance: FloatArray
    specular: FloatArray
    exponent: float
    luminance: FloatArray
    origin: str


def lint(scene: Scene, *, caster: Caster | None = None) -> tuple[Finding, ...]:
    """Look a scene over.

    Parameters
    ----------
    caster : finds what stands before an emitter; without one, only the bounding box tells
    """
    welded = _welded(scene)
    return (
        *(Finding("reading", "warning", text) for text in scene.warnings),
        *_duplicate_faces(scene, welded),
        *_degenerate_faces(scene, welded),
        *_open_edges(scene, welded),
        *_flipped_emitters(scene, caster),
        *_odd_materials(scene),
    )


def material_table(scene: Scene) -> tuple[MaterialRow, ...]:
    """Every material with the faces it covers, in the scene's order."""
    count = len(scene.materials)
    faces = np.bincount(scene.triangle_materials, minlength=count)
    areas = np.bincount(scene.triangle_materials, triangle_areas(scene.corners), minlength=count)
    return tuple(
        MaterialRow(
            name=material.name,
            faces=int(face_count),
            area=float(area),
            reflectance=material.diffuse,
            specular=material.specular,
            exponent=material.exponent,
            luminance=material.luminance,
            origin=material.origin,
        )
        for material, face_count, area in zip(scene.materials, faces, areas, strict=True)
    )


def _welded(scene: Scene) -> IntArray:
    """Triangles (m, 3) with one number for all vertices at one place."""
    cells = np.round((scene.vertices - scene.vertices.min(axis=0)) / (WELDED * scene.diagonal))
    _, places = np.unique(cells.astype(np.int64), axis=0, return_inverse=True)
    return np.asarray(places.reshape(-1)[scene.triangles])


def _duplicate_faces(scene: Scene, welded: IntArray) -> Iterator[Finding]:
    _, first, counts = np.unique(np.sort(welded, axis=1), axis=0, return_index=True, return_counts=True)
    repeated = int(np.sum(counts - 1))
    if repeated:
        where = _place(scene.corners[first[np.argmax(counts > 1)]].mean(axis=0))
        yield Finding(
            "duplicate faces", "warning", f"{repeated} faces lie on another one, the first at {where}"
        )


def _degenerate_faces(scene: Scene, welded: IntArray) -> Iterator[Finding]:
    collapsed = (welded == np.roll(welded, 1, axis=1)).any(axis=1)
    edges = scene.corners - np.roll(scene.corners, 1, axis=1)
    longest = np.einsum("ijk,ijk->ij", edges, edges).max(axis=1)
    slender = collapsed | (2 * triangle_areas(scene.corners) <= SLENDER * longest)
    if slender.any():
        where = _place(scene.corners[np.argmax(slender)].mean(axis=0))
        text = f"{int(slender.sum())} faces are all but lines, the first at {where}"
        yield Finding("degenerate faces", "note", text)


def _open_edges(scene: Scene, welded: IntArray) -> Iterator[Finding]:
    """Edges of one face only; solids have none, and light may leak where a room has one."""
    edges = np.sort(np.stack([welded, np.roll(welded, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, first, counts = np.unique(edges, axis=0, return_index=True, return_counts=True)
    if (counts == 1).any():
        triangle, corner = divmod(int(first[np.argmax(counts == 1)]), 3)
        ends = scene.corners[triangle][[corner, (corner + 1) % 3]]
        count, where = int((counts == 1).sum()), _place(ends.mean(axis=0))
        yield Finding(
            "open edges", "note", f"{count} edges of one face only, the first at {where}; light may leak"
        )


def _flipped_emitters(scene: Scene, caster: Caster | None) -> Iterator[Finding]:
    """Emitters whose front, for more than half of their area, has no free way before it."""
    areas = triangle_areas(scene.corners)
    for index, material in enumerate(scene.materials):
        faces = np.flatnonzero(scene.triangle_materials == index)
        if not material.emits or material.emission_sides == "both" or not len(faces):
            continue
        blind = blind_fronts(scene, faces, caster=caster)
        if areas[faces][blind].sum() > 0.5 * areas[faces].sum():
            text = f"material {quoted(material.name)} emits into a surface or out of the scene"
            remedy = 'turn its faces over, or give it sides = "both"'
            yield Finding("flipped emitters", "warning", f"{text}; {remedy}")


def _odd_materials(scene: Scene) -> Iterator[Finding]:
    for material in scene.materials:
        name, albedo = quoted(material.name), material.diffuse + material.specular
        if np.max(albedo) > SUSPICIOUS_ALBEDO:
            text = f"material {name} reflects {listed(albedo)} of the light; few real surfaces pass 0.9"
            yield Finding("bright material", "warning", text)
        if material.exponent > 1 and not material.glossy:
            text = f"material {name} has exponent {material.exponent:g} but no specular reflectance to use it"
            yield Finding("idle exponent", "note", text)


def _place(point: FloatArray) -> str:
    return f"({', '.join(f'{coordinate:.3f}' for coordinate in point)}) m"


def material_rows(scene: Scene) -> list[dict[str, Any]]:
    """Material table as files hold it."""
    return [
        {
            "name": row.name,
            "area_m2": row.area,
            "reflectance": row.reflectance.tolist(),
            "specular": row.specular.tolist(),
            "exponent": row.exponent,
            "luminance_cd_m2": row.luminance.tolist(),
            "origin": row.origin,
        }
        for row in material_table(scene)
    ]
