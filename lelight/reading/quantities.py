"""Numbers as scene files and command lines write them: what each allows, in words a message can use."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator

from lelight.reading.limits import BRIGHTEST, FARTHEST, SHARPEST

Triple = tuple[float, float, float]

_SECONDS = {"": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0}
_BYTES = {"": 1.0, "B": 1.0, "kB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
_BYTES |= {"kiB": 2.0**10, "MiB": 2.0**20, "GiB": 2.0**30, "TiB": 2.0**40}


def _is_number(found: object) -> bool:
    if isinstance(found, bool) or not isinstance(found, (int, float)):
        return False
    try:
        return math.isfinite(float(found))
    except OverflowError:
        return False


def number(lower: float = -math.inf, upper: float = math.inf, *, above: float = -math.inf) -> BeforeValidator:
    """Check for one finite number from ``lower`` to ``upper`` that is greater than ``above``."""

    def check(found: Any) -> float:
        if not _is_number(found) or not lower <= found <= upper or not found > above:
            raise ValueError(f"allowed is a number{_bounds(lower, upper, above)}")
        return float(found)

    return BeforeValidator(check)


def triple(lower: float = -math.inf, upper: float = math.inf, *, one: bool = False) -> BeforeValidator:
    """Check for three finite numbers; with ``one``, a single number may stand for three equal ones."""
    return BeforeValidator(_triple_check(lower, upper, one=one))


def _triple_check(lower: float, upper: float, *, one: bool) -> Callable[[Any], Triple]:
    allowed = ("one number or " if one else "") + f"three numbers{_bounds(lower, upper, -math.inf)}"

    def check(found: Any) -> Triple:
        numbers = [found] * 3 if one and _is_number(found) else found
        if not isinstance(numbers, list) or len(numbers) != 3:
            raise ValueError(f"allowed are {allowed}")
        if not all(_is_number(component) and lower <= component <= upper for component in numbers):
            raise ValueError(f"allowed are {allowed}")
        return float(numbers[0]), float(numbers[1]), float(numbers[2])

    return check


def reflectance_or_file(found: Any) -> Triple | str:
    """Check for a reflectance, or for the name of a file that holds it by wavelength."""
    if isinstance(found, str) and found.lower().endswith((".csv", ".txt", ".spdx")):
        return found
    try:
        return _triple_check(0, 1, one=True)(found)
    except ValueError as error:
        raise ValueError(f"{error}, or the name of a .csv file of spectral reflectance") from None


def _bounds(lower: float, upper: float, above: float) -> str:
    if math.isfinite(above):
        return f" above {above:g}"
    if math.isfinite(upper):
        return f" from {lower:g} to {upper:g}"
    return f", {lower:g} or more" if math.isfinite(lower) else ""


def relative_error(found: object) -> float:
    """Share of 1 from ``0.02`` or ``"2%"``; ValueError names what is allowed."""
    share = found
    if isinstance(found, str) and re.fullmatch(r"\s*[0-9.]+\s*%?\s*", found):
        share = _percent(found)
    if not isinstance(share, (int, float)) or not _is_number(share) or not 0 < share < 1:
        raise ValueError('allowed is a share like 0.02 or "2%", above 0 and below 1')
    return float(share)


def _percent(text: str) -> float | None:
    try:
        return float(text.rstrip(" %")) / (100 if "%" in text else 1)
    except ValueError:
        return None


def spacing(found: object) -> tuple[float, float]:
    """Two lengths from ``2.4`` or ``[2.4, 1.8]``; ValueError names what is allowed."""
    numbers: list[Any] = found if isinstance(found, list) else [found, found]
    if len(numbers) != 2 or not all(_is_number(one) and 0 < float(one) <= FARTHEST for one in numbers):
        raise ValueError("allowed are one or two numbers above 0")
    return float(numbers[0]), float(numbers[1])


def seconds(found: object) -> float:
    """Time in s from ``60``, ``"60s"``, ``"5min"`` or ``"1h"``; ValueError names what is allowed."""
    time = found
    if isinstance(found, str):
        match = re.fullmatch(r"\s*([0-9]+(?:\.[0-9]*)?)\s*(s|min|h|)\s*", found)
        time = float(match[1]) * _SECONDS[match[2]] if match else None
    if not isinstance(time, (int, float)) or not _is_number(time) or time <= 0:
        raise ValueError('allowed is a time like 60, "60s", "5min" or "1h", above 0')
    return float(time)


def memory_size(found: object) -> float:
    """Bytes from ``2e9``, ``"2GB"``, ``"500 MB"`` or ``"1.5GiB"``; ValueError names what is allowed."""
    size = found
    if isinstance(found, str):
        match = re.fullmatch(r"\s*([0-9]+(?:\.[0-9]*)?(?:e[0-9]+)?)\s*([kMGT]i?B|B|)\s*", found)
        size = float(match[1]) * _BYTES[match[2]] if match else None
    if not isinstance(size, (int, float)) or not _is_number(size) or size <= 0:
        raise ValueError('allowed is a size like 4e9, "4GB", "500MB" or "2GiB", above 0')
    return float(size)


def _nonzero(found: Triple) -> Triple:
    if not any(found):
        raise ValueError("allowed is a vector that is not zero")
    return found


#: (3,) in m, scene axes.
Position = Annotated[Triple, triple(-FARTHEST, FARTHEST)]

#: (3,) of any length but zero.
Direction = Annotated[Triple, AfterValidator(_nonzero), triple(-FARTHEST, FARTHEST)]

#: (3,) reflectance of linear Rec. 709 components, each 0 to 1; one number stands for three.
Reflectance = Annotated[Triple, triple(0, 1, one=True)]

#: The same, or the name of a file of spectral reflectance.
SpectralReflectance = Annotated[Triple | str, BeforeValidator(reflectance_or_file)]

#: (3,) luminance or intensity of linear Rec. 709 components; one number stands for three.
Colour = Annotated[Triple, triple(0, BRIGHTEST, one=True)]

#: 0 to 1.
Share = Annotated[float, number(0, 1)]

#: Luminous flux in lm.
Flux = Annotated[float, number(0, BRIGHTEST)]

#: Exponent of a Phong lobe.
Exponent = Annotated[float, number(0, SHARPEST)]

#: Greater than 0.
Positive = Annotated[float, number(above=0)]

#: Length in m, greater than 0.
Length = Annotated[float, number(upper=FARTHEST, above=0)]

#: Distances in m along x and y, each above 0; one number stands for both.
Spacing = Annotated[tuple[float, float], BeforeValidator(spacing)]

#: Relative standard error, :func:`relative_error`.
RelativeError = Annotated[float, BeforeValidator(relative_error)]

#: Time in s, :func:`seconds`.
Seconds = Annotated[float, BeforeValidator(seconds)]

#: Size in bytes, :func:`memory_size`.
MemorySize = Annotated[float, BeforeValidator(memory_size)]

#: Width of a band in m, 0 for none.
Band = Annotated[float, number(0, 1000)]


def threshold(found: object) -> str:
    """Threshold of glare sources, ``"2000"`` (cd/m²), ``"5 x task"`` or ``"7 x picture"``, in one spelling."""
    if _is_number(found) and isinstance(found, (int, float)) and found > 0:
        return f"{float(found)!r} absolute"
    match = (
        re.fullmatch(r"\s*([0-9]+(?:\.[0-9]*)?)\s*x\s*(task|picture)\s*", found)
        if isinstance(found, str)
        else None
    )
    if match is None or not float(match[1]) > 0:
        raise ValueError('allowed is a luminance in cd/m² like 2000, "5 x task" or "7 x picture"')
    return f"{float(match[1])!r} {match[2]}"


#: Threshold of glare sources in a picture, :func:`threshold`.
Threshold = Annotated[str, BeforeValidator(threshold)]
