"""UGR by direction of view, the line of sight upwards."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lelight.reports.figures.drawing import ACCENT, FAINT, drawing
from lelight.scene import FloatArray

#: Millimetres, and the share of them that is left for the numbers around.
SIDE, MARGIN = 74.0, 0.1
#: Classes of CIE 117, and where the rose begins: lower ratings are all <10.
CLASSES = (10.0, 13.0, 16.0, 19.0, 22.0, 25.0, 28.0)
INNER, OUTER = 7.0, 31.0
LIMIT = "#b3261e"


def glare_rose(turns: FloatArray, ratings: FloatArray, *, limit: float | None) -> bytes:
    """Draw ratings (k,), NaN where no source is in view, against turns (k,) in degrees to the left."""

    def paint(figure: Figure) -> None:
        axes: Any = figure.add_axes((MARGIN, MARGIN, 1.0 - 2 * MARGIN, 1.0 - 2 * MARGIN), projection="polar")
        axes.set_theta_zero_location("N")
        highest = max(OUTER, float(np.nanmax(ratings, initial=0.0)) + 1.0)
        axes.set(ylim=(0.0, highest - INNER))
        rated = np.clip(np.nan_to_num(ratings, nan=INNER), INNER, None) - INNER
        closed = np.append(np.radians(turns), np.radians(turns[0]) + 2.0 * np.pi)
        axes.fill(closed, np.append(rated, rated[0]), color=ACCENT, alpha=0.15, linewidth=0)
        axes.plot(closed, np.append(rated, rated[0]), color=ACCENT, linewidth=0.9, marker="o", markersize=2)
        axes.set_yticks([each - INNER for each in CLASSES], labels=[f"{each:.0f}" for each in CLASSES])
        axes.set_rlabel_position(187.0)
        axes.set_xticks(
            np.radians(np.arange(0, 360, 45)),
            labels=["0°", "45°", "90°", "135°", "180°", "−135°", "−90°", "−45°"],
        )
        axes.grid(color=FAINT, linewidth=0.35, linestyle=":")
        axes.spines["polar"].set_linewidth(0.4)
        if limit is not None and limit > INNER:
            around = np.linspace(0.0, 2.0 * np.pi, 181)
            axes.plot(around, np.full(181, limit - INNER), color=LIMIT, linewidth=0.9, linestyle=(0, (4, 2)))

    return drawing(SIDE, SIDE, paint=paint)
