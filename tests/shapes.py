"""Made-up surfaces for the mesh tests: vertices and triangles, put together into scenes."""

from __future__ import annotations

import numpy as np

from lelight.scene import FloatArray, IntArray, Material, Scene

Shape = tuple[FloatArray, IntArray]


def scene_of(*shapes: Shape, materials: list[int] | None = None) -> Scene:
    """One material for each shape (by default the same for all), vertices not shared between shapes."""
    own = materials or [0] * len(shapes)
    firsts = np.cumsum([0] + [len(vertices) for vertices, _ in shapes])
    return Scene(
        name="made up",
        vertices=np.concatenate([np.asarray(vertices, dtype=float) for vertices, _ in shapes]),
        triangles=np.concatenate(
            [triangles + first for (_, triangles), first in zip(shapes, firsts, strict=False)]
        ),
        triangle_materials=np.repeat(own, [len(triangles) for _, triangles in shapes]),
        materials=tuple(Material(f"m{number}", np.full(3, 0.5)) for number in range(max(own) + 1)),
    )


def solid(size: tuple[float, float, float], corner: tuple[float, float, float]) -> Shape:
    """A box whose fronts look outwards."""
    vertices, triangles = placed(box(size), shift=corner)
    return vertices, triangles[:, ::-1]


def placed(shape: Shape, *, scale: float = 1.0, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Shape:
    return shape[0] * scale + np.array(shift), shape[1]


def soup(shape: Shape) -> Shape:
    """The same triangles, each with three vertices of its own."""
    vertices, triangles = shape
    return vertices[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)


def box(size: tuple[float, float, float] = (4.0, 3.0, 2.5)) -> Shape:
    """Six rectangles, fronts inwards."""
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * np.array(size)
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return vertices, np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))])


def fan(corners: FloatArray) -> Shape:
    """A convex polygon as the modeller's needles: triangles from its first corner."""
    return corners, np.array([(0, k, k + 1) for k in range(1, len(corners) - 1)])


def circle(count: int, radius: float = 1.0, height: float = 0.0) -> FloatArray:
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count, height)], axis=1)


def strip(low: FloatArray, high: FloatArray) -> Shape:
    """Quadrilaterals between two closed rings of as many points: a tube or a flat ring."""
    count = len(low)
    here, there = np.arange(count), (np.arange(count) + 1) % count
    faces = [np.stack([here, there, count + there], 1), np.stack([here, count + there, count + here], 1)]
    return np.concatenate([low, high]), np.concatenate(faces)


def l_prism(height: float = 2.5) -> Shape:
    """An L-shaped room, 8 patches: floor, ceiling, six walls."""
    outline = np.array([[0, 0], [4, 0], [4, 2], [2, 2], [2, 5], [0, 5]], dtype=float)
    low = np.column_stack([outline, np.zeros(6)])
    flat = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)])
    walls = strip(low, low + np.array([0, 0, height]))
    return walls[0], np.concatenate([walls[1], flat[:, ::-1], flat + 6])


def icosphere(levels: int) -> Shape:
    """The icosahedron with every triangle cut in four ``levels`` times, vertices on the unit sphere."""
    golden = (1 + np.sqrt(5)) / 2
    turns = [np.roll([(0, s, t * golden) for s in (-1, 1) for t in (-1, 1)], k, axis=1) for k in range(3)]
    vertices = np.concatenate(turns)
    close = np.isclose(np.linalg.norm(vertices[:, None] - vertices[None], axis=2), 2.0)
    triples = [
        (a, b, c)
        for a in range(12)
        for b in range(a)
        for c in range(b)
        if close[a, b] and close[b, c] and close[a, c]
    ]
    triangles = np.array(triples)
    centres = vertices[triangles]
    inward = (
        np.einsum(
            "nx,nx->n", np.cross(centres[:, 1] - centres[:, 0], centres[:, 2] - centres[:, 0]), centres[:, 0]
        )
        < 0
    )
    triangles[inward] = triangles[inward][:, ::-1]
    for _ in range(levels):
        vertices, triangles = _quartered(vertices, triangles)
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True), triangles


def _quartered(vertices: FloatArray, triangles: IntArray) -> Shape:
    sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    unique, where = np.unique(sides, axis=0, return_inverse=True)
    (a, b, c), (ab, bc, ca) = triangles.T, len(vertices) + where.reshape(-1, 3).T
    middles = vertices[unique].mean(axis=1)
    middles *= np.linalg.norm(vertices[0]) / np.linalg.norm(middles, axis=1, keepdims=True)
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.concatenate([np.stack(part, axis=1) for part in parts])
