"""Glare from known emitters: position index, solid angles, UGR."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lelight.metrics.cie117 import GlareSource, glare_sources, point_source, ugr
from lelight.metrics.exceptional import exceptional_figures
from lelight.metrics.glare import observer_figures
from lelight.metrics.guth_table import POSITION_INDEX
from lelight.metrics.opening import EmitterPatch, cells, solid_angles
from lelight.metrics.outdoor import outdoor_figures
from lelight.metrics.position import (
    below_line_of_sight,
    guth,
    guth_table,
    inside_table,
    position_index,
    sight_coordinates,
)
from lelight.metrics.sweep import largest, rose
from lelight.results import ObserverValues
from lelight.scene import Observer, Outdoor, PointLuminaire

EXACT = 1e-9
OBSERVER = Observer("eye", np.array([0.0, 0.0, 1.2]), np.array([0.0, 1.0, 0.0]))


def everything(origins, targets):
    return np.ones(len(targets), dtype=bool)


# R, T, H and the index by closed form and by table, to the printed digits.
VECTORS = [
    (1, 0, 0.5, 2.8602, 2.86),
    (3, 1, 2, 3.7844, 3.6889),
    (5, 1, 2, 2.2141, 2.2000),
    (10, 2, 2, 1.4868, 1.5000),
    (4, 0, 1.6, 2.3178, 2.3500),
    (2, 2, 1, 3.7625, 3.9100),
    (6, 3, 1.8, 2.0895, 2.1000),
    (3, 0, 0, 1.0, 1.0),
]


@pytest.mark.parametrize(("r", "t", "h", "closed", "table"), VECTORS)
def test_guth_index(r, t, h, closed, table):
    for side in (t, -t):
        assert guth(np.array([r, side, h], float)) == pytest.approx(closed, abs=5e-5)
        assert guth_table(np.array([r, side, h], float)) == pytest.approx(table, abs=5e-5)


def test_guth_table_has_its_corners_and_its_blanks():
    corners = [
        (0, 0, 1.0),
        (0, 0.5, 2.86),
        (0, 1, 7.0),
        (1, 0, 2.11),
        (1, 1, 7.0),
        (2, 1.5, 12.85),
        (3, 0, 4.22),
    ]
    for t, h, index in [*corners, (3, 1.9, 16.0), (0.4, 1.8, 16.0), (0, 1.7, 16.2)]:
        assert guth_table(np.array([1, t, h], float)) == pytest.approx(index, rel=EXACT)
    blank = np.isnan(POSITION_INDEX)
    assert blank[:, 18].tolist() == [True] * 4 + [False] * 27
    assert blank[:, 19].tolist() == [True] * 9 + [False] * 22
    assert not blank[:, :18].any()


def test_the_misprint_is_kept():
    assert POSITION_INDEX[27, 6] == 7.50
    assert (POSITION_INDEX[26, 6] + POSITION_INDEX[28, 6]) / 2 == pytest.approx(7.04, abs=5e-3)


def test_closed_form_stays_near_the_table():
    # Over the whole table -10.0 % to +10.6 %, rms 4.9 %.
    rows, columns = np.indices(POSITION_INDEX.shape) / 10
    closed = guth(np.stack([np.ones_like(rows), rows, columns], axis=-1))
    off = (closed / POSITION_INDEX - 1)[np.isfinite(POSITION_INDEX)]
    assert (100 * off.min(), 100 * off.max()) == pytest.approx((-10.0, 10.6), abs=0.05)
    assert 100 * math.sqrt(np.mean(off**2)) == pytest.approx(4.9, abs=0.05)


@pytest.mark.parametrize(
    ("r", "t", "h", "inside"),
    [
        (1, 3, 1.9, True),
        (1, 3.01, 1, False),
        (1, 1, 1.91, False),
        (1, 0, 1.75, False),  # next to the blank entries
        (1, 0.8, 1.9, False),
        (10, 3, 1, True),
        (-1, 0, 0.5, False),
        (0, 1, 1, False),
        (1, 0, -0.1, False),
    ],
)
def test_field_of_the_table(r, t, h, inside):
    assert inside_table(np.array([r, t, h], float)) == inside


def seen(azimuth, elevation):
    az, el = np.radians([azimuth, elevation])
    return np.array([np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)])


@pytest.mark.parametrize(
    ("azimuth", "elevation", "index"),
    [
        (0, 10, 1.4345),
        (0, 50, 9.2442),
        (20, 10, 1.5963),
        (45, 45, 11.0137),
        (60, 5, 3.7160),
        (0, -10, 1.1074),
        (0, -50, 2.6102),
        (20, -10, 1.2960),
        (45, -45, 3.3913),
        (60, -5, 3.1603),
        (80, 0.5, 6.5902),
    ],
)
def test_index_over_the_whole_field(azimuth, elevation, index):
    assert position_index(seen(azimuth, elevation)) == pytest.approx(index, abs=5e-5)
    assert position_index(seen(-azimuth, elevation)) == pytest.approx(index, abs=5e-5)


def test_index_is_capped_above_and_one_on_the_line_of_sight():
    assert position_index(seen(0, 89)) == 16.0
    assert below_line_of_sight(seen(0, 0)) == 1.0


@given(st.floats(0, 2 * math.pi), st.floats(-1.5, 1.5), st.floats(0, 2 * math.pi))
def test_sight_coordinates_turn_with_the_observer(azimuth, elevation, bearing):
    # An observer turned about z sees a source turned with it at the same place, and right is clockwise from
    # above.
    def horizontal(angle):
        return np.array([np.sin(angle), np.cos(angle), 0.0])

    observer = Observer("eye", np.zeros(3), horizontal(bearing))
    source = np.cos(elevation) * horizontal(bearing + azimuth) + [0, 0, np.sin(elevation)]
    expected = [
        np.cos(elevation) * np.cos(azimuth),
        np.cos(elevation) * np.sin(azimuth),
        np.sin(elevation),
    ]
    np.testing.assert_allclose(sight_coordinates(source, observer), expected, atol=1e-12)


def test_a_vertical_line_of_sight_has_a_frame():
    down = Observer("eye", np.zeros(3), np.array([0.0, 0.0, -2.0]))
    np.testing.assert_allclose(sight_coordinates(np.array([0.0, 0.0, -1.0]), down), [1, 0, 0], atol=EXACT)


# Six horizontal panels 0.6 m x 0.6 m of 3000 cd/m², 1.6 m above the eye, at T = ±1.2 m; background 30 cd/m².
# R, solid angle A cos / r², index by closed form and by table.
PANELS = [
    (2.0, 0.02545584412271571, 4.941581891644509, 4.8),
    (4.0, 0.006439875775199394, 2.2521869850906175, 2.25),
    (6.0, 0.002276839915321233, 1.6875024399887892, 1.7),
]


def panel_sources(index):
    sources = []
    for r, omega, *_ in PANELS:
        for t in (-1.2, 1.2):
            coordinates = np.array([r, t, 1.6])
            direction = coordinates / np.linalg.norm(coordinates)
            sources.append(
                GlareSource("panel", 3000.0, omega, direction, 1.0, abs(t) / r, 1.6 / r, index(coordinates))
            )
    return sources


@pytest.mark.parametrize(
    ("index", "column", "rating"), [(guth, 2, 21.35260241230295), (guth_table, 3, 21.41145901257573)]
)
def test_ugr_of_six_panels(index, column, rating):
    sources = panel_sources(index)
    assert [source.position_index for source in sources[::2]] == pytest.approx(
        [panel[column] for panel in PANELS], rel=EXACT
    )
    assert ugr(sources, 30.0) == pytest.approx(rating, rel=EXACT)


def test_terms_of_six_panels():
    terms = [source.glare for source in panel_sources(guth)[::2]]
    assert terms == pytest.approx([9382.055952207067, 11426.444392956571, 7195.917688358051], rel=EXACT)


def rectangle(centre, half_u, half_v):
    """Two triangles, front towards half_u x half_v."""
    centre, half_u, half_v = (np.asarray(part, float) for part in (centre, half_u, half_v))
    a, b, c, d = (centre + i * half_u + j * half_v for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
    return np.array([[a, b, c], [a, c, d]])


def panel(r, t, *, height=2.8, half=0.3):
    """Horizontal, shining down."""
    return rectangle([t, r, height], [half, 0, 0], [0, -half, 0])


def test_six_panels_from_their_geometry():
    emitters = [EmitterPatch("panel", panel(r, t), 3000.0) for r, *_ in PANELS for t in (-1.2, 1.2)]
    sources = glare_sources(emitters, OBSERVER, everything)
    assert all(not source.excluded for source in sources)
    for emitter, source in zip(emitters, sources, strict=True):
        omega, direction = quadrature(emitter.corners)
        assert source.solid_angle == pytest.approx(omega, rel=1e-6)
        # 64 cells of solid angle: the centroid moves by the cells' curvature only.
        np.testing.assert_allclose(source.direction, direction, atol=2e-4)
        assert source.visible_fraction == 1.0
    # Extended sources against point-like ones: 2 % of solid angle in the nearest pair is below 0.1 UGR.
    assert ugr(sources, 30.0) == pytest.approx(21.353, abs=0.1)


def quadrature(corners, count=400):
    """Solid angle and centroid of a rectangle by the midpoint rule, independent of the formula under test."""
    a, b, d = corners[0, 0], corners[0, 1], corners[1, 2]
    steps = (np.arange(count) + 0.5) / count
    points = a + steps[:, None, None] * (b - a) + steps[None, :, None] * (d - a) - OBSERVER.position
    normal = np.cross(b - a, d - a)
    distance = np.linalg.norm(points, axis=-1, keepdims=True)
    omega = np.abs(points @ normal)[..., None] / distance**3 / count**2
    centroid = (omega * points / distance).sum(axis=(0, 1))
    return float(omega.sum()), centroid / np.linalg.norm(centroid)


@given(st.floats(0.01, 50), st.floats(0.01, 50), st.floats(0.01, 50))
def test_solid_angle_of_a_rectangle(half_a, half_b, height):
    # Centred pyramid: ω = 4 asin(a b / sqrt((a² + h²)(b² + h²))).
    corners = rectangle([0, 0, height], [half_a, 0, 0], [0, -half_b, 0])
    expected = 4 * math.asin(half_a * half_b / math.sqrt((half_a**2 + height**2) * (half_b**2 + height**2)))
    assert solid_angles(corners, np.zeros(3)).sum() == pytest.approx(expected, rel=1e-7)
    assert solid_angles(corners[:, ::-1], np.zeros(3)).sum() == pytest.approx(-expected, rel=1e-7)


def test_solid_angles_of_a_closed_box_add_up():
    sides = [rectangle(n, np.roll(n, 1), np.roll(n, 2)) for n in np.concatenate([np.eye(3), -np.eye(3)])]
    omega = solid_angles(np.concatenate(sides), np.array([0.3, -0.2, 0.6]))
    assert np.abs(omega).sum() == pytest.approx(4 * math.pi, rel=EXACT)


def test_edge_on_and_touching_triangles_have_no_solid_angle():
    corners = panel(0.0, 0.0, height=0.0)
    assert solid_angles(corners, np.array([5.0, 0.0, 0.0])).tolist() == [0.0, 0.0]
    assert solid_angles(corners, np.array([0.1, 0.05, 0.0])).tolist() == [0.0, 0.0]
    assert solid_angles(corners, corners[0, 0]).tolist() == [0.0, 0.0]


def test_cells_are_fine_and_lose_nothing():
    patch = EmitterPatch("strip", panel(2.0, 0.0), 1.0)
    shining = cells(patch, OBSERVER.position, forward=OBSERVER.direction)
    assert len(shining.solid_angles) >= 64
    assert shining.solid_angles.max() <= shining.solid_angle / 64
    whole = solid_angles(patch.corners, OBSERVER.position).sum()
    assert shining.solid_angle == pytest.approx(whole, rel=EXACT)


def test_an_eye_just_below_a_ceiling_sees_the_upper_front_quarter_of_the_sphere():
    # That quarter has π sr (less the gap at the horizon) and its centroid 45 degrees up. Cells of π/64 sr
    # are 13 degrees across; each is taken at its own middle, which moves the whole by a tenth of that.
    source = one(rectangle([0, 0, 1.2 + 1e-4], [50, 0, 0], [0, -50, 0]))
    assert source.solid_angle == pytest.approx(math.pi, rel=1e-5)
    assert math.degrees(math.asin(source.direction[2])) == pytest.approx(45.0, abs=1.3)


@pytest.mark.parametrize("turn", [0, 1, 2])
def test_only_the_part_ahead_of_the_eye_shines(turn):
    # A panel centred above the eye: exactly half of it is ahead. One triangle has one corner ahead, the
    # other two.
    corners = np.roll(panel(0.0, 0.0, half=0.5), turn, axis=1)
    shining = cells(EmitterPatch("above", corners, 1.0), OBSERVER.position, forward=OBSERVER.direction)
    whole = solid_angles(corners, OBSERVER.position).sum()
    assert shining.solid_angle == pytest.approx(whole / 2, rel=EXACT)
    assert (shining.centres[:, 1] > 0).all()


def one(corners, *, visible=everything, **more):
    (source,) = glare_sources([EmitterPatch("lamp", corners, 5000.0, **more)], OBSERVER, visible)
    return source


@pytest.mark.parametrize(
    ("corners", "reason"),
    [
        (panel(-3.0, 0.0), "behind"),
        (panel(2.0, 0.0)[:, ::-1], "dark side"),
        (panel(0.5, 0.0), "outside the field"),  # H/R = 3.2
        (panel(1.0, 3.5), "outside the field"),  # T/R = 3.5
        (panel(2.0, 0.0, height=0.0)[:, ::-1], "below the line of sight"),
    ],
)
def test_exclusions_state_their_reason(corners, reason):
    source = one(corners)
    assert reason in source.excluded
    assert (source.position_index, source.glare) == (None, 0.0)


def test_a_two_sided_panel_shines_from_its_back():
    assert not one(panel(2.0, 0.0)[:, ::-1], sides="both").excluded


def test_a_hidden_panel_does_not_count():
    source = one(panel(2.0, 0.0), visible=lambda origins, targets: np.zeros(len(targets), dtype=bool))
    assert (source.excluded, source.solid_angle, source.visible_fraction) == ("not visible", 0.0, 0.0)


def test_a_half_hidden_panel_counts_by_what_is_seen():
    # The right half is covered: by symmetry half of the solid angle is left, and its centroid lies to the
    # left.
    whole = one(panel(2.0, 0.0))
    half = one(panel(2.0, 0.0), visible=lambda origins, targets: targets[:, 0] < 0)
    assert half.visible_fraction == pytest.approx(0.5, abs=1 / 64)
    assert half.solid_angle == pytest.approx(whole.solid_angle * half.visible_fraction, rel=EXACT)
    assert half.direction[0] < -0.03
    assert abs(whole.direction[0]) < 1e-3


def test_flags_do_not_exclude():
    large = one(panel(3.0, 0.0, half=0.8))
    assert large.position_index is not None
    assert large.projected_area == pytest.approx(1.6**2 * 1.6 / math.hypot(3.0, 1.6), rel=0.05)
    assert large.solid_angle > 0.1
    assert any("0.1 sr" in flag for flag in large.flags)
    small = one(panel(3.0, 0.0, half=0.02))
    assert any("too severely" in flag for flag in small.flags)
    assert any("3e-4" in flag for flag in small.flags)
    assert any("too leniently" in flag for flag in one(panel(4.0, 0.0, half=1.5)).flags)
    assert one(panel(4.0, 0.0)).flags == ()


def test_a_point_luminaire_has_no_rating():
    source = point_source(PointLuminaire("P", np.array([0.0, 2.0, 2.0]), np.ones(3)), OBSERVER)
    assert "point source" in source.excluded
    assert source.glare == 0.0
    assert (source.t_over_r, source.h_over_r) == (pytest.approx(0.0), pytest.approx(0.4))


def test_ugr_without_sources_or_background():
    assert ugr([], 30.0) is None
    with pytest.raises(ValueError, match="background_luminance"):
        ugr(panel_sources(guth), 0.0)


@pytest.mark.parametrize("luminance", [-1.0, math.nan, math.inf])
def test_an_opening_without_a_luminance_is_refused(luminance):
    with pytest.raises(ValueError, match="luminance"):
        EmitterPatch("lamp", panel(2.0, 0.0), luminance)


def at_eye(indirect):
    batches = np.asarray(indirect, float)
    return ObserverValues(OBSERVER, 50.0, float(batches.mean()), batches)


def test_observer_figures_and_their_error():
    indirect = 30 * math.pi * np.array([0.98, 1.0, 1.02])
    figures = observer_figures(at_eye(indirect), panel_sources(guth), target_ugr=22.0)
    assert figures["ugr"].value == pytest.approx(21.35260241230295, rel=EXACT)
    # d UGR = -8 / ln 10 · dE / E; the mean of three batches with s = 2 % has 2 % / sqrt(3). Curvature is
    # 1e-3 of it.
    assert figures["ugr"].std_error == pytest.approx(8 / math.log(10) * 0.02 / math.sqrt(3), rel=1e-3)
    # t(0.975, 2) · 0.0401 = 0.17: 21.35 clears 22 and not 21.4.
    assert figures["ugr"].verdict == "pass"
    assert figures["background_luminance"].value == pytest.approx(30.0, rel=EXACT)
    assert figures["vertical_illuminance"].value == pytest.approx(50 + 30 * math.pi, rel=EXACT)
    close = observer_figures(at_eye(indirect), panel_sources(guth), target_ugr=21.4)
    assert close["ugr"].verdict == "undecided"
    assert observer_figures(at_eye(indirect), panel_sources(guth), target_ugr=19)["ugr"].verdict == "fail"


def test_no_source_passes_and_no_background_is_undecided():
    nothing = observer_figures(at_eye([10.0, 11.0]), [], target_ugr=19.0)["ugr"]
    assert (nothing.value, nothing.verdict) == (None, "pass")
    assert "no glare source" in nothing.note
    black = observer_figures(at_eye([0.0, 0.0]), panel_sources(guth), target_ugr=19.0)["ugr"]
    assert (black.value, black.verdict) == (None, "undecided")
    assert "indirect" in black.note


def test_the_worked_example_as_a_figure():
    # Lb = 30 cd/m² from an indirect illuminance of 30 π lx, without noise: exactly the rating of the example.
    indirect = np.full(8, 30 * math.pi)
    at_eye = ObserverValues(OBSERVER, 0.0, 30 * math.pi, indirect)
    figures = observer_figures(at_eye, panel_sources(guth), target_ugr=22.0)
    assert figures["background_luminance"].value == pytest.approx(30.0, rel=EXACT)
    assert figures["ugr"].value == pytest.approx(21.35260241230295, rel=EXACT)
    assert figures["ugr"].verdict == "pass"


def test_small_large_and_uniform_sources_are_rated_beside():
    indirect = np.array([0.99, 1.0, 1.01, 1.0]) * 100
    at_eye = ObserverValues(OBSERVER, 200.0, 100.0, indirect)
    plain = exceptional_figures(at_eye, panel_sources(guth), ceiling_coverage=0.3)
    assert plain["ugr_small_sources"].value is None and "does not apply" in plain["ggr"].note
    assert plain["ugr_non_uniform"].value == pytest.approx(ugr(panel_sources(guth), 100 / math.pi), rel=EXACT)
    small = GlareSource("s", 5e5, 1e-3 / 9, np.array([0, 1.0, 0]), 1.0, 0.0, 0.0, 4.0, projected_area=1e-3)
    # I = 500 cd at 3 m and p = 4, as in the example of CIE 147: L² ω becomes 200 I² / r².
    rated = exceptional_figures(at_eye, [small], ceiling_coverage=0.3)["ugr_small_sources"]
    expected = 8 * math.log10(0.25 * math.pi / 100 * 5555555.555555556 / 16)
    assert rated.value == pytest.approx(expected, rel=EXACT)
    large = GlareSource("l", 3000.0, 0.2, np.array([0, 1.0, 0]), 1.0, 0.0, 0.0, 2.0, projected_area=2.0)
    great = exceptional_figures(at_eye, [large], ceiling_coverage=0.5)["ggr"]
    base = ugr([large], 100 / math.pi)
    contrast = 2.55 * (1 + 200 / 220) / (1 + 200 / 100)
    assert great.value == pytest.approx(base + (1.18 - 0.36) * 8 * math.log10(contrast), rel=EXACT)
    assert exceptional_figures(at_eye, [large], ceiling_coverage=0.1)["ggr"].value is None


def test_the_largest_of_a_rose():
    indirect = np.tile(np.array([[99.0], [101.0], [100.0], [100.0]]), (1, 24))
    seen = [()] * 24
    seen[3], seen[7] = tuple(panel_sources(guth)), tuple(panel_sources(guth)[:2])
    petals = rose(seen, indirect)
    assert petals[0]["ugr"] is None and petals[3]["turn"] == 45.0
    worst = largest(petals, batches=4, target=19.0)
    assert worst.value == pytest.approx(ugr(panel_sources(guth), 100 / math.pi), rel=EXACT)
    assert worst.verdict == "fail" and "45°" in worst.note
    none = largest(rose([()] * 24, indirect), batches=4, target=19.0)
    assert (none.value, none.verdict) == (None, "pass")


@pytest.mark.parametrize(("direction", "defined"), [((0.0, 1.0, -0.1), True), ((0.0, 1.0, 0.0), False)])
def test_outdoor_rating_needs_a_view_down(direction, defined):
    sight = np.array(direction) / np.linalg.norm(direction)
    observer = Observer("eye", np.zeros(3), sight)
    # One source 10 degrees above the line of sight.
    up = np.array([0.0, -sight[2], sight[1]])
    towards = math.cos(math.radians(10)) * sight + math.sin(math.radians(10)) * up
    ground = np.array([[290.0], [300.0], [310.0]])
    figures = outdoor_figures(observer, np.array([15.0]), towards[None], ground, Outdoor("g", 0.25))
    assert (figures["gr"].value is not None) == defined
    if defined:
        veil = 0.035 * 0.25 * 300 / math.pi
        assert figures["gr"].value == pytest.approx(27 + 24 * math.log10(10 * 15 / 100 / veil**0.9), rel=1e-9)
        assert figures["gr"].std_error > 0
