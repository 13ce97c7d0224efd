"""The dial: which edge goes with which target, so that neither mesh nor chains spend what the other cannot use."""

from __future__ import annotations

import numpy as np

from lelight.dialvalues import POINTS, POWER

#: Edges against the default of the scene's size that the dial keeps within.
FINEST, COARSEST = 0.3, 3.0


def edge_scale(target: float) -> float:
    """Edge over the default edge for a relative standard error, on the fronts of the committed scenes.

    Between the points that were found it goes by a power of the target, and by one power beyond them.
    """
    targets, scales = np.array(POINTS).T
    scale = np.exp(np.interp(np.log(target), np.log(targets), np.log(scales)))
    scale *= (target / np.clip(target, targets[0], targets[-1])) ** POWER
    return float(np.clip(scale, FINEST, COARSEST))
