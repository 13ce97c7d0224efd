"""Surfaces made in code, put together into scenes, and single points at which illuminance is measured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lelight.scene import FloatArray, IntArray, Material, MeasuringPlane, PointLuminaire, Scene

Vector = Sequence[float] | FloatArray

#: m; a plane of this edge has a single grid point, in its middle.
PROBE_EDGE = 1e-3


@dataclass(frozen=True)
class Solid:
    """Triangles (n_t, 3) over vertices (n_v, 3), fronts anticlockwise, all of one material."""

    vertices: FloatArray
    triangles: IntArray
    material: Material


def matt(name: str, reflectance: float, *, luminance: float = 0.0) -> Material:
    """Make a grey Lambertian material; ``luminance`` in cd/m², sent out by the front."""
    return Material(name, np.full(3, reflectance), luminance=np.full(3, luminance))


def glossy(name: str, *, diffuse: float, specular: float, exponent: float) -> Material:
    """Make a grey material with a modified Phong lobe."""
    return Material(name, np.full(3, diffuse), np.full(3, specular), exponent)


def parallelogram(corner: Vector, u: Vector, v: Vector, material: Material) -> Solid:
    """Two triangles; the front is where u x v points."""
    first, along_u, along_v = (np.asarray(x, dtype=float) for x in (corner, u, v))
    vertices = np.array([first, first + along_u, first + along_u + along_v, first + along_v])
    return Solid(vertices, np.array([[0, 1, 2], [0, 2, 3]]), material)


def box(low: Vector, high: Vector, material: Material, *, inward: bool, lid: bool = True) -> Solid:
    """Six rectangles between two corners, fronts towards the inside or the outside; five without a lid."""
    corner, size = np.asarray(low, dtype=float), np.subtract(high, low)
    unit = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 4, 6, 2), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6), (1, 3, 7, 5)]
    quads = quads if lid else quads[:-1]
    triangles = np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))])
    return Solid(corner + unit * size, triangles if inward else triangles[:, ::-1], material)


def prism(outline: FloatArray, triangles: IntArray, height: float, material: Material) -> Solid:
    """Raise a room over an anticlockwise outline (n, 2), its floor cut into ``triangles``; fronts inwards."""
    count = len(outline)
    here, there = np.arange(count), (np.arange(count) + 1) % count
    walls = np.concatenate(
        [
            np.stack([here, count + there, there], axis=1),
            np.stack([here, count + here, count + there], axis=1),
        ]
    )
    level = np.repeat([0.0, height], count)
    vertices = np.column_stack([np.tile(outline, (2, 1)), level])
    return Solid(vertices, np.concatenate([walls, triangles, triangles[:, ::-1] + count]), material)


def disc(radius: float, height: float, material: Material) -> Solid:
    """Make a horizontal disc as a fan of 36 triangles of the same area; its front faces up."""
    sides = 36
    reach = radius * math.sqrt(2.0 * math.pi / sides / math.sin(2.0 * math.pi / sides))
    angles = 2.0 * math.pi * np.arange(sides) / sides
    rim = np.stack([reach * np.cos(angles), reach * np.sin(angles), np.full(sides, height)], axis=1)
    here, there = np.arange(sides), (np.arange(sides) + 1) % sides
    triangles = np.stack([np.full(sides, sides), here, there], axis=1)
    return Solid(np.concatenate([rim, [[0.0, 0.0, height]]]), triangles, material)


def icosphere(levels: int, material: Material) -> Solid:
    """Cut each triangle of the icosahedron in four ``levels`` times; vertices on the unit sphere, fronts inwards."""
    golden = (1.0 + math.sqrt(5.0)) / 2.0
    turns = [np.roll([(0, s, t * golden) for s in (-1, 1) for t in (-1, 1)], k, axis=1) for k in range(3)]
    vertices = np.concatenate(turns) / math.hypot(1.0, golden)
    near = np.linalg.norm(vertices[:, None] - vertices, axis=2) < 1.1
    corners = np.argwhere(near[:, :, None] & near[:, None] & near[None])
    triangles = corners[(corners[:, 0] > corners[:, 1]) & (corners[:, 1] > corners[:, 2])]
    outward = np.linalg.det(vertices[triangles]) > 0
    triangles[outward] = triangles[outward][:, ::-1]
    for _ in range(levels):
        vertices, triangles = _quartered(vertices, triangles)
    return Solid(vertices, triangles, material)


def _quartered(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    edges, where = np.unique(sides, axis=0, return_inverse=True)
    middles = vertices[edges].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    (a, b, c), (ab, bc, ca) = triangles.T, len(vertices) + where.reshape(-1, 3).T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.concatenate([np.stack(p, axis=1) for p in parts])


def probe(label: str, point: Vector, normal: Vector) -> MeasuringPlane:
    """Make a plane so small that its grid is one point; ``normal`` is where it looks, unit length."""
    n = np.asarray(normal, dtype=float)
    helper = np.eye(3)[np.argmin(np.abs(n))]
    u = np.cross(helper, n)
    u *= PROBE_EDGE / np.linalg.norm(u)
    v = np.cross(n, u)
    return MeasuringPlane(label, np.asarray(point, dtype=float) - 0.5 * (u + v), u, v)


def place_of(plane: MeasuringPlane) -> FloatArray:
    """Middle (3,) of a plane, m: the one grid point of a `probe`."""
    return np.asarray(plane.origin + 0.5 * (plane.u + plane.v))


def lamp(position: Vector, intensity: float) -> PointLuminaire:
    """Make an isotropic point source; ``intensity`` in cd."""
    return PointLuminaire("lamp", np.asarray(position, dtype=float), np.full(3, intensity))


def scene(
    name: str,
    *solids: Solid,
    luminaires: Sequence[PointLuminaire] = (),
    planes: Sequence[MeasuringPlane] = (),
) -> Scene:
    """Put solids together, each with a material of its own."""
    firsts = np.cumsum([0] + [len(solid.vertices) for solid in solids])
    return Scene(
        name=name,
        vertices=np.concatenate([solid.vertices for solid in solids]),
        triangles=np.concatenate([s.triangles + first for s, first in zip(solids, firsts, strict=False)]),
        triangle_materials=np.repeat(np.arange(len(solids)), [len(solid.triangles) for solid in solids]),
        materials=tuple(solid.material for solid in solids),
        luminaires=tuple(luminaires),
        planes=tuple(planes),
    )


def gauss_rectangle(count: int, corner: Vector, u: Vector, v: Vector) -> tuple[FloatArray, FloatArray]:
    """Points (count², 3) and weights (count²,), of sum 1, of Gauss-Legendre's rule on a parallelogram."""
    x, w = np.polynomial.legendre.leggauss(count)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    s, t = np.repeat(x, count), np.tile(x, count)
    points = np.asarray(corner) + s[:, None] * np.asarray(u) + t[:, None] * np.asarray(v)
    return points, np.repeat(w, count) * np.tile(w, count)
