"""Measuring planes: grids of EN 12464-1 and the figures on them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lelight.metrics.en12464 import plane_figures
from lelight.metrics.grid import cell_counts, grid_points, grid_spacing
from lelight.metrics.room import room_figures
from lelight.results import PlaneValues
from lelight.scene import MeasuringPlane

EXACT = 1e-9

#: d in m, p in m, n = next integer of d / p, computed from p = 0.2 · 5^(log10 d).
SPACINGS = [
    (0.4, 0.10541001280202492, 4),
    (0.6, 0.13994725170678643, 5),
    (1, 0.2, 5),
    (2, 0.3246690819927653, 7),
    (3, 0.4310458231742096, 7),
    (4, 0.5270500640101247, 8),
    (5, 0.6160118443445031, 9),
    (6, 0.6997362585339322, 9),
    (8, 0.8555843022319766, 10),
    (10, 1.0, 10),
    (15, 1.327646662652697, 12),
    (20, 1.6233454099638263, 13),
    (25, 1.8973529618635816, 14),
    (50, 3.0800592217225153, 17),
    (100, 5.0, 20),
]


def plane(u, v, **target) -> MeasuringPlane:
    return MeasuringPlane("p", np.array([1.0, 2.0, 0.75]), np.array(u, float), np.array(v, float), target)


@pytest.mark.parametrize(("d", "spacing", "count"), SPACINGS)
def test_spacing_of_the_standard(d, spacing, count):
    assert grid_spacing(d) == pytest.approx(spacing, rel=EXACT)
    assert cell_counts(d, d) == (count, count)


def test_spacing_ends_at_ten_metres():
    # 0.2 · 5^(log10 d) = 10 at d = 10^(log 50 / log 5) = 269.7 m.
    assert grid_spacing(269.0) < 10.0
    assert grid_spacing(1000.0) == 10.0
    assert cell_counts(1000.0, 1000.0) == (100, 100)


def test_the_shorter_side_rules_long_rectangles():
    # 9 x 7: d = 9, p = 0.9290, n = 10 and 8. 8 x 4 (2:1): d = 4, p = 0.5271, n = 16 and 8; 7.9 x 4: d =
    # 7.9, p = 0.8481.
    assert cell_counts(9.0, 7.0) == (10, 8)
    assert cell_counts(8.0, 4.0) == (16, 8)
    assert cell_counts(4.0, 8.0) == (8, 16)
    assert cell_counts(7.9, 4.0) == (10, 5)


@given(st.floats(1e-3, 300.0), st.floats(1.0, 50.0))
def test_cells_are_no_larger_than_p_and_no_longer_than_two_to_one(shorter, elongation):
    longer = shorter * elongation
    columns, rows = cell_counts(longer, shorter)
    cell_u, cell_v = longer / columns, shorter / rows
    spacing = grid_spacing(shorter if elongation >= 2 else longer)
    assert max(cell_u, cell_v) <= spacing * (1 + 1e-6)
    assert 0.5 - 1e-6 <= cell_u / cell_v <= 2 + 1e-6


def test_grid_points_are_cell_centres_row_by_row():
    points, shape = grid_points(plane([9, 0, 0], [0, 7, 0]))
    assert shape == (8, 10)
    assert points.shape == (80, 3)
    np.testing.assert_allclose(points[0], [1 + 0.45, 2 + 7 / 16, 0.75], rtol=EXACT)
    np.testing.assert_allclose(points[1] - points[0], [0.9, 0, 0], atol=EXACT)
    np.testing.assert_allclose(points[10] - points[0], [0, 7 / 8, 0], atol=EXACT)
    np.testing.assert_allclose(points.mean(axis=0), [5.5, 5.5, 0.75], rtol=EXACT)


@pytest.mark.parametrize("edge", [[0, 0, 0], [math.nan, 0, 0], [math.inf, 0, 0]])
def test_a_plane_without_extent_is_refused(edge):
    with pytest.raises(ValueError, match="positive length"):
        grid_points(plane(edge, [0, 7, 0]))


def values(where, illuminance, cylindrical=None, noise=0.0):
    base = np.asarray(illuminance, float)
    shares = 1 + noise * np.array([-1.0, 0.0, 1.0])
    replicates = shares[:, None] * base
    tubes = shares[:, None] * np.asarray(base if cylindrical is None else cylindrical, float)
    points = np.zeros((base.size, 3))
    return PlaneValues(
        where, (1, base.size), points, base, np.zeros(base.size), tubes.mean(axis=0), replicates, tubes
    )


def test_plane_figures_of_four_points():
    # E = 400, 500, 500, 600: Em 500, U0 0.8, Ud 2/3. All points move together by ±1 %: s = 5 lx, error 5 /
    # sqrt(3) lx; the ratios do not move at all.
    where = plane([2, 0, 0], [0, 1, 0], mean_illuminance=480.0, uniformity=0.6)
    figures = plane_figures(values(where, [400, 500, 500, 600], [200, 200, 100, 100], noise=0.01))
    assert list(figures) == [
        "mean_illuminance",
        "min_illuminance",
        "max_illuminance",
        "uniformity",
        "diversity",
        "mean_cylindrical_illuminance",
        "modelling",
    ]
    expected = [500, 400, 600, 0.8, 2 / 3, 150, 0.3]
    assert [figure.value for figure in figures.values()] == pytest.approx(expected, rel=EXACT)
    assert figures["mean_illuminance"].std_error == pytest.approx(5 / math.sqrt(3), rel=EXACT)
    assert figures["uniformity"].std_error == pytest.approx(0.0, abs=EXACT)
    # t(0.975, 2) = 4.303: 500 ± 12.4 clears 480.
    assert figures["mean_illuminance"].verdict == "pass"
    assert figures["uniformity"].verdict == "pass"
    assert figures["modelling"].verdict is None


def test_verdicts_of_a_plane_follow_its_error():
    where = plane([2, 0, 0], [0, 1, 0], mean_illuminance=500.0, uniformity=0.9)
    figures = plane_figures(values(where, [400, 500, 500, 600], noise=0.01))
    assert figures["mean_illuminance"].verdict == "undecided"
    assert figures["uniformity"].verdict == "fail"


@pytest.mark.parametrize(
    ("zenith", "modelling"), [(30, 0.18377629847), (45, 0.31830988618), (60, 0.55132889542)]
)
def test_modelling_of_a_beam(zenith, modelling):
    # Beam of E_perp = 1: Eh = cos z, Ez = sin z / π, so Ez / Eh = tan z / π.
    angle = math.radians(zenith)
    figures = plane_figures(
        values(plane([1, 0, 0], [0, 1, 0]), [math.cos(angle)], [math.sin(angle) / math.pi])
    )
    assert figures["modelling"].value == pytest.approx(modelling, rel=EXACT)


def test_a_dark_plane_has_no_uniformity_and_a_wall_no_modelling():
    dark = plane_figures(values(plane([1, 0, 0], [0, 1, 0], uniformity=0.6), [0, 0]))
    assert dark["mean_illuminance"].value == 0
    assert (dark["uniformity"].value, dark["uniformity"].verdict) == (None, "undecided")
    assert "no light" in dark["uniformity"].note
    wall = plane_figures(values(plane([1, 0, 0], [0, 0, 1]), [10, 20]))
    assert wall["modelling"].value is None
    assert "face up" in wall["modelling"].note


def test_replicates_with_nan_are_refused():
    with pytest.raises(ValueError, match="plane 'p' must be finite"):
        plane_figures(values(plane([1, 0, 0], [0, 1, 0]), [10, math.nan]))


def test_room_figures_leave_hidden_nodes_out():
    # Visible: 2 m² at 100 lx, rho 0.5; 6 m² at 20 lx, rho 0.25. E = 320/8 = 40 lx, M = (100 + 30)/8 = 16.25
    # lm/m².
    areas = np.array([2.0, 6.0, 50.0])
    illuminance = np.array([100.0, 20.0, 0.0])
    exitance = np.array([50.0, 5.0, 0.0])
    hidden = np.array([False, False, True])
    figures = room_figures(areas, illuminance, exitance, hidden)
    assert figures["mean_surface_illuminance"].value == pytest.approx(40.0, rel=EXACT)
    assert figures["mean_room_surface_exitance"].value == pytest.approx(16.25, rel=EXACT)
    assert figures["mean_room_surface_exitance"].std_error is None


def test_room_errors_come_from_the_batches():
    areas, illuminance = np.array([1.0, 1.0]), np.array([10.0, 10.0])
    batches = illuminance + np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])
    figures = room_figures(areas, illuminance, np.array([5.0, 0.0]), np.array([False, False]), batches)
    # Mean illuminance by batch 9.5, 10.5, 10: s = 0.5; exitance 2.25, 2.75, 2.5: s = 0.25.
    assert figures["mean_surface_illuminance"].std_error == pytest.approx(0.5 / math.sqrt(3), rel=EXACT)
    assert figures["mean_room_surface_exitance"].std_error == pytest.approx(0.25 / math.sqrt(3), rel=EXACT)


def test_a_room_without_lit_surfaces_has_no_averages():
    none = np.array([True])
    figures = room_figures(np.ones(1), np.ones(1), np.ones(1), none)
    assert figures["mean_room_surface_exitance"].value is None
