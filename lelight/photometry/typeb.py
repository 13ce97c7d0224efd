"""Type B photometry, whose planes share a horizontal axis, brought to C and γ.

H is counted from the vertical plane through the beam axis, V is the turn about the horizontal axis: with the
beam along z and the axis along x a direction is (sin H, cos H sin V, cos H cos V) (LM-75-01). The beam axis
becomes γ = 0, the horizontal axis C0 to C180, and positive V C90.
"""

from __future__ import annotations

import numpy as np

from lelight.scene import FloatArray

#: Finest and coarsest steps of the new table in degrees.
FINEST, COARSEST = 0.25, 5.0
#: Step of the C planes in degrees.
C_STEP = 5.0


def complete(horizontal: FloatArray, candela: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mirror a table (n_h, n_v) whose horizontal angles start at 0."""
    if horizontal[0] < -1e-6 or len(horizontal) == 1:
        return horizontal, candela
    inner = horizontal > 1e-6
    return (
        np.concatenate([-horizontal[inner][::-1], horizontal]),
        np.concatenate([candela[inner][::-1], candela]),
    )


def to_c_gamma(
    horizontal: FloatArray, vertical: FloatArray, candela: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Resample type B intensities, bilinear in H and V.

    Parameters
    ----------
    horizontal : (n_h,) float, degrees, -90 to 90 at most, ascending
    vertical : (n_v,) float, degrees, ascending
    candela : (n_h, n_v) float

    Returns
    -------
    c (72,), gamma (n_g,) in degrees and candela (72, n_g)
    """
    from scipy.interpolate import RegularGridInterpolator

    step = _step(horizontal, vertical)
    c = np.arange(0.0, 360.0, C_STEP)
    largest = 180.0 if np.abs(vertical).max() > 90.0 + 1e-6 else 90.0
    gamma = np.linspace(0.0, largest, round(largest / step) + 1)
    turn, fall = np.radians(c)[:, None], np.radians(gamma)
    x, y, z = np.sin(fall) * np.cos(turn), np.sin(fall) * np.sin(turn), np.cos(fall) + 0.0 * turn
    h = np.degrees(np.arcsin(np.clip(x, -1.0, 1.0)))
    v = np.degrees(np.arctan2(y, z))
    # At the poles of the axis V is undefined; any plane holds the value there.
    v = np.where(np.abs(np.abs(h) - 90.0) < 1e-6, np.clip(0.0, vertical[0], vertical[-1]), v)
    table, h_nodes = (candela, horizontal) if len(horizontal) > 1 else _constant(horizontal, candela)
    if len(vertical) == 1:
        vertical, table = np.array([-90.0, 90.0]), np.repeat(table, 2, axis=1)
    found = RegularGridInterpolator((h_nodes, vertical), table, bounds_error=False, fill_value=0.0)
    return c, gamma, np.asarray(found(np.stack([np.round(h, 9), np.round(v, 9)], axis=-1)))


def _constant(horizontal: FloatArray, candela: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Let a single plane stand for all."""
    return np.repeat(candela, 2, axis=0), np.array([-90.0, 90.0])


def _step(horizontal: FloatArray, vertical: FloatArray) -> float:
    """Step in γ as fine as the finest of the file's own."""
    steps = np.concatenate([np.diff(horizontal), np.diff(vertical), [COARSEST]])
    finest = float(np.clip(steps.min(), FINEST, COARSEST))
    return 90.0 / max(1, round(90.0 / finest))
