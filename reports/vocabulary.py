"""Senses of requirements, marks of observers, and words for keys that no text is written for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Sense = Literal["at least", "at most"]

#: Figures of which less is better; of all others more is.
AT_MOST = frozenset(
    {
        "maximum_illuminance", "max_illuminance", "ugr", "ugr_max", "ugr_small_sources", "ggr", "ugr_non_uniform",
        "gr", "source_veil", "ugr_picture", "dgp", "dgi", "dgi_modified", "cgi", "ugp", "ugp2", "ugr_experimental",
        "veiling_luminance", "veiling_luminance_cie",
    }
)  # fmt: skip
ABBREVIATIONS = frozenset({"sh", "ugr", "dgp", "ies", "rgb", "edi", "der"})


@dataclass(frozen=True)
class Term:
    """Printed name and symbol of a quantity, and which side of a target is the good one."""

    name: str
    symbol: str = ""
    sense: Sense = "at least"


def sense_of(key: str) -> Sense:
    """Tell which side of a requirement on a figure is the good one."""
    return "at most" if key in AT_MOST else "at least"


def words(key: str) -> str:
    """Turn a key of a file into words: underscores to spaces, abbreviations and the first letter large."""
    spaced = " ".join(
        word.upper() if word in ABBREVIATIONS else word for word in key.replace("_", " ").split()
    )
    return spaced[:1].upper() + spaced[1:]


def mark(number: int) -> str:
    """Letter of the observer with this index: A to Z, then AA.

    >>> mark(0), mark(25), mark(26)
    ('A', 'Z', 'AA')
    """
    letter = chr(ord("A") + number % 26)
    return letter if number < 26 else mark(number // 26 - 1) + letter
