"""Position index: how much less a source disturbs, the farther it lies from the line of sight.

Sight coordinates (R, T, H) run along the line of sight, to its right and up. Above the line of sight the
index is Guth's, as closed form or as the table of CIE 117:1995; below it the form of CIE 2010 after Iwata
and Kikuchi, as public glare programs use it (not verified against the CIE text).
"""

from __future__ import annotations

import numpy as np

from lelight.metrics.guth_table import POSITION_INDEX, STEP
from lelight.scene import BoolArray, FloatArray, IntArray, Observer

#: Cap on the index in pictures, the largest entry of the table in its last columns.
LARGEST_INDEX = 16.0


def sight_frame(observer: Observer) -> FloatArray:
    """Rows (3, 3): unit vectors along the line of sight, to its right and up.

    Up leans as far towards +z as the line of sight allows; for a vertical one it leans towards +y.
    """
    forward = observer.direction / np.linalg.norm(observer.direction)
    upright = np.array([0.0, 0.0, 1.0] if abs(forward[2]) < 1 - 1e-9 else [0.0, 1.0, 0.0])
    right = np.cross(forward, upright)
    right /= np.linalg.norm(right)
    return np.stack([forward, right, np.cross(right, forward)])


def sight_coordinates(vectors: FloatArray, observer: Observer) -> FloatArray:
    """Express vectors (..., 3) from the eye, in scene axes, as (R, T, H) of the same length."""
    return np.asarray(vectors @ sight_frame(observer).T)


def table_ratios(coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """T/R and H/R, each (...); not finite behind the eye's plane (R <= 0) or on it."""
    r, t, h = np.moveaxis(coordinates, -1, 0)
    ahead = r > 0
    distance = np.where(ahead, r, 1.0)
    return np.where(ahead, np.abs(t) / distance, np.inf), np.where(ahead, h / distance, np.inf)


def guth(coordinates: FloatArray) -> FloatArray:
    """Guth's index in closed form, for the half field above the line of sight.

    ``p = exp[(35.2 - 0.31889 α - 1.22 e^(-2α/9)) 10⁻³ β + (21 + 0.26667 α - 0.002963 α²) 10⁻⁵ β²]``, α in
    degrees from the vertical, β in degrees from the line of sight (IES Lighting Handbook, as quoted by
    Wienold & Christoffersen 2006, Energy and Buildings 38). It lies within -10 % and +11 % of the table of
    CIE 117.

    Parameters
    ----------
    coordinates : (..., 3) float, R, T, H in any one unit

    Returns
    -------
    (...) float, 1 on the line of sight
    """
    alpha, beta = _sight_angles(coordinates)
    linear = 35.2 - 0.31889 * alpha - 1.22 * np.exp(-2 * alpha / 9)
    square = 21 + 0.26667 * alpha - 0.002963 * alpha**2
    return np.asarray(np.exp(linear * 1e-3 * beta + square * 1e-5 * beta**2))


def below_line_of_sight(coordinates: FloatArray) -> FloatArray:
    """Index (...) of sources below the line of sight, from coordinates (..., 3).

    ``p = exp(6.49·10⁻³ β' + 21·10⁻⁵ β'²)``, ``tan β' = tan β sqrt(1 + 0.3225 cos² τ)``, β' in degrees, τ the
    angle from up. It does not join Guth's form at the horizon. From memory of CIE 2010 by way of public
    programs; not verified against the CIE text.
    """
    r, t, h = np.moveaxis(coordinates, -1, 0)
    # sin β sqrt(1 + 0.3225 cos² τ) is the distance from the axis, its height stretched by 1.15.
    beta = np.degrees(np.arctan2(np.sqrt(t**2 + (1.15 * h) ** 2), r))
    return np.asarray(np.exp(6.49e-3 * beta + 21e-5 * beta**2))


def position_index(coordinates: FloatArray) -> FloatArray:
    """Index (...) over the whole field from (..., 3), capped at 16: Guth above, CIE 2010 below."""
    above = coordinates[..., 2] >= 0
    index = np.where(above, guth(coordinates), below_line_of_sight(coordinates))
    return np.minimum(index, LARGEST_INDEX)


def guth_table(coordinates: FloatArray) -> FloatArray:
    """Index of CIE 117:1995, table 4.1, between its entries bilinear in T/R and H/R.

    Parameters
    ----------
    coordinates : (..., 3) float, R, T, H in any one unit

    Returns
    -------
    (...) float, NaN outside the table: behind, below, T/R > 3, H/R > 1.9, or next to a blank entry
    """
    t_over_r, h_over_r = table_ratios(coordinates)
    row, row_weight = _place(t_over_r, POSITION_INDEX.shape[0])
    column, column_weight = _place(h_over_r, POSITION_INDEX.shape[1])
    index = np.zeros(np.shape(t_over_r))
    for down, weight_t in ((0, 1 - row_weight), (1, row_weight)):
        for right, weight_h in ((0, 1 - column_weight), (1, column_weight)):
            weight = weight_t * weight_h
            # A blank neighbour without weight must not blank the point.
            index += np.where(weight == 0, 0.0, weight * POSITION_INDEX[row + down, column + right])
    return index


def inside_table(coordinates: FloatArray) -> BoolArray:
    """Where (...) the table of CIE 117 has an index: the field in which a source counts as glare."""
    return np.isfinite(guth_table(coordinates))


def _place(ratios: FloatArray, entries: int) -> tuple[IntArray, FloatArray]:
    """Lower table entry and the weight of its successor; the weight is NaN outside the table."""
    # Rounding keeps a ratio that is an entry but for the last bits, such as 0.3 / 0.1, on that entry.
    steps = np.round(ratios / STEP, 9)
    inside = (steps >= 0) & (steps <= entries - 1)
    steps = np.where(inside, steps, 0.0)
    lower = np.minimum(steps.astype(np.int64), entries - 2)
    return lower, np.where(inside, steps - lower, np.nan)


def _sight_angles(coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angle from the vertical and from the line of sight, degrees."""
    r, t, h = np.moveaxis(coordinates, -1, 0)
    return np.degrees(np.arctan2(np.abs(t), h)), np.degrees(np.arctan2(np.hypot(t, h), r))
