"""Materials and luminaires as the run used them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from lelight.reports.rounding import MISSING, as_given, significant, vector
from lelight.reports.texts import Texts


def material_rows(run: Mapping[str, Any]) -> list[dict[str, str]]:
    """Rows of the material table; a colour is written as its components, grey as one number."""
    return [_material_row(material) for material in run.get("materials") or []]


def luminaire_table(run: Mapping[str, Any], texts: Texts) -> dict[str, Any]:
    """Rows of the luminaires, their flux and power together, and the files with their hashes."""
    luminaires = [entry for entry in run.get("luminaires") or [] if isinstance(entry, dict)]
    rows = [_luminaire_row(f"L{number}", entry) for number, entry in enumerate(luminaires, start=1)]
    files = {(row["photometry"], row["hash"]): None for row in rows if row["hash"]}
    flux = math.fsum(float(entry.get("flux_lm") or 0.0) for entry in luminaires)
    power = math.fsum(float(entry.get("power_w") or 0.0) for entry in luminaires)
    return {
        "rows": rows,
        "flux": significant(flux, 4) if flux else "",
        "power": significant(power, 4) if power else "",
        "total": texts["total"],
        "files": [list(file) for file in files],
    }


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


def _luminaire_row(mark: str, luminaire: Mapping[str, Any]) -> dict[str, Any]:
    position, aim, c0 = (luminaire.get(key) for key in ("position", "aim", "c0"))
    directions = [vector(each) for each in (aim, c0) if each]
    return {
        "mark": mark,
        "name": str(luminaire.get("name", MISSING)),
        "position": vector(position) if position else MISSING,
        "directions": directions if len(directions) == 2 else [],
        "intensity": _colour(luminaire.get("intensity_cd", luminaire.get("intensity"))),
        "flux": _number(luminaire.get("flux_lm")),
        "power": _number(luminaire.get("power_w")),
        "photometry": str(luminaire.get("photometry") or MISSING),
        "hash": str(luminaire.get("sha256") or ""),
    }


def _number(found: Any) -> str:
    return significant(float(found), 4) if isinstance(found, int | float) else MISSING


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
