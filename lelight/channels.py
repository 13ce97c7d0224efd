"""Channels: what the last axis of every photometric array stands for.

One channel is grey, three are linear Rec. 709 components, eight or more are spectral bands. A band's value is
the luminous quantity of the band times the number of bands, so that the luminance is the mean of all bands:
every band then counts the same in any sum, however little of it the eye sees.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lelight.scene import LUMINANCE_WEIGHTS, FloatArray

#: Fewer channels than these are no spectrum; between colour and spectrum a number of channels means nothing.
LEAST_BANDS = 8


def luminance_weighted(channels: ArrayLike, *, weights: ArrayLike | None = None) -> FloatArray:
    """Photometric quantity of values in C channels: their sum weighted by what each adds to luminance.

    Parameters
    ----------
    channels : (..., C) float
    weights : (C,) float; default 1 for one channel, Rec. 709's (ITU-R BT.709-6, item 3.2) for three, 1/C for
        spectral bands

    Returns
    -------
    (...) float
    """
    values = np.asarray(channels, dtype=np.float64)
    # Not BLAS, whose threads and blocks would make the last bits depend on cores and on how many values there are.
    return np.asarray(np.einsum("...c,c->...", values, _weights(values.shape[-1], weights)))


def is_spectral(count: int) -> bool:
    """Say whether this many channels are spectral bands."""
    return count >= LEAST_BANDS


def channel_suffixes(count: int) -> tuple[str, ...]:
    """Name the endings that tell channels' arrays apart in a file: none, ``_r _g _b``, or ``_1 _2 ...``."""
    named = {1: ("",), 3: ("_r", "_g", "_b")}
    return named.get(count) or tuple(f"_{number}" for number in range(1, count + 1))


def _weights(count: int, given: ArrayLike | None) -> FloatArray:
    if given is not None:
        weights = np.asarray(given, dtype=np.float64)
    elif count in (1, 3):
        weights = np.ones(1) if count == 1 else LUMINANCE_WEIGHTS
    elif is_spectral(count):
        weights = np.full(count, 1.0 / count)
    else:
        raise ValueError(f"weights: {count} channels have no default luminance weights")
    if weights.shape != (count,):
        raise ValueError(f"weights: shape {weights.shape}, expected ({count},)")
    return weights


def luminance_weights(count: int) -> FloatArray:
    """Weights (C,) that turn C channels into one luminance: 1 for grey, Rec. 709's for RGB, 1/C for bands."""
    return _weights(count, None)


def channel_matrix(count: int) -> FloatArray:
    """Matrix (3, C) that turns linear Rec. 709 components into the channels carried.

    One channel is the luminance of the colour, three are the components themselves. Bands take the component
    in whose range they lie (blue below 490 nm, green, red from 580 nm): a rough colour, an exact grey.
    """
    if count == 1:
        return LUMINANCE_WEIGHTS[:, None]
    if count == len(LUMINANCE_WEIGHTS):
        return np.eye(count)
    if is_spectral(count):
        return _component_of_bands(count)
    raise ValueError(f"count: {count} channels cannot be made from three colour components")


def _component_of_bands(count: int) -> FloatArray:
    """Matrix (3, C) with a single one in each column."""
    from lelight.spectral.bands import BLUE_GREEN, GREEN_RED, band_centres

    component = 2 - np.digitize(band_centres(count), [BLUE_GREEN, GREEN_RED])
    return np.asarray(np.eye(3)[:, component])
