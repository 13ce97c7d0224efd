"""Luminaires that a photometric file describes, placed in a scene."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from lelight.photometry.photometry import Photometry
from lelight.scene import FloatArray, PointLuminaire, Spectrum


@dataclass(frozen=True)
class PhotometricLuminaire:
    """A photometric file at a place, turned and dimmed.

    Attributes
    ----------
    position : (3,) float, m, the photometric centre
    axes : (3, 3) float, rows of unit length: direction of the C0 half-plane, of C90, and up; light at γ = 0
        leaves against up. C90 is up x C0, so that C counts anticlockwise seen from above
    factor : float, times the file's intensities: dimming, maintenance, and lamps that depend on tilt
    housing : shell pattern of the materials that do not block this luminaire's own light; empty for none
    path : photometric file as the scene file names it
    maintenance : float, the part of ``factor`` that is maintenance
    spectrum : of the light, None where only its colour is known
    """

    name: str
    position: FloatArray
    axes: FloatArray
    photometry: Photometry
    factor: float = 1.0
    housing: str = ""
    path: str = ""
    maintenance: float = 1.0
    spectrum: Spectrum | None = None

    @property
    def aim(self) -> FloatArray:
        """(3,) float, unit, direction of γ = 0."""
        return np.asarray(-self.axes[2])

    @property
    def intensity(self) -> FloatArray:
        """(3,) float, cd: the largest intensity, as a grey colour."""
        return np.full(3, self.factor * float(self.photometry.candela.max()))

    def direction_angles(self, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """C and γ (k,) in degrees of unit directions (k, 3) in scene axes."""
        x, y, z = np.moveaxis(directions @ self.axes.T, -1, 0)
        return np.degrees(np.arctan2(y, x)) % 360.0, np.degrees(np.arccos(np.clip(-z, -1.0, 1.0)))

    def intensity_toward(self, directions: FloatArray) -> FloatArray:
        """Intensity (k,) in cd along unit directions (k, 3) in scene axes."""
        return np.asarray(self.factor * self.photometry.intensity(*self.direction_angles(directions)))

    def projected_area(self, directions: FloatArray) -> FloatArray:
        """Luminous area (k,) in m² seen against unit directions (k, 3) in which light leaves."""
        return np.asarray(self.photometry.opening.projected_area(*self.direction_angles(directions)))

    def figure(self) -> tuple[FloatArray, FloatArray, bool]:
        """Edges (3,), (3,) in m and scene axes of the opening's largest section, and whether it is round."""
        first, second, round_ = self.photometry.opening.figure()
        return first @ self.axes, second @ self.axes, round_


Luminaire = PointLuminaire | PhotometricLuminaire


def have_direction(luminaires: Iterable[Luminaire]) -> bool:
    """Say whether any of them points somewhere: isotropic points do not."""
    return any(isinstance(lamp, PhotometricLuminaire) for lamp in luminaires)


def placed_axes(aim: FloatArray, c0: FloatArray) -> FloatArray:
    """Axes (3, 3) of a luminaire from the direction it aims at and the one that C0 points to.

    C0 is brought into the plane across the aim.

    Raises
    ------
    ValueError
        where the two are parallel
    """
    up = -_unit(aim)
    across = _unit(c0) - np.dot(_unit(c0), up) * up
    if np.linalg.norm(across) < 1e-6:
        raise ValueError("c0 is parallel to aim")
    first = _unit(across)
    return np.array([first, np.cross(up, first), up])


def tilt_factor(photometry: Photometry, aim: FloatArray) -> float:
    """Factor of lamps that depend on tilt, by the angle of the aim from straight down (LM-63, TILT)."""
    if not len(photometry.tilt):
        return 1.0
    angle = float(np.degrees(np.arccos(np.clip(-_unit(aim)[2], -1.0, 1.0))))
    return float(np.interp(angle, *photometry.tilt.T))


def moved(luminaire: Luminaire, *, name: str, by: FloatArray) -> Luminaire:
    """Copy a luminaire under another name, ``by`` (3,) m away."""
    return replace(luminaire, name=name, position=luminaire.position + by)


def _unit(vector: FloatArray) -> FloatArray:
    scaled = np.asarray(vector, dtype=np.float64) / np.max(np.abs(vector))
    return np.asarray(scaled / np.linalg.norm(scaled))
