"""Exact values of the cases that `lelight validate` runs, against published figures and against each other."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from lelight.analytic import (
    areasource,
    cube,
    fluxbalance,
    furnace,
    phongplate,
    pointsource,
    reflector,
    sphere,
)
from lelight.analytic.catalogue import cases
from lelight.analytic.configuration import (
    parallel_rectangles,
    perpendicular_rectangles,
    polygon_illuminance,
)
from lelight.analytic.room import HEIGHT, row_points, wall_points
from lelight.analytic.sobolev import discs, infinite_planes
from lelight.analytic.solids import gauss_rectangle, icosphere, matt, place_of, probe, scene
from lelight.scene import triangle_areas, triangle_normals

# Sobolev's problem, h = 2 m, source of 1 cd in the middle, at r = 0, 1, 2, 5, 10 m: computed apart from this
# program to 1e-8.
RADII = np.array([0.0, 1.0, 2.0, 5.0, 10.0])
PLANES = {
    0.0: (1.0, 0.35355339059),
    0.5: (1.1320323815, 0.46507252018, 0.16336057930, 0.024674218453, 0.0035981581165),
    0.8: (1.2943970306, 0.61120463714, 0.27705941736, 0.071043994224, 0.016179015240),
}


@pytest.mark.parametrize("rho", PLANES)
def test_infinite_planes(rho):
    known = np.array(PLANES[rho])
    lower, upper = infinite_planes(RADII[: len(known)], source_height=1.0, reflectances=(rho, rho))
    np.testing.assert_allclose(lower, known, rtol=2e-8)
    np.testing.assert_allclose(upper, lower, rtol=1e-12)


def test_flux_of_infinite_planes():
    # Each plane gets 2 pi I (1 + rho) / (1 - rho²); beyond R = 60 m some 1 % is left, which E ~ r^-3 tells.
    r, w = np.polynomial.legendre.leggauss(300)
    edges = np.array([0.0, 5.0, 60.0])
    flux = 0.0
    for low, high in pairwise(edges):
        at = 0.5 * (low + high) + 0.5 * (high - low) * r
        lower, _ = infinite_planes(at, source_height=1.0, reflectances=(0.5, 0.5))
        flux += math.pi * (high - low) * float(w @ (at * lower))
    beyond = (
        2
        * math.pi
        * 60.0**2
        * infinite_planes(np.array([60.0]), source_height=1.0, reflectances=(0.5, 0.5))[0]
    )
    assert flux + float(beyond[0]) == pytest.approx(2 * math.pi * 1.5 / 0.75, rel=2e-3)


def test_discs_approach_planes_and_change_places():
    lower, upper = discs(RADII[:4], source_height=0.5, reflectances=(0.5, 0.8), radius=10.0)
    np.testing.assert_allclose(lower, [4.188551664, 0.524639748, 0.178824615, 0.038346960], rtol=3e-8)
    np.testing.assert_allclose(upper, [0.648010895, 0.418711615, 0.195840941, 0.034872433], rtol=3e-8)
    turned = discs(RADII[:4], source_height=1.5, reflectances=(0.8, 0.5), radius=10.0)
    np.testing.assert_allclose(turned, (upper, lower), rtol=1e-12)
    wide, _ = discs(RADII[:1], source_height=1.0, reflectances=(0.5, 0.5), radius=20.0)
    assert 1.0 - wide[0] / PLANES[0.5][0] == pytest.approx(1.67e-6, rel=0.02)


def test_discs_do_not_depend_on_the_rule():
    problem = {"source_height": 0.5, "reflectances": (0.5, 0.8), "radius": 10.0}
    np.testing.assert_allclose(
        discs(RADII[:4], **problem), discs(RADII[:4], **problem, nodes_per_metre=40), rtol=1e-9
    )


def test_form_factors_of_a_cube():
    # Howell's catalogue: opposite 0.199825, adjacent 0.200044; all six sum to 1.
    assert parallel_rectangles(1, 1, 1) == pytest.approx(0.199825, abs=5e-7)
    assert perpendicular_rectangles(1, 1, 1) == pytest.approx(0.200044, abs=5e-7)
    assert parallel_rectangles(1, 1, 1) + 4 * perpendicular_rectangles(1, 1, 1) == pytest.approx(1, abs=1e-12)


def test_form_factors_are_means_of_configuration_factors():
    points, weights = gauss_rectangle(24, (0, 0, 1.5), (0, 2, 0), (3, 0, 0))
    source = np.array([[0, 0, 0], [3, 0, 0], [3, 2, 0], [0, 2, 0]], dtype=float)
    down = np.broadcast_to([0.0, 0.0, -1.0], points.shape)
    mean = weights @ polygon_illuminance(points, down, source, luminance=1 / math.pi)
    assert mean == pytest.approx(parallel_rectangles(3, 2, 1.5), rel=1e-9)
    # Reciprocity of unequal perpendicular ones: A1 F12 = A2 F21.
    there, back = perpendicular_rectangles(2, 1.5, 3), perpendicular_rectangles(1.5, 2, 3)
    assert 2 * there == pytest.approx(1.5 * back, rel=1e-12)


def test_polygon_below_the_horizon_gives_nothing_and_half_gives_half():
    square = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float)
    origin = np.zeros((1, 3))
    sideways = polygon_illuminance(origin, np.array([[1.0, 0, 0]]), square, luminance=1.0)
    right = np.array([[0, -1, 1], [1, -1, 1], [1, 1, 1], [0, 1, 1]], dtype=float)
    assert sideways == pytest.approx(
        polygon_illuminance(origin, np.array([[1.0, 0, 0]]), right, luminance=1.0)
    )
    assert polygon_illuminance(origin, np.array([[0, 0, -1.0]]), square, luminance=1.0)[0] == 0.0


# CIE 171:2006, recomputed apart from this program; the report's own tables agree within 0.4 %.
def test_point_source():
    known = [111.111, 106.637, 94.868, 79.505, 102.456, 91.419, 76.926, 82.230, 69.971, 60.481]
    np.testing.assert_allclose(pointsource.isotropic(pointsource.POINTS), known, atol=6e-4)
    known = [111.111, 105.186, 90.0, 71.111, 99.723, 85.663, 68.053, 74.380, 59.975, 49.383]
    np.testing.assert_allclose(pointsource.diffuse(pointsource.POINTS), known, rtol=1.2e-4)


def exact_of(case):
    """Reference of a case of single points, read from a run that found nothing."""

    class Plane:
        illuminance = std_error = np.zeros(1)
        replicates = np.zeros((8, 1))

    class Run:
        planes = [Plane] * len(case.scene.planes)

    return case.read(Run).reference


def test_area_source():
    wall = [32.6769, 75.19392, 81.32317, 69.06063, 53.40353, 40.00185]
    floor = [61.4241, 79.25516, 95.66728, 105.7782]
    np.testing.assert_allclose(exact_of(areasource.case()), [*wall, *floor, *floor[::-1]], rtol=1e-6)


def test_flux_on_faces():
    flux = [fluxbalance.face_flux(corner, u, v) for _, corner, u, v in fluxbalance.FACES]
    assert sum(flux) == pytest.approx(fluxbalance.FLUX, rel=1e-12)


REFLECTED = {
    0.5: (
        0.2458096,
        0.5799357,
        0.6443655,
        0.5563539,
        0.4332963,
        0.3251091,
        0.4913964,
        0.6391304,
        0.7776445,
        0.86426,
    ),
    4.0: (45.1226, 35.9005, 27.99162, 21.63851, 16.71631, 12.96737, 26.79519, 30.93871, 33.97572, 35.56659),
    500.0: (49.94349, 49.83048, 49.71747, 49.60446, 49.49146, 49.37847, *[99.98822] * 4),
}


@pytest.mark.parametrize("side", REFLECTED)
def test_horizontal_reflector(side):
    known = [*REFLECTED[side], *REFLECTED[side][:5:-1]]
    np.testing.assert_allclose(exact_of(reflector.horizontal_case(side)), known, rtol=2e-6)


def test_reflector_behind_a_screen():
    wall = [7.078969, 10.31692, 13.32202, 15.39881, 16.32968, 16.07064]
    floor = [3.382335, 3.628986, 3.012951, 0.0, 0.0]
    np.testing.assert_allclose(exact_of(reflector.screen_case()), [*wall, *floor], rtol=1e-6, atol=1e-9)


def test_reflector_under_a_far_lamp_is_a_luminous_one(monkeypatch):
    # From 1000 times as far the square is lit evenly.
    monkeypatch.setattr(reflector, "LAMP", 1e3 * reflector.LAMP)
    planes = [*wall_points(upwards=True), *row_points(HEIGHT)]
    corners = reflector.floor_square(4.0).vertices
    lit = reflector.reflected(planes, corners)
    even = reflector.seen_whole(planes, corners)
    np.testing.assert_allclose(lit / lit[0], even / even[0], rtol=2e-3)


def test_mean_in_the_cube():
    # Indirect part at rho 0.9: 937.5 lx.
    assert cube.mean_illuminance(0.9) - cube.mean_illuminance(0.0) == pytest.approx(937.5, rel=1e-12)
    points, weights = gauss_rectangle(cube.COUNT, (0, 0, 0), (4, 0, 0), (0, 4, 0))
    assert cube.allowance(points, weights, 0.9) < 5e-4 * cube.mean_illuminance(0.9)


def test_furnace_and_sphere():
    assert furnace.illuminance(0.6) == pytest.approx(785.398163, rel=1e-9)
    solid = icosphere(2, matt("sphere", 0.5))
    corners = solid.vertices[solid.triangles]
    assert np.all(np.einsum("nx,nx->n", triangle_normals(corners), corners.mean(axis=1)) < 0)
    middles, area = corners.mean(axis=1), float(triangle_areas(corners).sum())
    light = sphere.illuminance(middles, triangle_normals(corners), reflectance=0.5, area=area)
    # Energy: what the surface absorbs is what the lamp sends. The mid-point rule takes facets for flat in E.
    absorbed = 0.5 * float(light @ triangle_areas(corners))
    assert absorbed == pytest.approx(4 * math.pi * sphere.INTENSITY, rel=0.01)
    assert 0 < sphere.allowance(corners, reflectance=0.5) < 4e-4 * float(light.mean())


# With the exponent 0 the lobe is Lambertian with albedo ks (n + 2)/(2 pi) = ks / pi.
def test_plate_without_gloss():
    point = np.array([[0.3, -0.2, 0.25]])
    up = np.array([0.0, 0.0, 1.0])
    albedo = phongplate.DIFFUSE + phongplate.SPECULAR
    corner, u, v = (np.array(each) for each in phongplate.PANEL)
    panel = np.array([corner, corner + u, corner + u + v, corner + v])
    lit = polygon_illuminance(np.zeros((1, 3)), up[None], panel, luminance=phongplate.LUMINANCE)
    seen = phongplate.panel_radiance(np.zeros(3), np.array([[0.6, 0, 0.8]]), exponent=0.0)
    assert seen == pytest.approx(albedo / math.pi * lit, rel=1e-9)
    other = phongplate.reflected_illuminance(point, exponent=0.0, count=350)
    assert other == pytest.approx(phongplate.reflected_illuminance(point, exponent=0.0), rel=1e-8)


@pytest.mark.parametrize("exponent", [1.0, 16.0, 128.0])
def test_plate_does_not_depend_on_the_rule(exponent):
    points = np.array(list(phongplate.RECEIVERS.values()))
    fine = phongplate.reflected_illuminance(points, exponent=exponent)
    np.testing.assert_allclose(
        phongplate.reflected_illuminance(points, exponent=exponent, count=400), fine, rtol=1e-5
    )
    out = np.array([[0.5, 0.0, 0.8660254]])
    fine = phongplate.panel_radiance(np.zeros(3), out, exponent=exponent)
    np.testing.assert_allclose(
        phongplate.panel_radiance(np.zeros(3), out, exponent=exponent, count=80), fine, rtol=1e-6
    )


def test_lobe_keeps_energy_from_above():
    theta, weights = np.polynomial.legendre.leggauss(200)
    cos = 0.5 * (theta + 1.0)
    out = np.stack([np.sqrt(1 - cos**2), np.zeros(200), cos], axis=1)
    sent = phongplate.lobe(np.array([0.0, 0.0, 1.0]), out, exponent=16.0, diffuse=0.0)
    assert 2 * math.pi * 0.5 * float(weights @ (sent * cos)) == pytest.approx(phongplate.SPECULAR, rel=1e-9)


def test_probe_is_one_point_that_looks_where_told():
    from lelight.metrics.grid import grid_points

    for normal in ([0, 0, -1.0], [0, 1.0, 0], [0.6, 0.0, 0.8]):
        plane = probe("p", (1.0, 2.0, 3.0), normal)
        points, shape = grid_points(plane)
        assert shape == (1, 1)
        np.testing.assert_allclose(points[0], [1.0, 2.0, 3.0], atol=1e-12)
        np.testing.assert_allclose(plane.normal, normal, atol=1e-12)
        np.testing.assert_allclose(place_of(plane), points[0], atol=1e-12)


def test_names_of_cases_are_unique_and_all_have_a_reference():
    short, full = cases(), cases(full=True)
    names = [case.name for case in full]
    assert len(set(names)) == len(names)
    assert len(full) > len(short)
    for case in short:
        assert 0 < case.precision < case.tolerance < 0.02


def test_scene_keeps_materials_apart():
    made = scene("two", icosphere(0, matt("a", 0.1)), icosphere(0, matt("b", 0.2)))
    assert [m.name for m in made.materials] == ["a", "b"]
    assert np.bincount(made.triangle_materials).tolist() == [20, 20]
