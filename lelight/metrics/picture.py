"""Glare from a luminance picture: the second opinion beside the rating from known emitters.

Pixels above a threshold form sources; each has the mean luminance, the solid angle and the centroid of its
pixels. Rules and defaults are those that evalglare 3.05 is documented and observed to use: threshold
2000 cd/m², spots merged over gaps up to 0.1 rad, peaks above 50 000 cd/m² a source of their own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lelight.metrics.brightspots import label_spots
from lelight.metrics.cie117 import ugr_of_sum
from lelight.metrics.daylight_glare import View
from lelight.metrics.position import position_index, sight_coordinates, sight_frame
from lelight.scene import BoolArray, FloatArray, IntArray, Observer

#: cd/m²; brighter pixels are a source of their own within the source around them.
PEAK = 50_000.0
#: rad; wider gaps part spots, and half as wide ones the peaks.
MERGING_GAP = 0.1


@dataclass(frozen=True)
class PictureSource:
    """A bright spot: mean luminance (cd/m²), solid angle (sr), unit direction (3,), position index."""

    luminance: float
    solid_angle: float
    direction: FloatArray
    position_index: float

    @property
    def glare(self) -> float:
        """Its term ``L² ω / p²``."""
        return self.luminance**2 * self.solid_angle / self.position_index**2


@dataclass(frozen=True)
class PictureGlare:
    """Glare ratings of a picture.

    Attributes
    ----------
    ugr : None without a source or without any light beside the sources
    dgp : daylight glare probability, 0 to 1
    vertical_illuminance : lx, on the plane across the line of sight
    background : cd/m², the illuminance without the sources, over π
    threshold : cd/m², above which a pixel belongs to a source
    covered : share of the view hemisphere that the picture holds; less than 1 leaves light out
    view : the sums that further ratings are made of
    labels : (h, w) int, number of the source from 1 on that a pixel belongs to, 0 for none
    """

    ugr: float | None
    dgp: float
    vertical_illuminance: float
    background: float
    sources: tuple[PictureSource, ...]
    threshold: float
    covered: float
    view: View
    labels: IntArray


def picture_glare(
    luminance: FloatArray,
    solid_angles: FloatArray,
    directions: FloatArray,
    observer: Observer,
    *,
    threshold: float = 2000.0,
    gap: float = MERGING_GAP,
    peak: float = PEAK,
) -> PictureGlare:
    """Rate a luminance picture.

    Parameters
    ----------
    luminance : (h, w) float, cd/m²
    solid_angles : (h, w) float, sr, exact; zero outside the view, where nothing else is looked at
    directions : (h, w, 3) float, unit, from the eye, scene axes
    threshold : float, cd/m²; see `mean_luminance` for multiples of the mean
    gap : float, rad; spots are merged over gaps up to this one, peaks over half of it
    peak : float, cd/m²; what is brighter is a source of its own, infinity for none
    """
    cos_theta = directions @ sight_frame(observer)[0]
    inside = (solid_angles > 0) & (cos_theta > 0)
    _check(luminance[inside], threshold)
    lit = np.where(inside, luminance, 0.0)
    weights = np.where(inside, solid_angles, 0.0)
    labels = _label(lit, directions, threshold, gap, peak)
    sources = _sources(labels, lit, weights, directions=directions, observer=observer)
    illuminance = lit * weights * np.where(inside, cos_theta, 0.0)
    background = float(illuminance[labels == 0].sum()) / math.pi
    total = math.fsum(source.glare for source in sources)
    rating = ugr_of_sum(total, background)
    vertical_illuminance = float(illuminance.sum())
    mean = float(np.sum(lit * weights) / max(float(weights.sum()), np.finfo(float).tiny))
    return PictureGlare(
        ugr=rating if math.isfinite(rating) else None,
        dgp=daylight_glare_probability(total, vertical_illuminance),
        vertical_illuminance=vertical_illuminance,
        background=background,
        sources=sources,
        threshold=threshold,
        covered=min(float(weights.sum()) / (2 * math.pi), 1.0),
        view=_view(sources, observer, vertical_illuminance, background, mean),
        labels=labels,
    )


def _view(
    sources: tuple[PictureSource, ...], observer: Observer, vertical: float, background: float, mean: float
) -> View:
    """Gather what further ratings need."""
    forward = sight_frame(observer)[0]
    cosines = np.array([float(source.direction @ forward) for source in sources])
    return View(
        luminance=np.array([source.luminance for source in sources]),
        solid_angle=np.array([source.solid_angle for source in sources]),
        position=np.array([source.position_index for source in sources]),
        theta=np.arccos(np.clip(cosines, -1, 1)),
        vertical=vertical,
        direct=vertical - math.pi * background,
        background=background,
        mean=mean,
    )


def mean_luminance(luminance: FloatArray, solid_angles: FloatArray) -> float:
    """Mean by solid angle, cd/m²; 5 to 7 times it is the usual relative threshold (Radiance findglare: 7)."""
    inside = solid_angles > 0
    return float(np.average(luminance[inside], weights=solid_angles[inside]))


def daylight_glare_probability(total: float, vertical_illuminance: float) -> float:
    """DGP of a glare sum ``sum L² ω / p²`` and the illuminance at the eye (lx), at most 1.

    ``5.87·10⁻⁵ E_v + 0.092 log10(1 + sum L² ω / (E_v^1.87 p²)) + 0.159`` (Wienold & Christoffersen 2006,
    Energy and Buildings 38, with the digits that evalglare uses; the paper prints 0.0918 and 0.16). Made for
    E_v of 380 lx and more and values of 0.2 to 0.8; the low-light correction is left off.
    """
    contrast = total / vertical_illuminance**1.87 if total > 0 else 0.0
    return min(5.87e-5 * vertical_illuminance + 0.092 * math.log10(1 + contrast) + 0.159, 1.0)


def _check(luminance: FloatArray, threshold: float) -> None:
    if not (math.isfinite(threshold) and threshold > 0):
        raise ValueError(f"threshold must be a positive luminance in cd/m², found {threshold}")
    if not np.all(np.isfinite(luminance) & (luminance >= 0)):
        raise ValueError("luminance must be finite and not negative wherever solid_angles is positive")


def _label(
    luminance: FloatArray, directions: FloatArray, threshold: float, gap: float, brightest: float
) -> IntArray:
    """Give each spot its number, then each peak within them."""
    bright = luminance > threshold
    peak: BoolArray = bright & (luminance > brightest)
    labels, count = label_spots(bright & ~peak, directions, gap=gap)
    peaks, _ = label_spots(peak, directions, gap=gap / 2)
    return np.where(peaks > 0, peaks + count, labels)


def _sources(
    labels: IntArray,
    luminance: FloatArray,
    weights: FloatArray,
    *,
    directions: FloatArray,
    observer: Observer,
) -> tuple[PictureSource, ...]:
    chosen = labels > 0
    spots, omega = labels[chosen] - 1, weights[chosen]
    light = luminance[chosen] * omega

    def summed(parts: FloatArray) -> FloatArray:
        return np.bincount(spots, weights=parts).astype(np.float64)

    solid_angles = summed(omega)
    means = summed(light) / solid_angles
    places = _equiangular(sight_coordinates(directions[chosen], observer))
    means_of_places = np.stack([summed(light * part) for part in places.T], axis=1) / summed(light)[:, None]
    centroids = _direction_at(means_of_places) @ sight_frame(observer)
    indices = position_index(sight_coordinates(centroids, observer))
    return tuple(
        PictureSource(float(mean), float(solid_angle), centroid, float(index))
        for mean, solid_angle, centroid, index in zip(means, solid_angles, centroids, indices, strict=True)
    )


def _equiangular(coordinates: FloatArray) -> FloatArray:
    """Places (n, 2) in an equi-angular picture, rad to the right and up, of unit directions (n, 3), R, T, H.

    Centroids are taken there, as evalglare does: for a wide source they lie nearer to the line of sight than
    the mean of directions, by half a degree for a source of 0.3 sr at 48 degrees.
    """
    theta = np.arccos(np.clip(coordinates[:, 0], -1, 1))
    return np.asarray(coordinates[:, 1:] / np.sinc(theta / np.pi)[:, None])


def _direction_at(places: FloatArray) -> FloatArray:
    """Find unit directions (n, 3), R, T, H, at places (n, 2) of an equi-angular picture."""
    theta = np.linalg.norm(places, axis=1)
    return np.column_stack([np.cos(theta), places * np.sinc(theta / np.pi)[:, None]])
