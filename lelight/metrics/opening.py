"""Luminous openings as an eye sees them: exact solid angles and the cells that sample them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lelight.scene import BoolArray, EmissionSides, FloatArray

#: Cells an opening is divided into, at least, if it has any solid angle.
CELLS = 64
#: Quartering ends here however near the eye is: edges are then 2^32 times shorter than the triangle's.
_ROUNDS = 32


@dataclass(frozen=True)
class EmitterPatch:
    """One luminous opening: a connected patch of emitting triangles.

    Attributes
    ----------
    corners : (k, 3, 3) float, m; triangle, corner, coordinate; the front sees them anticlockwise
    luminance : float, cd/m², the same in every direction
    sides : which sides emit
    """

    name: str
    corners: FloatArray
    luminance: float
    sides: EmissionSides = "front"

    def __post_init__(self) -> None:
        """Refuse what has no luminance or no shape."""
        if not (np.isfinite(self.luminance) and self.luminance >= 0):
            raise ValueError(f"luminance must be finite and not negative, found {self.luminance}")
        if np.ndim(self.corners) != 3 or np.shape(self.corners)[1:] != (3, 3):
            raise ValueError(f"corners must be (k, 3, 3), found {np.shape(self.corners)}")


@dataclass(frozen=True)
class Cells:
    """The part of an opening that shines into the view hemisphere, cut into small triangles.

    Attributes
    ----------
    centres : (m, 3) float, m
    solid_angles : (m,) float, sr, exact, positive
    """

    centres: FloatArray
    solid_angles: FloatArray

    def __getitem__(self, chosen: BoolArray) -> Cells:
        """Keep the cells that are chosen (m,)."""
        return Cells(self.centres[chosen], self.solid_angles[chosen])

    @property
    def solid_angle(self) -> float:
        """All cells together, sr."""
        return float(self.solid_angles.sum())


def solid_angles(corners: FloatArray, eye: FloatArray) -> FloatArray:
    """Signed solid angles of triangles seen from a point, positive where the point is on the front.

    ``tan(ω/2) = r₁·(r₂×r₃) / (r₁r₂r₃ + (r₁·r₂)r₃ + (r₁·r₃)r₂ + (r₂·r₃)r₁)`` (van Oosterom & Strackee 1983,
    IEEE Trans. Biomed. Eng. 30(2), equation 8). A triangle seen edge on has none.

    Parameters
    ----------
    corners : (n, 3, 3) float, m
    eye : (3,) float, m

    Returns
    -------
    (n,) float, sr
    """
    first, second, third = np.moveaxis(corners - eye, 1, 0)
    # Seen from the front, anticlockwise corners have a negative triple product.
    volume = -_dot(first, np.cross(second, third))
    lengths = [np.linalg.norm(side, axis=-1) for side in (first, second, third)]
    cosines = (
        lengths[0] * lengths[1] * lengths[2]
        + _dot(first, second) * lengths[2]
        + _dot(first, third) * lengths[1]
        + _dot(second, third) * lengths[0]
    )
    return np.where(volume == 0, 0.0, 2 * np.arctan2(volume, cosines))


def _dot(left: FloatArray, right: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", left, right))


def cells(patch: EmitterPatch, eye: FloatArray, *, forward: FloatArray) -> Cells:
    """Cut the luminous part ahead of the eye into cells of at most 1/64 of its solid angle.

    Parameters
    ----------
    eye : (3,) float, m
    forward : (3,) float, unit; only what lies in this half-space counts
    """
    corners = _ahead(np.asarray(patch.corners, dtype=np.float64), eye, forward)
    signed = solid_angles(corners, eye)
    shining = signed != 0 if patch.sides == "both" else signed > 0
    corners = _refined(corners[shining], eye)
    return Cells(corners.mean(axis=1), np.abs(solid_angles(corners, eye)))


def _refined(corners: FloatArray, eye: FloatArray) -> FloatArray:
    for _ in range(_ROUNDS):
        sizes = np.abs(solid_angles(corners, eye))
        coarse = sizes > sizes.sum() / CELLS
        if not coarse.any():
            break
        corners = np.concatenate([corners[~coarse], _quarters(corners[coarse])])
    return corners


def _quarters(corners: FloatArray) -> FloatArray:
    """Cut triangles (n, 3, 3) at the middles of their edges, (4 n, 3, 3), with their winding."""
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(part, axis=1) for part in parts])


def _ahead(corners: FloatArray, eye: FloatArray, forward: FloatArray) -> FloatArray:
    """Clip triangles (n, 3, 3) at the plane through the eye across the sight, keeping their winding."""
    depths = (corners - eye) @ forward
    count = (depths > 0).sum(axis=1)
    tips, tip_depths = _lone_first(corners[count == 1], depths[count == 1], sign=1.0)
    trunks, trunk_depths = _lone_first(corners[count == 2], depths[count == 2], sign=-1.0)
    near, far = _crossings(trunks, trunk_depths)
    return np.concatenate(
        [
            corners[count == 3],
            np.stack([tips[:, 0], *_crossings(tips, tip_depths)], axis=1),
            np.stack([near, trunks[:, 1], trunks[:, 2]], axis=1),
            np.stack([near, trunks[:, 2], far], axis=1),
        ]
    )


def _lone_first(corners: FloatArray, depths: FloatArray, *, sign: float) -> tuple[FloatArray, FloatArray]:
    """Rotate the corners so that the one alone on its side of the plane (the extreme depth) comes first."""
    order = (np.argmax(sign * depths, axis=1)[:, None] + np.arange(3)) % 3
    return (
        np.take_along_axis(corners, order[:, :, None], axis=1),
        np.take_along_axis(depths, order, axis=1),
    )


def _crossings(corners: FloatArray, depths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points where the edges from the first corner to the second and to the third meet the plane."""
    share = depths[:, :1] / (depths[:, :1] - depths[:, 1:])
    points = corners[:, :1] + share[:, :, None] * (corners[:, 1:] - corners[:, :1])
    return points[:, 0], points[:, 1]
