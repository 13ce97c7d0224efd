"""Materials and luminaires as the run used them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lelight.reports.rounding import MISSING, as_given, significant, vector


def material_rows(run: Mapping[str, Any]) -> list[dict[str, str]]:
    """Rows of the material table; a colour is written as its components, grey as one number."""
    return [_material_row(material) for material in run.get("materials") or []]


def luminaire_rows(run: Mapping[str, Any]) -> list[dict[str, str]]:
    """Rows of the luminaire table: name, position in m, intensity in cd."""
    return [
        _luminaire_row(luminaire) for luminaire in run.get("luminaires") or [] if isinstance(luminaire, dict)
    ]


def _material_row(material: Mapping[str, Any]) -> dict[str, str]:
    area = material.get("area_m2")
    glossy = any(_components(material.get("specular")))
    luminous = any(_components(material.get("luminance_cd_m2")))
    return {
        "name": str(material.get("name", MISSING)),
        "area": MISSING if area is None else significant(float(area)),
        "reflectance": _colour(material.get("reflectance")),
        "specular": _colour(material.get("specular")) if glossy else MISSING,
        "exponent": as_given(float(material.get("exponent") or 0)) if glossy else MISSING,
        "luminance": _colour(material.get("luminance_cd_m2")) if luminous else MISSING,
        "origin": str(material.get("origin") or ""),
    }


def _luminaire_row(luminaire: Mapping[str, Any]) -> dict[str, str]:
    position = luminaire.get("position")
    return {
        "name": str(luminaire.get("name", MISSING)),
        "position": vector(position) if position else MISSING,
        "intensity": _colour(luminaire.get("intensity_cd", luminaire.get("intensity"))),
        "flux": MISSING if luminaire.get("flux_lm") is None else significant(float(luminaire["flux_lm"])),
        "photometry": str(luminaire.get("photometry") or MISSING),
        "hash": str(luminaire.get("sha256") or ""),
    }


def _colour(found: Any) -> str:
    components = _components(found)
    if not components:
        return MISSING
    alike = max(components) - min(components) <= 1e-9 * max(map(abs, components))
    shown = components[:1] if alike else components
    return " / ".join(as_given(float(f"{component:.4g}")) for component in shown)


def _components(found: Any) -> Sequence[float]:
    if isinstance(found, list):
        return [float(component) for component in found]
    return [] if found is None else [float(found)]
