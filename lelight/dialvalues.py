"""Dial of edge by target; written by ``tests/derive_presets.py``, not by hand."""

from __future__ import annotations

#: Targets, and edge length over the default of the scene's size at each.
POINTS: tuple[tuple[float, float], ...] = (
    (0.01, 0.65),
    (0.02, 0.806),
    (0.04, 1.59),
    (0.08, 2.5),
    (0.16, 2.5),
)
#: The edge goes with this power of the target beyond them.
POWER = 0.552
#: Target of a draft: half the error takes more than 1.5 times as long.
DRAFT = 0.04
