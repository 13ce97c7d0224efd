"""Radiance pictures (``.hdr``) with the header lines that evalglare reads.

Format: G. Ward, "Real Pixels", Graphics Gems II (1991), and ``ray/src/common/color.c`` of Radiance: a pixel
is three mantissas and one exponent, a scanline is run-length encoded channel by channel.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lelight.scene import FloatArray
from lelight.writing.files import whole

#: Radiance's luminous efficacy of white light in lm/W (``WHTEFFICACY`` in its ``color.h``).
WHITE_EFFICACY = 179.0

#: Widths that the run-length encoding of scanlines can hold; other pictures are stored flat.
_ENCODED_WIDTHS = range(8, 32768)
_LONGEST_RUN = 128
_DARKEST = 1e-32


def write_hdr(path: Path, luminance: NDArray[np.floating], *, view: str) -> None:
    """Write a luminance picture (h, w) in cd/m² as grey radiances ``L / 179`` in W/(sr m²).

    Radiance takes luminance as ``179 (0.265 R + 0.670 G + 0.065 B)``, which gives L back. Values that are
    negative or not finite, such as nan outside a fisheye's disc, are written as 0.

    Parameters
    ----------
    view : the view as Radiance's options, for the ``VIEW=`` line; empty for none
    """
    known = np.nan_to_num(np.asarray(luminance, dtype=np.float64), nan=0, posinf=0, neginf=0)
    grey = np.broadcast_to(known[..., None] / WHITE_EFFICACY, (*known.shape, 3))
    write_radiance(path, grey, view=view)


def write_radiance(path: Path, radiance: FloatArray, *, view: str) -> None:
    """Write radiances (h, w, 3) in W/(sr m²), Radiance's own R, G, B."""
    height, width = radiance.shape[:2]
    lines = [
        "#?RADIANCE",
        "SOFTWARE=lelight",
        *([f"VIEW= {' '.join(view.split())}"] if view else []),
        "EXPOSURE=1.0",
        "FORMAT=32-bit_rle_rgbe",
        "",
        f"-Y {height} +X {width}",
        "",
    ]
    with whole(path) as beside:
        beside.write_bytes("\n".join(lines).encode() + scanlines(shared_exponent(radiance)))


def shared_exponent(radiance: FloatArray) -> NDArray[np.uint8]:
    """Round radiances (..., 3) down to 8-bit mantissas with one exponent, (..., 4) bytes.

    The largest component m 2^e, 0.5 <= m < 1, sets the exponent byte e + 128; readers add half a step.
    """
    largest = radiance.max(axis=-1)
    exponents = np.frexp(largest)[1]
    shown = (largest > _DARKEST)[..., None]
    mantissas = np.ldexp(np.maximum(radiance, 0), 8 - exponents[..., None])
    pixels = np.concatenate([mantissas, exponents[..., None] + 128], axis=-1)
    return np.where(shown, pixels, 0).astype(np.uint8)


def scanlines(pixels: NDArray[np.uint8]) -> bytes:
    """Encode pixels (h, w, 4) scanline by scanline, every run a literal one."""
    height, width = pixels.shape[:2]
    if width not in _ENCODED_WIDTHS:
        return pixels.tobytes()
    start = np.broadcast_to(np.array([2, 2, width >> 8, width & 255], dtype=np.uint8), (height, 4))
    channels = [_literal_runs(pixels[..., channel]) for channel in range(4)]
    return np.concatenate([start, *channels], axis=1).tobytes()


def _literal_runs(channel: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Put a count before each stretch of at most 128 bytes of the rows (h, w)."""
    pieces = []
    for first in range(0, channel.shape[1], _LONGEST_RUN):
        run = channel[:, first : first + _LONGEST_RUN]
        pieces += [np.full((len(run), 1), run.shape[1], dtype=np.uint8), run]
    return np.concatenate(pieces, axis=1)
