"""Dial of edge by target, and the presets on it; written by ``tests/derive_presets.py``, not by hand."""

from __future__ import annotations

from typing import Literal

#: Edge length over the default of the scene's size is AT_ONE x target ** POWER.
AT_ONE, POWER = 5.501, 0.3932
#: Target and edge scale of each preset.
PRESET_POINTS: dict[Literal["draft", "normal", "fine"], tuple[float, float]] = {
    "draft": (0.08, 2.04),
    "normal": (0.02, 1.18),
    "fine": (0.01, 0.9),
}
