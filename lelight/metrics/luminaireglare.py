"""Photometric luminaires as sources of glare: L = I(C, γ) / A_projected, CIE 117:1995."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lelight.luminaires import PhotometricLuminaire
from lelight.metrics.cie117 import GlareSource, PositionIndex, excluded_source, rated_source
from lelight.metrics.position import guth
from lelight.photometry.opening import LEAST_AREA
from lelight.scene import BoolArray, FloatArray, Observer

#: Parts of each edge of an opening to which rays are sent.
PARTS = 8

#: ``visible(origins (m, 3), targets (m, 3)) -> (m,) bool``, with the luminaire's own housing out of the way.
Visible = Callable[[FloatArray, FloatArray], BoolArray]


def luminaire_source(
    lamp: PhotometricLuminaire,
    observer: Observer,
    visible: Visible,
    *,
    position_index: PositionIndex = guth,
) -> GlareSource:
    """See a luminaire from an eye; excluded ones come with their reason.

    The luminance is that of the whole opening in the eye's direction, the solid angle its projected area over
    the square of the distance, as far as it is not hidden.
    """
    toward = lamp.position - observer.position
    distance = float(np.linalg.norm(toward))
    if distance == 0.0:
        return excluded_source(lamp.name, np.zeros(3), observer, "the eye is within the luminaire")
    direction = toward / distance
    area = float(lamp.projected_area(-direction[None])[0])
    intensity = float(lamp.intensity_toward(-direction[None])[0])
    if lamp.photometry.opening.size == 0 or area <= LEAST_AREA:
        return excluded_source(
            lamp.name, direction, observer, "no luminous opening toward the eye, no luminance"
        )
    if intensity <= 0.0:
        return excluded_source(lamp.name, direction, observer, "sends no light toward the eye")
    targets = opening_points(lamp)
    share = float(np.mean(visible(np.broadcast_to(observer.position, targets.shape), targets)))
    if share == 0.0:
        return excluded_source(lamp.name, direction, observer, "not visible")
    return rated_source(
        lamp.name,
        intensity / area,
        share * area / distance**2,
        direction,
        share,
        share * area,
        observer,
        position_index,
    )


def opening_points(lamp: PhotometricLuminaire) -> FloatArray:
    """Points (64, 3) in m, evenly over the largest section of an opening."""
    first, second, round_ = lamp.figure()
    steps = (np.arange(PARTS) + 0.5) / PARTS
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps))
    if round_:
        radius, turn = 0.5 * np.sqrt(u), 2.0 * np.pi * v
        u, v = radius * np.cos(turn), radius * np.sin(turn)
    else:
        u, v = u - 0.5, v - 0.5
    return np.asarray(lamp.position + u[:, None] * first + v[:, None] * second)
