"""``lelight node``: one node of a result, seen from every side."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lelight.channels import luminance_weighted
from lelight.errors import OutputError
from lelight.field import RadianceField
from lelight.harmonics.spectrum import energy_by_degree
from lelight.nodelight import LuminanceBody, luminance_body, nearest_node, seen_from
from lelight.pipelines.folder import write_json
from lelight.pipelines.render import stored_field
from lelight.scene import FloatArray
from lelight.writing.bodyfile import write_body_picture, write_glyph
from lelight.writing.files import make_folder

#: Length of a glyph against the scene's diagonal.
GLYPH_SHARE = 0.05


@dataclass(frozen=True)
class NodeFiles:
    """What was written of a node, and its numbers."""

    picture: Path
    glyph: Path
    numbers: Path
    table: dict[str, Any]


def run_node(
    out: Path, place: FloatArray, *, facing: FloatArray | None = None, length: float | None = None
) -> NodeFiles:
    """Write ``OUT/nodes/NUMBER.png``, ``.vtp`` and ``.json`` of the visible node nearest to a place (3,) in m.

    Parameters
    ----------
    facing : (3,) float, a direction into which its surface looks
    length : float, m, of the glyph; default a twentieth of the scene's diagonal
    """
    field = stored_field(out)
    node = nearest_node(field, place, facing=facing)
    body = luminance_body(field, node)
    if not np.isfinite(body.luminance).all():
        raise OutputError(f"{out}: the luminance of node {node} is not finite; run `lelight calc` again")
    table = node_table(field, body, place)
    stem = make_folder(out / "nodes") / str(node)
    picture, glyph, numbers = (stem.with_suffix(ending) for ending in (".png", ".vtp", ".json"))
    files = NodeFiles(picture, glyph, numbers, table)
    x, y, z = table["position_m"]
    write_body_picture(
        files.picture, body, title=f"{table['material']}, node {node} at ({x:.2f}, {y:.2f}, {z:.2f}) m"
    )
    corners = field.scene.corners.reshape(-1, 3)
    diagonal = float(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)))
    write_glyph(
        files.glyph, body, position=field.mesh.positions[node], length=length or GLYPH_SHARE * diagonal
    )
    write_json(files.numbers, table)
    return files


def node_table(field: RadianceField, body: LuminanceBody, place: FloatArray) -> dict[str, Any]:
    """Numbers of a node, ready for JSON."""
    node, mesh, values = body.node, field.mesh, field.values
    zenith, azimuth = body.brightest
    return {
        "node": node,
        "asked_m": place.tolist(),
        "position_m": mesh.positions[node].tolist(),
        "distance_m": float(np.linalg.norm(mesh.positions[node] - place)),
        "normal": mesh.normals[node].tolist(),
        "frame_x": mesh.frames_x[node].tolist(),
        "material": field.scene.materials[mesh.materials[node]].name,
        "side": "front" if mesh.sides[node] > 0 else "back",
        "illuminance_lx": float(field.illuminance[node]),
        "illuminance_std_error_lx": float(values.std_error[node]),
        "direct_illuminance_lx": float(luminance_weighted(values.direct[node])),
        "scalar_illuminance_lx": float(luminance_weighted(values.scalar_illuminance[node])),
        "light_vector_lx": luminance_weighted(values.light_vector[node]).tolist(),
        "exitance_lm_m2": body.exitance,
        "emitted_cd_m2": body.emitted,
        "largest": {
            "luminance_cd_m2": float(body.luminance[zenith, azimuth]),
            "zenith_deg": float(np.degrees(body.zenith[zenith])),
            "azimuth_deg": float(np.degrees(body.azimuth[azimuth])),
            "direction": body.directions[zenith, azimuth].tolist(),
        },
        "least_cd_m2": float(body.luminance.min()),
        "toward": _toward_observers(field, node),
        "sh_degree": int(values.sh_degree[node]),
        "truncation_cd_m2": float(values.truncation[node]),
        "energy_share_by_degree": _energy_shares(field, node),
        "zenith_deg": np.degrees(body.zenith).round(9).tolist(),
        "azimuth_deg": np.degrees(body.azimuth).round(9).tolist(),
        "luminance_cd_m2": body.luminance.tolist(),
        "images_of_emitters_cd_m2": body.images.tolist(),
    }


def _toward_observers(field: RadianceField, node: int) -> dict[str, float]:
    """Luminance in cd/m² toward each eye over the node's horizon, whether or not something stands between."""
    found = {}
    for eye in field.scene.observers:
        away = eye.position - field.mesh.positions[node]
        away /= np.linalg.norm(away)
        if away @ field.mesh.normals[node] > 0.0:
            found[eye.name] = float(seen_from(field, node, away[None]).total[0])
    return found


def _energy_shares(field: RadianceField, node: int) -> list[float]:
    """Share of each degree in the square of the stored radiance, of its luminance."""
    degree = int(field.values.sh_degree[node])
    coefficients = luminance_weighted(field.values.radiance_sh[node, : (degree + 1) ** 2])
    energy = energy_by_degree(coefficients[:, None])[:, 0]
    total = max(float(energy.sum()), float(np.finfo(float).tiny))
    return [float(share) for share in energy / total]


def summary(files: NodeFiles) -> list[str]:
    """Lines that say the most important of a node."""
    table = files.table
    position = ", ".join(f"{coordinate:.3f}" for coordinate in table["position_m"])
    largest = table["largest"]
    lines = [
        f"node {table['node']} of {table['material']} ({table['side']}) at ({position}) m, "
        f"{table['distance_m']:.3f} m from the place asked for",
        f"illuminance {table['illuminance_lx']:.4g} ± {2 * table['illuminance_std_error_lx']:.2g} lx, "
        f"exitance {table['exitance_lm_m2']:.4g} lm/m²",
        f"luminance {table['least_cd_m2']:.4g} to {largest['luminance_cd_m2']:.4g} cd/m², brightest "
        f"{largest['zenith_deg']:.0f}° from the normal",
    ]
    lines += [f"toward {name}: {luminance:.4g} cd/m²" for name, luminance in table["toward"].items()]
    return [*lines, *(str(path) for path in (files.picture, files.glyph, files.numbers))]
