"""Largest numbers a scene may hold; beyond them a slip is likelier, and products would overflow."""

from __future__ import annotations

#: Coordinates in m.
FARTHEST = 1e9

#: Luminance in cd/m², intensity in cd, flux in lm (the sun's disc: 1.6e9 cd/m²).
BRIGHTEST = 1e15

#: Exponent of a Phong lobe; a lobe this narrow is a mirror in all but name.
SHARPEST = 1e6
