"""Polygons cut into triangles that keep the polygon's winding."""

from __future__ import annotations

import numpy as np

from lelight.scene import BoolArray, FloatArray, IntArray

#: Share of a polygon's area by which a fan triangle may turn against it before it counts as concave.
TURNED_SHARE = 1e-9


def fan(counts: IntArray) -> IntArray:
    """Triangles (0, i, i + 1) of polygons laid end to end.

    Parameters
    ----------
    counts : (n,) int, corners of each polygon, 3 or more

    Returns
    -------
    (sum(counts - 2), 3) int, positions in the row of all corners
    """
    first_corners = np.cumsum(counts) - counts
    polygons = fan_polygons(counts)
    first_triangles = np.cumsum(counts - 2) - (counts - 2)
    step = np.arange(len(polygons)) - first_triangles[polygons]
    apex = first_corners[polygons]
    return np.stack([apex, apex + step + 1, apex + step + 2], axis=1)


def fan_polygons(counts: IntArray) -> IntArray:
    """Polygon of each fan triangle: (sum(counts - 2),) int."""
    return np.repeat(np.arange(len(counts)), counts - 2)


def fan_fails(counts: IntArray, corners: FloatArray) -> BoolArray:
    """Polygons whose fan would fold over itself.

    The sum of a fan's cross products is twice the polygon's vector area whatever its shape (Newell); a
    triangle that points against that sum lies outside a simple polygon.

    Parameters
    ----------
    counts : (n,) int
    corners : (sum(counts), 3) float

    Returns
    -------
    (n,) bool
    """
    polygons = fan_polygons(counts)
    triangles = corners[fan(counts)]
    crosses = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.zeros((len(counts), 3))
    np.add.at(areas, polygons, crosses)
    agreement = np.einsum("ij,ij->i", crosses, areas[polygons])
    limit = -TURNED_SHARE * np.einsum("ij,ij->i", areas, areas)
    fails = np.zeros(len(counts), dtype=bool)
    fails[polygons[agreement < limit[polygons]]] = True
    return fails


def ear_clipping(corners: FloatArray) -> IntArray | None:
    """Cut a simple polygon, concave or with holes reached over bridges, one ear after the other.

    G. H. Meisters, "Polygons have ears", American Mathematical Monthly 82 (1975). Corners that repeat a
    corner of the ear do not block it, which is what lets the doubled ends of a bridge through.

    Parameters
    ----------
    corners : (n, 3) float

    Returns
    -------
    (m, 3) int into corners, without triangles of no area; None where the outline crosses itself
    """
    points = _flattened(corners)
    smallest = 1e-12 * float(np.prod(np.ptp(points, axis=0)))
    ring = list(range(len(points)))
    obstacles = _reflex(points, smallest)
    triangles: list[tuple[int, int, int]] = []
    position = refused = 0
    while len(ring) > 2 and refused < len(ring):
        position %= len(ring)
        ear = (ring[position - 1], ring[position], ring[(position + 1) % len(ring)])
        area = _doubled_area(*points[list(ear)])
        flat = abs(area) <= smallest
        if flat or (area > 0 and not _blocked(points[obstacles], points[list(ear)])):
            triangles += [] if flat else [ear]
            del ring[position]
            obstacles = obstacles[obstacles != ear[1]]
            position, refused = position - 1, 0
        else:
            position, refused = position + 1, refused + 1
    return np.array(triangles, dtype=np.int64).reshape(-1, 3) if len(ring) <= 2 else None


def _flattened(corners: FloatArray) -> FloatArray:
    """Corners (n, 2) along the polygon's largest projection, turned to run anticlockwise."""
    centred = corners - corners.mean(axis=0)
    area = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    axis = int(np.argmax(np.abs(area)))
    across = [(axis + 1) % 3, (axis + 2) % 3]
    return np.asarray(centred[:, across if area[axis] >= 0 else across[::-1]])


def _doubled_area(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _reflex(points: FloatArray, smallest: float) -> IntArray:
    """Corners where the outline does not turn left; no other corner can lie in an ear."""
    to_next = np.roll(points, -1, axis=0) - points
    from_last = points - np.roll(points, 1, axis=0)
    turns = from_last[:, 0] * to_next[:, 1] - from_last[:, 1] * to_next[:, 0]
    return np.flatnonzero(turns <= smallest)


def _blocked(obstacles: FloatArray, ear: FloatArray) -> bool:
    """Tell whether an obstacle that does not repeat a corner of the ear lies in the ear or on its rim."""
    x, y = obstacles[:, 0], obstacles[:, 1]
    (ax, ay), (bx, by), (cx, cy) = ear.tolist()
    inside = (bx - ax) * (y - ay) >= (by - ay) * (x - ax)
    inside &= (cx - bx) * (y - by) >= (cy - by) * (x - bx)
    inside &= (ax - cx) * (y - cy) >= (ay - cy) * (x - cx)
    if not inside.any():
        return False
    repeats = (obstacles[inside][:, None, :] == ear).all(axis=-1).any(axis=-1)
    return not bool(repeats.all())
