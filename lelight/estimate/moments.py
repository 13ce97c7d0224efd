"""Sums of arriving light: illuminance, scalar illuminance, light vector, cylindrical illuminance.

Each arrival is a direction w toward the light and its radiance times solid angle, L dw. A row of the moments
is an integral over directions: plane (L cos+ dw), scalar (L dw / 4), vector (L w dw), cylindrical (L sin dw /
pi, the angle taken from the scene's vertical).
"""

from __future__ import annotations

import math

from numba import njit

from lelight.compilation import LEAF
from lelight.receivers import CYLINDRICAL, ILLUMINANCE, SCALAR, VECTOR
from lelight.scene import FloatArray, IntArray


@njit(**LEAF)
def add_arrival(
    moments: FloatArray,
    channel: int,
    wx: float,
    wy: float,
    wz: float,
    cos_theta: float,
    radiance_solid_angle: float,
) -> None:
    """Add one arrival to a receiver's moments (6, C).

    Parameters
    ----------
    wx, wy, wz : unit direction toward the light, scene axes
    cos_theta : cosine at the receiver's normal; negative behind a plane in space
    radiance_solid_angle : float, cd/m² sr
    """
    if cos_theta > 0.0:
        moments[ILLUMINANCE, channel] += radiance_solid_angle * cos_theta
    moments[SCALAR, channel] += 0.25 * radiance_solid_angle
    moments[VECTOR, channel] += radiance_solid_angle * wx
    moments[VECTOR + 1, channel] += radiance_solid_angle * wy
    moments[VECTOR + 2, channel] += radiance_solid_angle * wz
    moments[CYLINDRICAL, channel] += radiance_solid_angle * math.sqrt(max(0.0, 1.0 - wz * wz)) / math.pi


@njit(**LEAF)
def add_arrivals(
    moments: FloatArray,
    receiver: IntArray,
    directions: FloatArray,
    normals: FloatArray,
    radiance_solid_angle: FloatArray,
) -> None:
    """Add arrivals (k,) to the moments (r, 6, C) of their receivers, in order.

    Parameters
    ----------
    receiver : (k,) int
    directions : (k, 3) float, toward the light
    normals : (r, 3) float
    radiance_solid_angle : (k, C) float
    """
    for k in range(len(receiver)):
        r = receiver[k]
        wx, wy, wz = directions[k]
        cos_theta = wx * normals[r, 0] + wy * normals[r, 1] + wz * normals[r, 2]
        for c in range(moments.shape[2]):
            if radiance_solid_angle[k, c] != 0.0:
                add_arrival(moments[r], c, wx, wy, wz, cos_theta, radiance_solid_angle[k, c])
