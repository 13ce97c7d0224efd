"""Local frames of nodes: z along the normal, x along the stored axis, y = z × x."""

from __future__ import annotations

import numpy as np

from lelight.scene import FloatArray


def to_local(vectors: FloatArray, normals: FloatArray, frames_x: FloatArray) -> FloatArray:
    """Components of scene vectors along the axes of local frames.

    Parameters
    ----------
    vectors : (..., 3) float, scene axes
    normals, frames_x : (..., 3) float, unit, perpendicular to each other; z and x axes of the frames

    Returns
    -------
    (..., 3) float, local axes; the leading shapes are broadcast
    """
    axes = _axes(normals, frames_x)
    return np.asarray(np.einsum("...ij,...j->...i", axes, vectors))


def to_scene(vectors: FloatArray, normals: FloatArray, frames_x: FloatArray) -> FloatArray:
    """Scene vectors of local components: the inverse of `to_local`.

    Parameters
    ----------
    vectors : (..., 3) float, local axes
    normals, frames_x : (..., 3) float, unit, perpendicular to each other; z and x axes of the frames

    Returns
    -------
    (..., 3) float, scene axes; the leading shapes are broadcast
    """
    axes = _axes(normals, frames_x)
    return np.asarray(np.einsum("...ij,...i->...j", axes, vectors))


def mirrored(directions: FloatArray) -> FloatArray:
    """Mirror images (-x, -y, z) of local directions (..., 3) about the normal.

    Light that arrives from w leaves a mirror towards this direction; both point away from the surface.
    """
    return np.asarray(directions * np.array([-1.0, -1.0, 1.0]))


def _axes(normals: FloatArray, frames_x: FloatArray) -> FloatArray:
    """Rows x, y, z of the frames, (..., 3, 3)."""
    x, z = np.broadcast_arrays(frames_x, normals)
    return np.stack([x, np.cross(z, x), z], axis=-2)
