"""Arriving light as nodes need it for angular detail: by receiver, mirrored, in their local frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from lelight.compilation import COMPILED
from lelight.estimate.local import Arrivals
from lelight.receivers import Receivers
from lelight.scene import FloatArray, IntArray


@dataclass(frozen=True)
class ArrivingLight:
    """k arrivals at r receivers, quantity by quantity in memory; receiver i owns ``offsets[i]:offsets[i + 1]``.

    Attributes
    ----------
    offsets : (r + 1,) int
    mirrored : x, y and z (k,) float of (-x, -y, z), the mirror image of where the light comes from, local frame
    irradiance : (C, k) float, lx
    """

    offsets: IntArray
    mirrored: tuple[FloatArray, FloatArray, FloatArray]
    irradiance: FloatArray


def arriving(receivers: Receivers, arrivals: tuple[Arrivals, ...]) -> ArrivingLight:
    """Sort arrivals by receiver, those of each in their order."""
    owner = [a.receiver for a in arrivals]
    counts = sum(
        (np.bincount(part, minlength=len(receivers)) for part in owner), np.zeros(len(receivers), int)
    )
    offsets = np.concatenate([[0], np.cumsum(counts)])
    total, channels = int(offsets[-1]), arrivals[0].radiance_solid_angle.shape[1]
    light = ArrivingLight(
        offsets, (np.empty(total), np.empty(total), np.empty(total)), np.empty((channels, total))
    )
    frames_y = np.cross(receivers.normals, receivers.frames_x)
    free = offsets[:-1].copy()
    for part in arrivals:
        _place(
            part.receiver,
            part.directions,
            part.radiance_solid_angle,
            receivers.frames_x,
            frames_y,
            receivers.normals,
            free,
            light.mirrored,
            light.irradiance,
        )
    return light


@njit(**COMPILED)
def _place(
    receiver: IntArray,
    directions: FloatArray,
    radiance_solid_angle: FloatArray,
    frames_x: FloatArray,
    frames_y: FloatArray,
    normals: FloatArray,
    free: IntArray,
    mirrored: tuple[FloatArray, FloatArray, FloatArray],
    irradiance: FloatArray,
) -> None:
    """Write each arrival to the next free place of its receiver."""
    for k in range(len(receiver)):
        r = receiver[k]
        place = free[r]
        free[r] += 1
        x, y, z = 0.0, 0.0, 0.0
        for axis in range(3):
            x += directions[k, axis] * frames_x[r, axis]
            y += directions[k, axis] * frames_y[r, axis]
            z += directions[k, axis] * normals[r, axis]
        mirrored[0][place], mirrored[1][place], mirrored[2][place] = -x, -y, z
        for c in range(len(irradiance)):
            irradiance[c, place] = radiance_solid_angle[k, c] * max(z, 0.0)
