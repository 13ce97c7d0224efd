"""Made-up scenes with light in them, for the tests of tracing and estimating."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from shapes import Shape, box, scene_of

from lelight.scene import FloatArray, Material, PointLuminaire, Scene

#: Emission that makes the exitance of a surface 1 lm/m².
UNIT_EXITANCE = 1.0 / math.pi


def grey(name: str, diffuse: float, **others) -> Material:
    """A grey material; ``specular`` and ``luminance`` as numbers."""
    colours = {key: np.full(3, others.pop(key)) for key in ("specular", "luminance") if key in others}
    return Material(name, np.full(3, diffuse), **colours, **others)


def lit(*shapes: Shape, materials: list[Material], luminaires: tuple[PointLuminaire, ...] = ()) -> Scene:
    """A scene of one material for each shape."""
    made = scene_of(*shapes, materials=list(range(len(shapes))))
    return replace(made, materials=tuple(materials), luminaires=luminaires)


def furnace(reflectance: float, size: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Scene:
    """A closed box of Lambertian walls that all emit 1 lm/m²: E = 1 / (1 - reflectance) everywhere."""
    return lit(box(size), materials=[grey("walls", reflectance, luminance=UNIT_EXITANCE)])


def panel(
    corner: tuple[float, float, float], u: tuple[float, float, float], v: tuple[float, float, float]
) -> Shape:
    """A parallelogram whose front is the side from which u x v points."""
    first, u_, v_ = np.array(corner, dtype=float), np.array(u, dtype=float), np.array(v, dtype=float)
    return np.array([first, first + u_, first + u_ + v_, first + v_]), np.array([[0, 1, 2], [0, 2, 3]])


def glossy_room(diffuse: float, specular: float, exponent: float) -> Scene:
    """A room 4 x 3 x 2.5 m, all of it glossy, under a luminous panel."""
    ceiling_lamp = panel((1.2, 0.9, 2.4), (0.0, 0.8, 0.0), (1.1, 0.0, 0.0))
    walls = grey("walls", diffuse, specular=specular, exponent=exponent)
    return lit(box((4.0, 3.0, 2.5)), ceiling_lamp, materials=[walls, grey("lamp", 0.5, luminance=100.0)])


def lamp(
    position: tuple[float, float, float], intensity: float = 100.0, name: str = "lamp"
) -> PointLuminaire:
    """A point luminaire of the same intensity in all channels."""
    return PointLuminaire(name, np.array(position, dtype=float), np.full(3, intensity))


def normalised(vectors: FloatArray) -> FloatArray:
    """Unit vectors (..., 3)."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
