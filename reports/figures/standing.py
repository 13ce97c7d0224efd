"""Where values stand within their tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lelight.reports.figures.drawing import ACCENT, FAINT, axes_in, drawing, plain_axes

#: Millimetres: the sheet, the room for names, and the height of a case.
WIDTH, NAMES, ROW, MARGIN = 166.0, 42.0, 4.6, 14.0
#: Standard errors on either side of a value.
COVERAGE_FACTOR = 2.0
FAILED = "#a61b1b"
#: Share of the tolerance at which the axis ends.
REACH = 1.5

#: Difference and standard error, both as shares of the tolerance, and whether the value passes.
Standing = tuple[float, float, bool]


def standing_chart(cases: Mapping[str, Sequence[Standing]]) -> bytes:
    """Draw the values of each case with two standard errors, on an axis where the tolerance is 1."""
    height = ROW * len(cases) + MARGIN

    def paint(figure: Figure) -> None:
        room = WIDTH - NAMES - 4.0
        axes = axes_in(figure, left=NAMES, bottom=MARGIN - 3.0, width=room, height=height - MARGIN)
        plain_axes(axes)
        axes.set(xlim=(-REACH, REACH), ylim=(len(cases) - 0.4, -0.6), xlabel="difference / tolerance")
        axes.set_yticks(range(len(cases)), labels=list(cases))
        axes.tick_params(axis="y", length=0)
        axes.axvline(0.0, color=FAINT, linewidth=0.5)
        for edge in (-1.0, 1.0):
            axes.axvline(edge, color=FAINT, linewidth=0.8, linestyle=":")
        for row, standings in enumerate(cases.values()):
            _row(axes, row, standings)

    return drawing(WIDTH, height, paint=paint)


def _row(axes: Axes, row: int, standings: Sequence[Standing]) -> None:
    """Place the values of a case beside each other; what lies beyond the axis stands at its end."""
    for k, (difference, std_error, passes) in enumerate(standings):
        y = row + 0.5 * ((k + 0.5) / len(standings) - 0.5)
        axes.errorbar(
            min(max(difference, -REACH), REACH),
            y,
            xerr=COVERAGE_FACTOR * std_error,
            color=ACCENT if passes else FAILED,
            marker="o",
            markersize=1.8,
            linewidth=0.6,
        )
