"""Data sheets of the photometric files of a scene, as ``run.json`` holds them for the reports."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from lelight.luminaires import Luminaire, PhotometricLuminaire
from lelight.metrics.cie190 import ugr_table
from lelight.photometry.diagram import ANGLES, polar_curves
from lelight.photometry.facts import facts
from lelight.photometry.findings import findings
from lelight.photometry.photometry import Photometry

#: Significant digits of the numbers; every so many degrees a point of the polar curves is kept.
DIGITS, CURVE_STEP = 6, 3


def data_sheets(luminaires: Iterable[Luminaire]) -> list[dict[str, Any]]:
    """Sheets of all files, each once, in the order in which the scene uses them."""
    files: dict[str, Photometry] = {}
    users: dict[str, list[str]] = {}
    for lamp in luminaires:
        if isinstance(lamp, PhotometricLuminaire):
            files.setdefault(lamp.path, lamp.photometry)
            users.setdefault(lamp.path, []).append(lamp.name)
    return [
        data_sheet(photometry) | {"path": path, "used_by": users[path]} for path, photometry in files.items()
    ]


def data_sheet(photometry: Photometry) -> dict[str, Any]:
    """Facts of a file, its polar curves, its table of UGR or why there is none, and what is odd about it."""
    sheet: dict[str, Any] = facts(photometry) | {
        "polar": {
            "angles": ANGLES[::CURVE_STEP].tolist(),
            "cd": {
                name: candela[::CURVE_STEP].tolist() for name, candela in polar_curves(photometry).items()
            },
        },
        "findings": [vars(finding) for finding in findings(photometry)],
    }
    try:
        sheet["ugr"] = ugr_table(photometry).to_json()
    except ValueError as reason:
        sheet["no_ugr"] = str(reason)
    rounded: dict[str, Any] = _rounded(sheet)
    return rounded


def _rounded(content: Any) -> Any:
    """Numbers to six significant digits, whatever they are nested in."""
    if isinstance(content, float):
        return float(f"{content:.{DIGITS}g}")
    if isinstance(content, dict):
        return {key: _rounded(part) for key, part in content.items()}
    if isinstance(content, list | tuple):
        return [_rounded(part) for part in content]
    return content
