"""Radiance of chosen nodes by direction: the angular field that ``field.vtp`` stores for glossy surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lelight.channels import channel_suffixes, luminance_weighted
from lelight.errors import OutputError
from lelight.harmonics.basis import degree_of, evaluate
from lelight.reports.figures.polar import radiance_curves
from lelight.reports.folder import CALC, ResultFolder
from lelight.reports.rounding import fixed, significant, vector, with_unit
from lelight.scene import FloatArray, IntArray
from lelight.writing.polydata import PolyData
from lelight.writing.vtpreading import read_polydata

#: Nodes that are shown at most, and of one material.
MOST_NODES, MOST_OF_MATERIAL = 6, 2
#: Degrees from the normal at which curves are evaluated.
ANGLES: FloatArray = np.linspace(-89.0, 89.0, 90)
#: Directions over the half sphere among which the brightest is looked for: steps of angle and of turn.
SEARCH = (18, 36)
HARMONICS = "radiance_sh"


@dataclass(frozen=True)
class AngularField:
    """Nodes with their reflected luminance in harmonics.

    Attributes
    ----------
    points : (n, 3) float, m
    coefficients : (n, (L + 1)²) float, cd/m², local frame
    degrees : (n,) int, largest degree that a node uses
    even : (n,) float, cd/m², luminance of the same flux sent evenly
    materials : (n,) int into ``names``
    """

    points: FloatArray
    coefficients: FloatArray
    degrees: IntArray
    even: FloatArray
    materials: IntArray
    names: tuple[str, ...]

    def luminance(self, node: int, directions: FloatArray) -> FloatArray:
        """Luminance (k,) in cd/m² along local unit directions (k, 3), the normal third; never below zero."""
        basis = _basis(self.coefficients.shape[1], directions)
        return np.asarray(np.maximum(basis @ self.coefficients[node], 0.0))


def read_angular_field(folder: ResultFolder) -> AngularField | None:
    """Read the visible nodes; None where the file holds no harmonics."""
    path = folder.file("field.vtp")
    content = read_polydata(path)
    coefficients = _coefficients(content)
    if coefficients is None:
        return None
    arrays = content.point_arrays
    if missing := [name for name in ("sh_degree", "hidden") if name not in arrays]:
        raise OutputError(f"{path}: no array {missing[0]}; {CALC} anew")
    triangles = content.polygons.reshape(-1, 3)
    materials = np.full(len(content.points), -1, dtype=np.int64)
    materials[triangles] = content.cell_arrays["material_id"][:, None]
    shown = (arrays["hidden"] == 0) & (materials >= 0)
    return AngularField(
        points=np.asarray(content.points, dtype=np.float64)[shown],
        coefficients=coefficients[shown],
        degrees=arrays["sh_degree"][shown].astype(np.int64),
        even=_even_luminance(coefficients[shown]),
        materials=materials[shown],
        names=tuple(content.texts.get("material_names", ())),
    )


def _coefficients(content: PolyData) -> FloatArray | None:
    """Luminance-weighted harmonics (n, m) over one, three or many channels."""
    arrays = content.point_arrays
    if HARMONICS in arrays:
        return np.asarray(arrays[HARMONICS], dtype=np.float64).reshape(len(content.points), -1)
    count = sum(name.startswith(f"{HARMONICS}_") for name in arrays)
    names = [HARMONICS + suffix for suffix in channel_suffixes(count)] if count else []
    if not names or any(name not in arrays for name in names):
        return None
    return luminance_weighted(np.stack([arrays[name] for name in names], axis=-1)).reshape(
        len(content.points), -1
    )


def _even_luminance(coefficients: FloatArray) -> FloatArray:
    """Divide the exitance by π (n,), in cd/m²; the exitance by the midpoint rule over the half sphere."""
    directions, weights = _half_sphere(24, 48)
    cosines = directions[:, 2] * weights / np.pi
    return np.asarray(coefficients @ _basis(coefficients.shape[1], directions).T @ cosines)


def _basis(count: int, directions: FloatArray) -> FloatArray:
    return evaluate(degree_of(count), directions)


def _half_sphere(polar: int, turns: int) -> tuple[FloatArray, FloatArray]:
    """Directions (k, 3) at the middles of cells of equal steps of angle and turn, and their solid angles (k,)."""
    theta = (np.arange(polar) + 0.5) * (np.pi / 2.0) / polar
    phi = (np.arange(turns) + 0.5) * 2.0 * np.pi / turns
    t, p = (grid.ravel() for grid in np.meshgrid(theta, phi, indexing="ij"))
    directions = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=1)
    return directions, np.sin(t) * (np.pi / 2.0 / polar) * (2.0 * np.pi / turns)


def chosen_nodes(field: AngularField) -> list[int]:
    """Of each glossy material the brightest node and the one whose luminance depends most on direction."""
    directions, _ = _half_sphere(*SEARCH)
    basis = _basis(field.coefficients.shape[1], directions)
    chosen: list[int] = []
    for material in np.unique(field.materials[field.degrees > 0]):
        own = np.flatnonzero((field.materials == material) & (field.degrees > 0) & (field.even > 0))
        if not len(own):
            continue
        largest = (field.coefficients[own] @ basis.T).max(axis=1)
        brightest = own[int(np.argmax(field.even[own]))]
        # Weak light is noisy: directions are compared where a node has a tenth of the brightest one's light.
        told = field.even[own] >= 0.1 * field.even[brightest]
        ratio = np.where(told, largest / field.even[own], 0.0)
        chosen += list(dict.fromkeys([int(brightest), int(own[int(np.argmax(ratio))])]))[:MOST_OF_MATERIAL]
    return chosen[:MOST_NODES]


def angular_pages(folder: ResultFolder) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Text and figures of the section; empty where the folder has no harmonics."""
    field = read_angular_field(folder)
    if field is None:
        return {"shown": False, "nodes": []}, {}
    nodes, figures = [], {}
    for number, node in enumerate(chosen_nodes(field), start=1):
        name = f"radiance-N{number}.svg"
        along, across = _curves(field, node)
        even = float(field.even[node])
        figures[name] = radiance_curves(ANGLES, along, across, even=even, mark=f"N{number}")
        nodes.append(
            {
                "figure": name,
                "mark": f"N{number}",
                "material": field.names[field.materials[node]] if field.names else "",
                "place": folder.texts.filled("node_at", position=vector(field.points[node].tolist())),
                "even": with_unit(significant(even), "cd/m²"),
                "ratio": fixed(float(max(along.max(), across.max())) / even, 2),
            }
        )
    return {"shown": True, "nodes": nodes}, figures


def _curves(field: AngularField, node: int) -> tuple[FloatArray, FloatArray]:
    """Luminances (90,) at `ANGLES` in the plane of the brightest direction, and in the one across it."""
    directions, _ = _half_sphere(*SEARCH)
    x, y, _ = directions[int(np.argmax(field.luminance(node, directions)))]
    turn, angle = np.arctan2(y, x), np.radians(ANGLES)

    def plane(phi: float) -> FloatArray:
        sine = np.sin(angle)
        return field.luminance(
            node, np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(angle)], axis=1)
        )

    return plane(float(turn)), plane(float(turn) + np.pi / 2.0)
