"""Data sheets of luminaires: facts, polar curves, luminances, tabular UGR and lint notes of each file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lelight.reports.figures.polar import intensity_curves
from lelight.reports.folder import ResultFolder
from lelight.reports.rounding import MISSING, NO_BREAK_SPACE, fixed, significant, with_unit
from lelight.reports.texts import Texts

#: C planes of the luminance table that are printed, in degrees.
PRINTED_C = 30.0
#: First and last plane that differ, by the symmetry that the file declares.
SECTORS = {"rotational": (0.0, 0.0), "both": (0.0, 90.0), "c0-c180": (0.0, 180.0), "c90-c270": (-90.0, 90.0)}


def data_sheets(folder: ResultFolder) -> tuple[list[dict[str, Any]], dict[str, bytes]]:
    """Sheets of the photometric files of a run, and their polar curves."""
    sheets = [sheet for sheet in folder.run.get("data_sheets") or [] if isinstance(sheet, dict)]
    figures = {_figure_name(k): _polar(sheet) for k, sheet in enumerate(sheets) if sheet.get("polar")}
    return [_sheet(k, sheet, folder.texts) for k, sheet in enumerate(sheets)], figures


def _figure_name(number: int) -> str:
    return f"luminaire-{number + 1}.svg"


def _polar(sheet: Mapping[str, Any]) -> bytes:
    curves = {name: np.asarray(candela, dtype=float) for name, candela in sheet["polar"]["cd"].items()}
    return intensity_curves(np.asarray(sheet["polar"]["angles"], dtype=float), curves)


def _sheet(number: int, sheet: Mapping[str, Any], texts: Texts) -> dict[str, Any]:
    return {
        "name": str(sheet.get("name") or sheet.get("path") or MISSING),
        "path": str(sheet.get("path") or ""),
        "sha256": str(sheet.get("sha256") or MISSING),
        "facts": [[label, value] for label, value in _facts(sheet, texts) if value],
        "polar": _figure_name(number) if sheet.get("polar") else "",
        "luminance": _luminances(sheet.get("luminance") or {}, str(sheet.get("symmetry"))),
        "ugr": ugr_rows(sheet["ugr"]) if sheet.get("ugr") else None,
        "ugr_note": _ugr_note(sheet, texts),
        "findings": [_finding(finding, texts) for finding in sheet.get("findings") or []],
    }


def _facts(sheet: Mapping[str, Any], texts: Texts) -> list[tuple[str, str]]:
    words = sheet.get("texts") or {}
    spread = sheet.get("spread") or [{}, {}]
    peak = sheet.get("peak") or {}
    opening = sheet.get("opening") or {}
    at = texts.filled("at_angles", c=f"{peak.get('c', 0):g}", gamma=f"{peak.get('gamma', 0):g}")
    return [
        (texts["sheet_company"], str(words.get("company") or "")),
        (texts["sheet_number"], str(words.get("number") or "")),
        (texts["sheet_report"], str(words.get("report") or "")),
        (texts["sheet_format"], str(sheet.get("format") or "")),
        (texts["sheet_symmetry"], str(sheet.get("symmetry") or "")),
        (texts["sheet_flux"], _measure(sheet, "flux", "lm")),
        (texts["sheet_declared"], _measure(sheet, "declared_flux", "lm")),
        (texts["sheet_lamp_flux"], _measure(sheet, "lamp_flux", "lm")),
        (texts["sheet_ratio"], _share(sheet.get("light_output_ratio"))),
        (texts["sheet_downward"], _share(sheet.get("downward_fraction"))),
        (texts["sheet_power"], _measure(sheet, "power", "W")),
        (texts["sheet_efficacy"], _measure(sheet, "efficacy", "lm/W")),
        (texts["sheet_peak"], f"{_measure(peak, 'intensity', 'cd')} {at}" if peak else ""),
        (texts["sheet_beam"], "; ".join(_angle(plane.get("beam"), texts) for plane in spread)),
        (texts["sheet_field"], "; ".join(_angle(plane.get("field"), texts) for plane in spread)),
        (texts["sheet_code"], " ".join(str(part) for part in sheet.get("flux_code") or ())),
        (texts["sheet_opening"], _opening(opening, texts)),
        (texts["sheet_used"], ", ".join(str(name) for name in sheet.get("used_by") or ())),
    ]


def _measure(found: Mapping[str, Any], key: str, unit: str) -> str:
    number = found.get(key)
    return with_unit(significant(float(number), 4), unit) if number else ""


def _share(number: float | None) -> str:
    return "" if number is None else f"{fixed(100.0 * number, 1)}{NO_BREAK_SPACE}%"


def _angle(degrees: float | None, texts: Texts) -> str:
    return texts["none"] if degrees is None else f"{degrees:.0f}°"


def _opening(opening: Mapping[str, Any], texts: Texts) -> str:
    if not opening or opening.get("shape") == "point":
        return texts["none"]
    return f"{opening['along_c0']:g}{NO_BREAK_SPACE}m × {opening['along_c90']:g}{NO_BREAK_SPACE}m"


def _luminances(table: Mapping[str, Any], symmetry: str) -> dict[str, Any]:
    """Head and rows of the luminance table, every 30 degrees of C as far as the symmetry leaves them different."""
    rows = zip(table.get("c") or (), table.get("cd_m2") or (), strict=True)
    first, last = SECTORS.get(symmetry, (0.0, 360.0))
    kept = [
        (c, row)
        for c, row in rows
        if c % PRINTED_C == 0 and (first <= c <= last or first <= c - 360.0 <= last)
    ]
    if not kept or all(each is None for _, row in kept for each in row):
        return {"head": [], "rows": []}
    if all(row == kept[0][1] for _, row in kept):
        kept = kept[:1]
        names = ["C 0° – 360°"] if symmetry in {"rotational", "none"} else [f"C {kept[0][0]:.0f}°"]
    else:
        names = [f"C {c:.0f}°" for c, _ in kept]
    cells = [[MISSING if each is None else significant(each) for each in row] for _, row in kept]
    head = [f"γ {gamma:.0f}°" for gamma in table.get("gamma") or ()]
    return {"head": head, "rows": [[name, *row] for name, row in zip(names, cells, strict=True)]}


def ugr_rows(table: Mapping[str, Any]) -> dict[str, Any]:
    """Head and rows of a table of UGR: room, five ratings crosswise, five endwise."""
    both = zip(table["rooms"], table["crosswise"], table["endwise"], strict=True)
    return {
        "reflectances": [str(each) for each in table["reflectances"]],
        "rows": [
            [room.replace(" x ", " × "), *(_rating(each) for each in (*cross, *end))]
            for room, cross, end in both
        ],
    }


def _rating(rating: float | None) -> str:
    if rating is None:
        return MISSING
    return "<10" if rating < 10.0 else fixed(rating, 1)


def _ugr_note(sheet: Mapping[str, Any], texts: Texts) -> str:
    table = sheet.get("ugr")
    if not table:
        return texts.filled("sheet_no_ugr", reason=sheet.get("no_ugr") or MISSING)
    return texts.filled("sheet_ugr_note", flux=significant(table["flux"], 4), spacing=f"{table['spacing']:g}")


def _finding(finding: Mapping[str, Any], texts: Texts) -> str:
    severity = texts.labels.get(f"severity_{finding.get('severity')}", str(finding.get("severity")))
    line = finding.get("line")
    return f"{severity}: {finding.get('text')}" + (f" ({texts['file']}: {line})" if line else "")
