"""What ``run.json`` and ``metrics.json`` may hold: checked at the door, so that nobody behind it has to.

Keys may be missing and others may be added; what is there has to be of its kind. Numbers are finite.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from lelight.errors import OutputError

#: Raises ValueError with the place, a dotted key, where what was found is not of a kind.
Kind = Callable[[Any, str], None]

#: Largest file that is read, in bytes; a run of a thousand planes and eyes writes a tenth of it.
LARGEST_FILE = 1 << 28
#: Largest number.
LARGEST_NUMBER = 1e300


def number(found: Any, place: str) -> None:
    """Accept a finite number."""
    if isinstance(found, bool) or not isinstance(found, int | float):
        raise ValueError(f"{place!r} is not a number")
    if not -LARGEST_NUMBER <= found <= LARGEST_NUMBER:
        raise ValueError(f"{place!r} is not a finite number")


def count(found: Any, place: str) -> None:
    """Accept an integer, 0 or more."""
    if isinstance(found, bool) or not isinstance(found, int) or not 0 <= found < 1 << 63:
        raise ValueError(f"{place!r} is not a count")


def text(found: Any, place: str) -> None:
    """Accept a text."""
    if not isinstance(found, str):
        raise ValueError(f"{place!r} is not a text")


def flag(found: Any, place: str) -> None:
    """Accept true and false."""
    if not isinstance(found, bool):
        raise ValueError(f"{place!r} is neither true nor false")


def plain(found: Any, place: str) -> None:
    """Accept text, number, flag or null."""
    if found is not None and not isinstance(found, bool):
        (text if isinstance(found, str) else number)(found, place)


def nested(found: Any, place: str) -> None:
    """Accept what is plain, and lists and objects of it."""
    if isinstance(found, list):
        items(nested)(found, place)
    elif isinstance(found, dict):
        table(others=nested)(found, place)
    else:
        plain(found, place)


def or_null(kind: Kind) -> Kind:
    """Accept null beside a kind."""

    def check(found: Any, place: str) -> None:
        if found is not None:
            kind(found, place)

    return check


def items(kind: Kind, *, length: int | None = None) -> Kind:
    """Accept a list of a kind, of a length where one is given."""

    def check(found: Any, place: str) -> None:
        if not isinstance(found, list) or length not in (None, len(found)):
            raise ValueError(f"{place!r} is not a list{'' if length is None else f' of {length}'}")
        for index, item in enumerate(found):
            kind(item, f"{place}[{index}]")

    return check


def table(known: Mapping[str, Kind] | None = None, *, others: Kind | None = None) -> Kind:
    """Accept an object: keys that are known are of their kinds, others of one kind or anything."""

    def check(found: Any, place: str) -> None:
        if not isinstance(found, dict):
            raise ValueError(f"{place!r} is not an object")
        for key, item in found.items():
            inner = f"{place}.{key}" if place else key
            kind = (known or {}).get(key, others)
            if kind is not None:
                kind(item, inner)

    return check


VECTOR = items(number, length=3)
COLOUR = or_null(items(number))

FIGURE = table(
    {
        "value": or_null(number),
        "unit": or_null(text),
        "std_error": or_null(number),
        "target": or_null(number),
        "verdict": or_null(text),
        "method": or_null(text),
        "clause": or_null(text),
        "note": or_null(text),
        "interval": or_null(items(number, length=2)),
    }
)
SOURCE = table(
    {
        "name": text,
        "direction": or_null(VECTOR),
        "excluded": or_null(text),
        "flags": or_null(items(text)),
    }
    | dict.fromkeys(
        ("luminance", "luminance_cd_m2", "solid_angle", "solid_angle_sr", "visible_fraction", "t_over_r"),
        or_null(number),
    )
    | dict.fromkeys(("h_over_r", "position_index", "projected_area", "share"), or_null(number))
)


def figure_or_other(found: Any, place: str) -> None:
    """Accept a figure; an object without a value is none and passes."""
    if isinstance(found, dict) and "value" in found:
        FIGURE(found, place)


_DETAILS = table(
    {
        "file": text,
        "position": VECTOR,
        "direction": VECTOR,
        "u": VECTOR,
        "v": VECTOR,
        "origin": VECTOR,
        "grid": table({"rows": count, "columns": count, "rule": text, "wall_band": number}),
        "sources": items(SOURCE),
    }
)


def subject(found: Any, place: str) -> None:
    """Accept the entry of a plane, an observer or the room: figures, and details of known kinds."""
    _DETAILS(found, place)
    table(others=figure_or_other)(found, place)


METRICS = table(
    {"planes": table(others=subject), "observers": table(others=subject), "room": subject, "views": table()}
)

STEP = table(
    {"replicates": count, "doublings": count, "rays": count, "seconds": number}
    | dict.fromkeys(("rms", "p95", "p99"), or_null(number))
)
MATERIAL = table(
    {"name": text, "area_m2": number, "exponent": or_null(number), "origin": or_null(text)}
    | dict.fromkeys(("reflectance", "specular", "luminance_cd_m2"), COLOUR)
)
LAMP = table(
    {"name": text, "position": or_null(VECTOR), "intensity_cd": COLOUR, "intensity": COLOUR}
    | dict.fromkeys(("photometry", "sha256", "format", "luminaire"), or_null(text))
    | dict.fromkeys(("flux_lm", "power_w", "factor"), or_null(number))
)
RUN = table(
    dict.fromkeys(("lelight", "fingerprint", "scene", "scene_file", "date", "unit", "up"), text)
    | dict.fromkeys(("rays", "chains", "vertices", "replicates", "doublings", "nodes", "hidden_nodes"), count)
    | {
        "seed": count,
        "plan": items(table({"decision": text, "value": nested, "reason": text, "cost": text})),
        "settings": table(others=plain),
        "effort": table(others=number),
        "seconds": table(others=number),
        "error": table({"met": flag}, others=or_null(number)),
        "convergence": items(STEP),
        "bias": items(text),
        "warnings": items(text),
        "interpolation": or_null(table(others=number)),
        "materials": items(MATERIAL),
        "luminaires": items(LAMP),
        "angular": table(others=nested),
        "relit": table(others=table(others=nested)),
        "relit_of": text,
        "files": table(others=text),
        "versions": table(others=text),
    }
)


def read_object(path: Path, kind: Kind, *, remedy: str) -> dict[str, Any]:
    """Read one of the files.

    Parameters
    ----------
    remedy : what to do where that fails

    Raises
    ------
    OutputError
        where it is missing, not JSON, or holds something that is not of its kind
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise OutputError(f"{path}: larger than {LARGEST_FILE >> 20} MB; {remedy}")
        content = json.loads(path.read_text(encoding="utf-8"), parse_constant=lambda _: math.nan)
    except OSError as error:
        raise OutputError(f"{path}: {error.strerror or error}; {remedy}") from error
    except (ValueError, RecursionError) as error:
        raise OutputError(f"{path}: not JSON ({_short(str(error))}); {remedy}") from error
    if not isinstance(content, dict):
        raise OutputError(f"{path}: found a {type(content).__name__} instead of an object; {remedy}")
    try:
        kind(content, "")
    except ValueError as error:
        raise OutputError(f"{path}: damaged: {_short(str(error))}; {remedy}") from error
    except RecursionError as error:
        raise OutputError(f"{path}: damaged: nested too deeply; {remedy}") from error
    return content


def _short(message: str) -> str:
    shown = "".join(letter if letter.isprintable() else "?" for letter in message)
    return shown if len(shown) <= 200 else f"{shown[:197]}..."
