"""A room with Phong exponents 8, 64 and 256 at once, for pictures; grey, so that Mitsuba can be asked, too."""

from __future__ import annotations

import numpy as np
from rooms import grey, lit, panel
from shapes import Shape, box

from lelight.scene import FloatArray, Scene

SIZE = (4.0, 3.0, 2.5)
#: Where to look from and to, m.
EYE, FORWARD = np.array([0.6, 0.8, 1.2]), np.array([1.0, 0.35, -0.15])


def three_glosses() -> Scene:
    """Floor of exponent 256, walls of 64, ceiling of 8, a Lambertian box on the floor, a panel under the ceiling."""
    vertices, faces = box(SIZE)
    heights = vertices[faces][:, :, 2]
    on_floor, on_ceiling = np.all(heights == 0.0, axis=1), np.all(heights == SIZE[2], axis=1)
    shapes = [(vertices, faces[part]) for part in (on_floor, ~on_floor & ~on_ceiling, on_ceiling)]
    materials = [
        grey("floor", 0.25, specular=0.3, exponent=256.0),
        grey("walls", 0.4, specular=0.2, exponent=64.0),
        grey("ceiling", 0.6, specular=0.15, exponent=8.0),
        grey("box", 0.5),
        grey("lamp", 0.5, luminance=1000.0),
    ]
    lamp = panel((1.5, 1.0, 2.3), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    return lit(*shapes, block((2.3, 1.6, 0.0), (0.7, 0.7, 0.8)), lamp, materials=materials)


def block(corner: tuple[float, float, float], size: tuple[float, float, float]) -> Shape:
    """A box seen from outside, without a bottom."""
    vertices, faces = box(size)
    bottom = np.all(vertices[faces][:, :, 2] == 0.0, axis=1)
    return vertices + np.array(corner), faces[~bottom][:, ::-1]


def drawn_directions(count: int, *, seed: int = 3) -> tuple[FloatArray, FloatArray]:
    """Eyes and unit directions (count, 3), all over the sphere around the one eye."""
    way = np.random.default_rng(seed).normal(size=(count, 3))
    return np.tile(EYE, (count, 1)), way / np.linalg.norm(way, axis=1, keepdims=True)
