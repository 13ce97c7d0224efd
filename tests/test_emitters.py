"""Emitters: their flux, their choice, and the light that is drawn from them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rooms import grey, lamp, lit, normalised, panel
from shapes import box
from verdicts import agrees, follows

from lelight.channels import channel_matrix
from lelight.scene import Material
from lelight.tracing.chains import emit
from lelight.tracing.drawing import (
    LOCAL_CHOICE_LIMIT,
    add_unblocked,
    choice_cdf,
    chosen,
    drawn_density,
    rough_cdfs,
    shines,
    source_strength,
    toward_face,
)
from lelight.tracing.emitters import collect_emitters
from lelight.tracing.lamps import toward_lamp
from lelight.tracing.sight import unseen
from lelight.tracing.triangles import triangle_irradiance

EXACT = 1e-9
OFFSET = 1e-6
#: Contributions below this share of all are lost in rounding of the cumulative probabilities.
ROUNDING = 1e-12

#: Two panels, the second of them shining both ways, and two points.
SHAPES = (panel((0, 0, 3), (0, 1, 0), (2, 0, 0)), panel((3, 0, 2), (0, 1, 0), (0, 0, 1)))
MATERIALS = [grey("down", 0.5, luminance=10.0), grey("both", 0.5, luminance=3.0, emission_sides="both")]
POINTS = (lamp((1.0, 1.0, 2.0), 5.0), lamp((-2.0, 4.0, 1.0), 40.0))


def made(*, channels=1, luminaires=POINTS, materials=MATERIALS):
    scene = lit(*SHAPES, materials=materials, luminaires=luminaires)
    return collect_emitters(scene, channel_matrix(channels))


def test_flux_is_pi_luminance_area_each_side_and_four_pi_intensity():
    """A panel of 2 m² and 10 cd/m²: 20 pi lm; 1 m² at 3 cd/m² both ways: 6 pi lm; points 4 pi I."""
    expected = [10 * math.pi, 10 * math.pi, 3 * math.pi, 3 * math.pi, 20 * math.pi, 160 * math.pi]
    np.testing.assert_allclose(made().flux[:, 0], expected, rtol=EXACT)
    np.testing.assert_allclose(made().power, expected, rtol=EXACT)


def test_coloured_flux_is_kept_by_channel_and_its_power_is_its_luminance():
    green = replace(MATERIALS[0], luminance=np.array([0.0, 10.0, 0.0]))
    emitters = made(channels=3, materials=[green, MATERIALS[1]])
    np.testing.assert_allclose(emitters.flux[0], [0.0, 10 * math.pi, 0.0], rtol=EXACT)
    # Rec. 709: green is 0.7152 of the luminance.
    assert emitters.power[0] == pytest.approx(7.152 * math.pi, rel=EXACT)


def test_only_luminous_triangles_are_sources_and_know_their_number():
    dark = lit(box(), SHAPES[0], materials=[grey("walls", 0.5), MATERIALS[0]])
    emitters = collect_emitters(dark, channel_matrix(1))
    assert np.array_equal(emitters.of_triangle, [*[-1] * 12, 0, 1])


@pytest.mark.parametrize("channels", [1, 3])
def test_emitted_chains_start_as_the_sources_shine(channels):
    """Source by power, place even over the area, direction by cosine to the side that shines."""
    emitters = made(channels=channels)
    numbers = np.random.default_rng(1).random((20_000, 5))
    origins, directions, flux = emit(emitters, numbers, OFFSET)
    np.testing.assert_allclose(flux, emitters.power.sum(), rtol=EXACT)
    source = source_of(origins)
    share = emitters.power / emitters.power.sum()
    assert follows(np.bincount(source, minlength=6), share)
    down = source <= 1
    place = np.histogram2d(origins[down, 0], origins[down, 1], bins=6, range=((0, 2), (0, 1)))[0]
    assert follows(place, np.full((6, 6), 1 / 36))
    # 1 - cos² of a cosine-distributed direction is even; the panel over the room shines down only.
    assert np.all(directions[down, 2] < 0)
    assert follows(np.histogram(1 - directions[down, 2] ** 2, bins=10, range=(0, 1))[0], np.full(10, 0.1))
    both = (source >= 2) & (source <= 3)
    signed = np.sign(directions[both, 0]) * (1 - directions[both, 0] ** 2)
    assert follows(np.histogram(signed, bins=10, range=(-1, 1))[0], np.full(10, 0.1))
    # Origins stand off to the side they shine to.
    assert np.all(np.sign(origins[both, 0] - 3.0) == np.sign(directions[both, 0]))
    points = source >= 4
    assert follows(np.histogram(directions[points, 2], bins=10, range=(-1, 1))[0], np.full(10, 0.1))


def source_of(origins):
    """Which of the six sources each origin (k, 3) stands on."""
    on_first = np.abs(origins[:, 2] - 3.0) < 1e-5
    on_second = np.abs(origins[:, 0] - 3.0) < 1e-5
    # The diagonals from corner 0 part the panels: u = (0, 1, 0) runs along the first triangle.
    first = np.where(origins[:, 1] * 2.0 > origins[:, 0], 0, 1)
    second = np.where(origins[:, 1] > origins[:, 2] - 2.0, 2, 3)
    points = np.where(origins[:, 2] == 2.0, 4, 5)
    return np.where(on_first, first, np.where(on_second, second, points))


coordinates = st.floats(-5, 5)
places = st.tuples(coordinates, coordinates, coordinates)
directions = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)).filter(
    lambda d: math.hypot(*d) > 0.1
)


def contributions(emitters, place, normal, *, on_surface=True):
    """Illuminance that each source alone would give, nothing in between, (T + P,)."""
    light = np.zeros(len(emitters.power))
    for source in range(len(light)):
        alone = emitters._replace(
            luminance=np.where(np.arange(len(emitters.areas))[:, None] == source, emitters.luminance, 0.0),
            intensity=np.where(
                np.arange(len(emitters.intensity))[:, None] == source - len(emitters.areas),
                emitters.intensity,
                0.0,
            ),
        )
        total = np.zeros(1)
        unblocked(alone, *place, *normal, total)
        light[source] = total[0]
    return light


def unblocked(emitters, x, y, z, nx, ny, nz, illuminance):
    """All of what the sources would give with nothing in between."""
    add_unblocked(emitters, x, y, z, nx, ny, nz, np.ones(len(emitters.power)), illuminance)


def ideal_cdf(emitters, x, y, z, nx, ny, nz, on_surface, cdf):
    """`choice_cdf` where nothing is known of what is in sight."""
    return choice_cdf(emitters, x, y, z, nx, ny, nz, on_surface, -1, unseen(), cdf)


def rough_cdf(emitters, x, y, z, nx, ny, nz, cdf):
    """One place's row of `rough_cdfs`; returns whether any source can light it."""
    rows = np.empty((1, len(cdf)))
    rough_cdfs(emitters, np.array([[x, y, z]]), np.array([[nx, ny, nz]]), rows)
    cdf[:] = rows[0]
    return cdf[-1] > 0.0


def toward(emitters, source, x, y, z, u, v, offset):
    triangles = len(emitters.areas)
    if source >= triangles:
        return toward_lamp(emitters, source - triangles, x, y, z, u, v, offset)
    faces = emitters.corners, emitters.normals, emitters.areas, emitters.both_sides
    return toward_face(*faces, source, x, y, z, u, v, offset)


@settings(deadline=None)
@given(place=places, normal=directions)
def test_choice_is_a_distribution_and_leaves_no_source_out_that_contributes(place, normal):
    emitters = made()
    normal = normalised(np.array(normal))
    light = contributions(emitters, place, normal)
    for choose in (
        lambda cdf: ideal_cdf(emitters, *place, *normal, True, cdf),
        lambda cdf: ideal_cdf(emitters, *place, *normal, False, cdf),
        lambda cdf: rough_cdf(emitters, *place, *normal, cdf),
    ):
        cdf = np.empty(6)
        if not choose(cdf):
            assert light.sum() == 0.0
            continue
        shares = np.diff(cdf, prepend=0.0)
        assert cdf[-1] == 1.0
        assert np.all(shares >= 0.0)
        assert np.all(shares[light > ROUNDING * light.sum()] > 0.0)


def test_choice_near_the_sources_follows_what_each_gives():
    """Within five square roots of area the importance is the illuminance itself, so the choice is ideal."""
    emitters = made(luminaires=())
    place, normal = (0.5, 0.5, 2.0), normalised(np.array([0.5, 0.1, 1.0]))
    cdf = np.empty(4)
    assert ideal_cdf(emitters, *place, *normal, True, cdf)
    light = contributions(emitters, place, normal)
    np.testing.assert_allclose(np.diff(cdf, prepend=0.0), light / light.sum(), rtol=EXACT)


def test_beyond_the_limit_the_choice_is_by_power_and_still_reaches_everything():
    lamps = tuple(
        lamp((float(k), 0.0, 2.0), 1.0 + k % 3, name=f"lamp {k}") for k in range(LOCAL_CHOICE_LIMIT + 1)
    )
    emitters = collect_emitters(
        lit(box(), materials=[grey("walls", 0.5)], luminaires=lamps), channel_matrix(1)
    )
    place, normal = (0.5, 0.5, 1.0), (0.0, 0.0, 1.0)
    for choose in (
        lambda cdf: ideal_cdf(emitters, *place, *normal, True, cdf),
        lambda cdf: rough_cdf(emitters, *place, *normal, cdf),
    ):
        cdf = np.empty(len(lamps))
        assert choose(cdf)
        np.testing.assert_allclose(
            np.diff(cdf, prepend=0.0), emitters.power / emitters.power.sum(), rtol=1e-6
        )


def test_chosen_draws_with_the_share_that_it_returns():
    cdf = np.cumsum([0.1, 0.0, 0.4, 0.3, 0.2])
    cdf[-1] = 1.0
    drawn = [chosen(cdf, u) for u in np.random.default_rng(2).random(20_000)]
    assert follows(np.bincount([source for source, _ in drawn], minlength=5), np.diff(cdf, prepend=0.0))
    for source, share in drawn[:100]:
        assert share == pytest.approx(np.diff(cdf, prepend=0.0)[source], rel=EXACT)


@pytest.mark.parametrize("place", [(0.5, 0.5, 2.0), (0.2, 0.9, 2.99), (2.9, 0.5, 2.5), (40.0, 30.0, -10.0)])
def test_drawn_light_has_the_closed_form_as_its_expectation(place):
    """One source drawn and weighted by its share and density: the mean is the illuminance, source by source."""
    emitters = made()
    normal = normalised(np.array([0.3, -0.2, 1.0]))
    cdf = np.empty(6)
    assert ideal_cdf(emitters, *place, *normal, True, cdf)
    numbers = np.random.default_rng(3).random((20_000, 3))
    light = np.zeros(len(numbers))
    for k, (choice, u, v) in enumerate(numbers):
        source, share = chosen(cdf, choice)
        direction, _, factor, _ = toward(emitters, source, *place, u, v, OFFSET)
        light[k] = (
            source_strength(emitters, source, 0) * factor / share * max(0.0, float(np.dot(direction, normal)))
        )
    expected = np.zeros(1)
    unblocked(emitters, *place, *normal, expected)
    assert agrees(light[:, None], expected, relative_error=0.01)


def test_shadow_rays_end_off_the_source_on_the_side_that_they_come_from():
    """By the offset along a panel's normal, however flat it is seen, and twice that before a point."""
    emitters = made()
    for place, source, axis, end in (
        ((0.5, 0.5, 2.0), 0, 2, 3.0 - OFFSET),
        ((-9.0, 0.5, 2.999), 0, 2, 3.0 - OFFSET),
        ((2.0, 0.5, 2.5), 2, 0, 3.0 - OFFSET),
        ((4.0, 0.5, 2.5), 2, 0, 3.0 + OFFSET),
        ((1.0, 1.0, 0.0), 4, 2, 2.0 - 2 * OFFSET),
    ):
        assert toward(emitters, source, *place, 0.4, 0.3, OFFSET)[1][axis] == pytest.approx(
            end, abs=1e-3 * OFFSET
        )


def test_unshadowed_is_the_sum_of_lambert_and_inverse_square():
    emitters = made()
    place, normal = np.array([0.5, 0.5, 1.0]), np.array([0.6, 0.0, 0.8])
    expected = sum(
        luminance[0] * triangle_irradiance(corners, *place, *normal)
        for corners, luminance in zip(emitters.corners, emitters.luminance, strict=True)
    )
    for point in POINTS:
        ray = point.position - place
        expected += point.intensity[0] * max(0.0, ray @ normal) / np.linalg.norm(ray) ** 3
    total = np.zeros(1)
    unblocked(emitters, *place, *normal, total)
    assert total[0] == pytest.approx(expected, rel=EXACT)


def test_a_one_sided_panel_gives_nothing_behind_and_a_two_sided_one_the_same_both_ways():
    emitters = made(luminaires=())
    assert contributions(emitters, (0.5, 0.5, 4.0), (0.0, 0.0, -1.0))[:2].sum() == 0.0
    assert not shines(emitters, 0, (0.0, 0.0, -1.0))
    assert shines(emitters, 0, (0.0, 0.0, 1.0))
    assert shines(emitters, 2, (1.0, 0.0, 0.0))
    assert shines(emitters, 2, (-1.0, 0.0, 0.0))
    front = contributions(emitters, (2.0, 0.5, 2.5), (1.0, 0.0, 0.0))[2:]
    back = contributions(emitters, (4.0, 0.5, 2.5), (-1.0, 0.0, 0.0))[2:]
    assert np.all(front > 0.0)
    np.testing.assert_allclose(back, front, rtol=EXACT)


def test_drawn_density_is_share_times_the_density_of_the_triangle():
    emitters = made()
    place = (0.5, 0.5, 2.0)
    cdf = np.linspace(1 / 6, 1, 6)
    direction, _, factor, density = toward(emitters, 1, *place, 0.3, 0.7, OFFSET)
    assert factor == pytest.approx(1 / density, rel=EXACT)
    assert drawn_density(emitters, cdf, 1, *place, direction) == pytest.approx(density / 6, rel=EXACT)


corners_in_space = (
    st.lists(places, min_size=3, max_size=3)
    .map(np.array)
    .filter(lambda corners: np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) > 0.1)
)


@settings(deadline=None)
@given(
    corners=corners_in_space,
    weights=st.sampled_from(
        [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.5, 0), (0.25, 0, 0.75), (0.2, 0.3, 0.5)]
    ),
    shift=st.sampled_from([0.0, 5e6]),
)
def test_a_lamp_gives_no_light_in_its_own_plane_however_it_is_turned(corners, weights, shift):
    """Corners, edges and the inside: all light is the point's, though rounding lifts places off the plane."""
    corners = corners + shift
    triangle = (corners, np.array([[0, 1, 2]]))
    above = corners.mean(axis=0) + np.array([0.0, 0.0, 20.0])
    point = lamp(tuple(above))
    scene = lit(triangle, materials=[MATERIALS[1]], luminaires=(point,))
    emitters = collect_emitters(scene, channel_matrix(1))
    place = np.array(weights) @ corners
    shares = np.empty(2)
    for found in (
        ideal_cdf(emitters, *place, 0.0, 0.0, 1.0, True, shares),
        ideal_cdf(emitters, *place, 0.0, 0.0, 1.0, False, shares),
        rough_cdf(emitters, *place, 0.0, 0.0, 1.0, shares),
    ):
        assert found
        assert np.array_equal(shares, [0.0, 1.0])
    ray = point.position - place
    total = np.zeros(1)
    unblocked(emitters, *place, 0.0, 0.0, 1.0, total)
    assert total[0] == pytest.approx(100.0 * ray[2] / np.linalg.norm(ray) ** 3, rel=EXACT)


def test_a_place_at_a_point_luminaire_gets_finite_light():
    """There the inverse square has no value and the lamp no direction; the other sources count as ever."""
    emitters = made()
    place = POINTS[0].position
    cdf, total = np.empty(6), np.zeros(1)
    for on_surface in (True, False):
        assert ideal_cdf(emitters, *place, 0.0, 0.0, 1.0, on_surface, cdf)
        assert cdf[-1] == 1.0
        assert cdf[4] == cdf[3]
    unblocked(emitters, *place, 0.0, 0.0, 1.0, total)
    others = contributions(emitters, place, (0.0, 0.0, 1.0))
    assert others[4] == 0.0
    assert total[0] == pytest.approx(others.sum(), rel=EXACT)


def test_degenerate_luminous_triangles_give_nothing_and_spoil_nothing():
    sliver = (np.array([[0, 0, 1], [1, 0, 1], [2, 0, 1.0]]), np.array([[0, 1, 2]]))
    materials = [*MATERIALS, Material("sliver", np.zeros(3), luminance=np.ones(3))]
    emitters = collect_emitters(lit(*SHAPES, sliver, materials=materials), channel_matrix(1))
    cdf = np.empty(len(emitters.power))
    for choose in (
        ideal_cdf(emitters, 1.0, 0.5, 0.0, 0.0, 0.0, 1.0, True, cdf),
        rough_cdf(emitters, 1.0, 0.5, 0.0, 0.0, 0.0, 1.0, cdf),
    ):
        assert choose
        assert np.all(np.isfinite(cdf))
