"""The dial: which edge goes with which target, so that neither mesh nor chains spend what the other cannot use."""

from __future__ import annotations

from lelight.dialvalues import AT_ONE, POWER

#: Edges against the default of the scene's size that the dial keeps within.
FINEST, COARSEST = 0.3, 3.0


def edge_scale(target: float) -> float:
    """Edge over the default edge for a relative standard error, on the front of the committed scenes."""
    return min(max(AT_ONE * float(target**POWER), FINEST), COARSEST)
