"""Triangles seen from a point: solid angle, samples uniform in it, and the light they give."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss
from verdicts import follows

from lelight.scene import triangle_areas, triangle_normals
from lelight.tracing import triangles

SAMPLES = 10_000
#: Cells of a triangle along each of its two coordinates, and parts of a cell over which a density is integrated.
CELLS, PARTS = 5, 6
EXACT = 1e-9
ORIGIN = (0.0, 0.0, 0.0)

#: Triangles as seen from the origin, each hard in its own way.
SEEN = {
    "octant": [(1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "ceiling panel": [(1, 1, 2), (2, 1, 2), (1, 2, 2)],
    "thin": [(-3, 0, 1), (3, 0, 1), (3, 0.01, 1)],
    "needle": [(-3, 0.5, 1), (3, 0.5, 1), (3, 0.5001, 1)],
    "near": [(-1, -1, 0.01), (2, -1, 0.01), (-1, 2, 0.01)],
    "near beside": [(0.01, -1, 0.01), (2, -1, 0.01), (0.01, 2, 0.01)],
    "edge on": [(1, -1, 0.001), (3, 0, 0.001), (1, 1, 0.001)],
    "as far as five of its sides": [(0.5, 0.5, 7), (1.5, 0.5, 7), (0.5, 1.5, 7)],
    "long with one end near": [(0.1, 0, 0.1), (60, 0, 20), (60, 1, 20)],
    "far": [(100, 0, 0), (100, 1, 0), (100, 0, 1)],
    "far and edge on": [(100, 0, 0.1), (101, 0, 0.1), (100, 1, 0.1)],
    "almost a hemisphere": [(-9, -9, 0.1), (9, -9, 0.1), (0, 20, 0.1)],
}
each_seen = pytest.mark.parametrize("corners", SEEN.values(), ids=SEEN)


def prepared(corners):
    corners = np.array(corners, dtype=float)
    return corners, triangle_normals(corners[None])[0], triangle_areas(corners[None])[0]


def place(corners, s, t):
    """Points of a triangle by two coordinates in [0, 1], in which its area is even."""
    root = np.sqrt(s)[..., None]
    a, b, c = corners
    return (1 - root) * a + root * ((1 - t)[..., None] * b + t[..., None] * c)


def coordinates(corners, points):
    """The two coordinates (k, 2) of points (k, 3) of a triangle; the inverse of `place`."""
    a, b, c = corners
    wb, wc = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), (points - a).T, rcond=None)[0]
    return np.stack([(wb + wc) ** 2, wc / (wb + wc)], axis=1)


def cell_probabilities(corners, normal, area):
    """Integral of `triangle_density` over the solid angle of each cell, (CELLS, CELLS)."""
    fine = CELLS * PARTS
    edges = np.linspace(0, 1, fine + 1)
    grid = place(corners, *np.meshgrid(edges, edges, indexing="ij"))
    middles = place(
        corners, *np.meshgrid((edges[1:] + edges[:-1]) / 2, (edges[1:] + edges[:-1]) / 2, indexing="ij")
    )
    probability = np.zeros((fine, fine))
    for i, j in np.ndindex(fine, fine):
        quad = [grid[i, j], grid[i + 1, j], grid[i + 1, j + 1], grid[i, j + 1]]
        halves = [np.array([quad[0], quad[1], quad[2]]), np.array([quad[0], quad[2], quad[3]])]
        direction = tuple(middles[i, j] / np.linalg.norm(middles[i, j]))
        solid_angle = sum(triangles.triangle_solid_angle(half, *ORIGIN) for half in halves)
        probability[i, j] = solid_angle * triangles.triangle_density(
            corners, normal, area, *ORIGIN, direction
        )
    return probability.reshape(CELLS, PARTS, CELLS, PARTS).sum(axis=(1, 3))


def draw(corners, normal, area):
    numbers = np.random.default_rng(1).random((SAMPLES, 2))
    return [triangles.sample_triangle(corners, normal, area, *ORIGIN, u, v) for u, v in numbers]


def counted(corners, points):
    edges = np.linspace(0, 1, CELLS + 1)
    return np.histogramdd(np.clip(coordinates(corners, points), 0, 1), bins=(edges, edges))[0]


@each_seen
def test_solid_angle_is_what_girard_says(corners):
    """The sum of the angles between the planes through the origin, less pi (Girard 1629)."""
    corners, _, _ = prepared(corners)
    a, b, c = corners
    planes = [np.cross(p, q) / np.linalg.norm(np.cross(p, q)) for p, q in ((a, b), (b, c), (c, a))]
    # The angle between neighbouring planes, by its tangent: arc cosines lose the needle's last digits.
    turns = [
        math.atan2(np.linalg.norm(np.cross(planes[k - 1], planes[k])), planes[k - 1] @ planes[k])
        for k in range(3)
    ]
    excess = 2 * math.pi - sum(turns)
    assert triangles.triangle_solid_angle(corners, *ORIGIN) == pytest.approx(excess, rel=1e-6, abs=1e-13)


def test_faces_of_a_cube_make_the_sphere():
    """Seen from the centre every face of a cube takes 4 pi / 6."""
    face = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float)
    halves = [triangles.triangle_solid_angle(face[list(part)], *ORIGIN) for part in ((0, 1, 2), (0, 2, 3))]
    assert sum(halves) == pytest.approx(4 * math.pi / 6, rel=EXACT)


@each_seen
def test_samples_follow_the_stated_density(corners):
    corners, normal, area = prepared(corners)
    points = np.array([np.multiply(d, distance) for d, distance, _ in draw(corners, normal, area)])
    assert follows(counted(corners, points), cell_probabilities(corners, normal, area))


def test_area_stands_in_for_solid_angle_only_where_it_is_nearly_as_even():
    """From just beyond `FAR_SIDES` the densities toward a panel overhead deviate from the even one by less than 6 %."""
    corners, normal, area = prepared([(-0.5, -0.5, 5.8), (0.5, -0.5, 5.8), (-0.5, 0.5, 5.8)])
    densities = np.array([density for _, _, density in draw(corners, normal, area)])
    assert len(np.unique(densities)) > SAMPLES / 2
    even = 1.0 / triangles.triangle_solid_angle(corners, *ORIGIN)
    assert np.std(densities / even) < 0.06
    near, normal, area = prepared(SEEN["long with one end near"])
    assert len({density for _, _, density in draw(near, normal, area)}) == 1


@each_seen
def test_samples_lie_on_the_triangle_and_carry_the_density_of_their_direction(corners):
    corners, normal, area = prepared(corners)
    for direction, distance, density in draw(corners, normal, area)[:500]:
        assert math.hypot(*direction) == pytest.approx(1.0, rel=EXACT)
        assert np.dot(np.multiply(direction, distance) - corners[0], normal) == pytest.approx(0.0, abs=1e-8)
        again = triangles.triangle_density(corners, normal, area, *ORIGIN, direction)
        assert again == pytest.approx(density, rel=1e-6)
        assert triangles.point_on_ray(corners, normal, *ORIGIN, direction) == pytest.approx(
            distance, rel=1e-6
        )


def test_samples_by_area_do_not_follow_the_solid_angle_of_a_near_triangle():
    """The test has power: even over the area of a near triangle is not even over its solid angle."""
    corners, normal, area = prepared(SEEN["near beside"])
    s, t = np.random.default_rng(1).random((2, SAMPLES))
    assert not follows(counted(corners, place(corners, s, t)), cell_probabilities(corners, normal, area))


def cosine_integral(corners, normal, *, order=80):
    """Illuminance from a triangle of unit luminance by quadrature over its area, the horizon cut off."""
    nodes, weights = leggauss(order)
    s, t = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2, indexing="ij")
    # Substituted s = r²: points are even in r, and the area element is 2 r.
    points = place(corners, s**2, t)
    _, own, area = prepared(corners)
    square = (points**2).sum(axis=-1)
    directions = points / np.sqrt(square)[..., None]
    kernel = np.maximum(directions @ normal, 0.0) * np.abs(directions @ own) / square
    return area * np.sum(0.25 * np.outer(weights, weights) * 2 * s * kernel)


def test_irradiance_of_panels_above_the_horizon_is_the_integral_over_their_area():
    for name in ("octant", "ceiling panel", "far"):
        corners, _, _ = prepared(SEEN[name])
        normal = corners.mean(axis=0) / np.linalg.norm(corners.mean(axis=0))
        light = triangles.triangle_irradiance(corners, *ORIGIN, *normal)
        assert light == pytest.approx(cosine_integral(corners, normal), rel=EXACT), name


@given(tilt=st.floats(0, math.pi), azimuth=st.floats(-math.pi, math.pi))
def test_irradiance_with_the_horizon_cut_off_is_the_integral_over_what_stands_above_it(tilt, azimuth):
    """Normals all round: the panel is above the horizon, cut by it along either number of corners, or below."""
    corners = np.array([(-1, -1.2, 1), (2, -0.4, 1.1), (-0.3, 1.5, 0.8)], dtype=float)
    normal = np.array(
        [math.sin(tilt) * math.cos(azimuth), math.sin(tilt) * math.sin(azimuth), math.cos(tilt)]
    )
    light = triangles.triangle_irradiance(corners, *ORIGIN, *normal)
    # The kink at the horizon leaves the quadrature about order^-2 of the peak.
    assert light == pytest.approx(cosine_integral(corners, normal), rel=1e-5, abs=6e-4)


def test_irradiance_below_the_horizon_is_exactly_none():
    corners, _, _ = prepared(SEEN["ceiling panel"])
    assert triangles.triangle_irradiance(corners, *ORIGIN, 0.0, 0.0, -1.0) == 0.0


def test_irradiance_of_a_cut_rectangle_is_the_published_view_factor():
    """A wall from below the floor to height c, width b, at distance a from a floor element at its foot's corner.

    Element parallel-plate formula for perpendicular surfaces: F = (atan(1/Y) - Y/sqrt(X²+Y²) atan(1/sqrt(X²+Y²)))
    / (2 pi), X = c/b, Y = a/b (Howell, catalogue of radiation configurations, B-4); E = pi F at unit luminance.
    """
    a, b, c = 0.7, 2.0, 1.3
    x, y = c / b, a / b
    factor = (math.atan(1 / y) - y / math.hypot(x, y) * math.atan(1 / math.hypot(x, y))) / (2 * math.pi)
    wall = np.array([(a, 0, -3), (a, b, -3), (a, b, c), (a, 0, c)])
    halves = [
        triangles.triangle_irradiance(wall[list(k)], *ORIGIN, 0.0, 0.0, 1.0) for k in ((0, 1, 2), (0, 2, 3))
    ]
    assert sum(halves) == pytest.approx(math.pi * factor, rel=EXACT)


def test_irradiance_does_not_depend_on_where_the_world_begins():
    """Moved to map coordinates the differences keep nine digits."""
    corners, _, _ = prepared(SEEN["ceiling panel"])
    shift = np.array([5e5, 5e6, 100.0])
    here = triangles.triangle_irradiance(corners, *ORIGIN, 0.0, 0.6, 0.8)
    there = triangles.triangle_irradiance(corners + shift, *shift, 0.0, 0.6, 0.8)
    assert there == pytest.approx(here, rel=1e-8)
