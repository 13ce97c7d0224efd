"""Replicates to means and errors, and when a run stops, on made-up numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lelight.estimate.blocks import Batch
from lelight.estimate.replicates import ErrorReached, Replicates, error_reached, pooled_error
from lelight.estimate.schedule import next_step
from lelight.receivers import ILLUMINANCE, MOMENTS

EXACT = 1e-9


def batch(direct, indirect, *, angular=1.0):
    """A batch of grey illuminances (r,)."""
    moments = []
    for light in (direct, indirect):
        values = np.zeros((len(light), MOMENTS, 1))
        values[:, ILLUMINANCE, 0] = light
        moments.append(values)
    return Batch(*moments, np.full((1, 4, 1), angular), vertices=3, rays=10, seconds={"chains": 0.5})


def grow(replicates, step, batches):
    """Take a step's batches, as a run does; with the last of them the step is over."""
    replicates.start(step)
    for each in batches:
        replicates.take(each)
    assert replicates.step is None


def test_totals_means_and_errors_are_those_of_all_replicates():
    """Three receivers, two replicates; the standard error of two values a, b is |a - b| / 2."""
    replicates = Replicates(first_in_space=2)
    grow(replicates, "append", [batch([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], angular=1.0)])
    assert np.all(np.isinf(replicates.std_error))
    grow(replicates, "append", [batch([3.0, 2.0, 1.0], [5.0, 5.0, 4.0], angular=2.0)])
    assert np.array_equal(replicates.direct[:, ILLUMINANCE, 0], [4.0, 4.0, 4.0])
    assert np.array_equal(replicates.indirect[:, ILLUMINANCE, 0], [9.0, 10.0, 10.0])
    assert np.all(replicates.angular == 3.0)
    np.testing.assert_allclose(replicates.mean, [6.5, 7.0, 7.0], rtol=EXACT)
    np.testing.assert_allclose(replicates.std_error, [1.5, 0.0, 2.0], rtol=EXACT)
    assert (replicates.count, replicates.vertices, replicates.rays) == (2, 6, 20)
    assert replicates.seconds == {"chains": 1.0}
    assert np.array_equal(np.array(replicates.in_space)[:, :, ILLUMINANCE], [[9.0], [5.0]])
    assert np.array_equal(np.array(replicates.indirect_in_space)[:, :, ILLUMINANCE], [[6.0], [4.0]])
    assert np.array_equal(replicates.at_nodes, [[5.0, 7.0], [8.0, 7.0]])


def stretch_of(replicate, doubling):
    """What a replicate finds in its start (0) or one of its doublings, as made-up numbers."""
    light = np.random.default_rng((replicate, doubling)).uniform(1.0, 2.0, size=(2, 3))
    return batch(light[0], light[1], angular=light[0, 0])


def test_every_point_of_a_doubled_sequence_has_the_same_weight():
    """Start, first and second doubling hold 1, 1 and 2 parts of the points."""
    replicates = Replicates(first_in_space=3)
    for r in range(2):
        grow(replicates, "append", [stretch_of(r, 0)])
    grow(replicates, "double", [stretch_of(r, 1) for r in range(2)])
    grow(replicates, "double", [stretch_of(r, 2) for r in range(2)])
    grow(replicates, "append", [stretch_of(2, k) for k in range(3)])
    assert (replicates.count, replicates.doublings) == (3, 2)
    means = [
        sum(share * stretch_of(r, k).direct for k, share in enumerate((0.25, 0.25, 0.5))) for r in range(3)
    ]
    np.testing.assert_allclose(replicates.direct, sum(means), rtol=EXACT)
    totals = [
        sum(
            share * (stretch_of(r, k).direct + stretch_of(r, k).indirect)[:, ILLUMINANCE, 0]
            for k, share in enumerate((0.25, 0.25, 0.5))
        )
        for r in range(3)
    ]
    np.testing.assert_allclose(replicates.at_nodes, totals, rtol=EXACT)
    np.testing.assert_allclose(replicates.std_error, np.std(totals, axis=0, ddof=1) / np.sqrt(3), rtol=EXACT)


@given(st.lists(st.floats(-1, 1), min_size=2, max_size=30), st.sampled_from([0.0, 1e9]))
def test_the_error_is_that_of_the_list_even_far_from_zero(deviations, offset):
    light = np.array(deviations) + offset
    replicates = Replicates(first_in_space=1)
    for value in light:
        grow(replicates, "append", [batch([value], [0.0])])
    expected = light.std(ddof=1) / np.sqrt(len(light))
    # Rounding of the values themselves is all that may differ.
    assert replicates.std_error[0] == pytest.approx(expected, rel=1e-7, abs=1e-15 * offset + 1e-12)
    assert replicates.mean[0] == pytest.approx(light.mean(), rel=1e-12, abs=1e-12)


def test_a_target_is_met_when_the_mean_and_the_worst_of_the_area_are():
    assert ErrorReached(0.02, 0.06, 0.10).in_targets(0.02) == pytest.approx(1.0, rel=EXACT)
    assert ErrorReached(0.01, 0.06, 0.05).in_targets(0.01) == pytest.approx(2.0, rel=EXACT)
    assert ErrorReached(0.01, 0.01, 0.15).in_targets(0.01) == pytest.approx(3.0, rel=EXACT)


@pytest.mark.parametrize(
    ("replicates", "given", "step"),
    [
        (0, {}, "append"),
        (7, {"missing": 0.0, "room": 0.0}, "append"),
        (8, {"missing": 2.5}, "double"),
        (8, {"missing": 0.4}, "append"),
        (9, {"missing": -0.1}, "stop"),
        (8, {"room": 1.2}, "double"),
        (8, {"room": 0.5}, "append"),
        (8, {"room": 0.1}, "stop"),
        (8, {"missing": 3.0, "room": 0.5}, "append"),
        (3, {"exactly": 4}, "append"),
        (4, {"exactly": 4, "missing": 5.0}, "stop"),
    ],
)
def test_a_run_doubles_while_far_from_its_end_and_adds_replicates_near_it(replicates, given, step):
    assert next_step(replicates, **given) == step


def test_error_reached_is_weighted_by_area_and_measures_dark_nodes_against_the_mean():
    """Mean (1 x 100 + 3 x 20) / 4 = 40; nodes at 100 +- 5, 20 +- 2: 5 % on 1 m², 10 % on 3 m²."""
    error = error_reached(np.array([100.0, 20.0]), np.array([5.0, 2.0]), areas=np.array([1.0, 3.0]))
    assert error.rms == pytest.approx(np.sqrt((0.05**2 + 3 * 0.1**2) / 4), rel=EXACT)
    assert error.p95 == error.p99 == pytest.approx(0.1, rel=EXACT)
    # A dark node of 1 lx: its 0.5 lx count against 5 % of the mean, (100 + 1) / 2 x 0.05 = 2.525 lx.
    dark = error_reached(np.array([100.0, 1.0]), np.array([0.0, 0.5]), areas=np.ones(2))
    assert dark.p99 == pytest.approx(0.5 / 2.525, rel=EXACT)
    assert dark.rms == pytest.approx(0.5 / 2.525 / np.sqrt(2), rel=EXACT)


def test_neighbours_lend_errors_in_proportion_to_their_illuminance():
    """100 lx with a square of 10 beside 1000 lx with one of 100: as counts spread, each says what the other says."""
    neighbours = np.array([[0, 1], [0, 1], [2, 2]])
    illuminance, own = np.array([100.0, 1000.0, 400.0]), np.sqrt([10.0, 100.0, 16.0])
    areas = np.array([1.0, 2.0, 1.0])
    assert pooled_error(illuminance, own, neighbours, areas=areas) == pytest.approx(own, rel=EXACT)
    # Where rays of one have met nothing so far, the other, a quarter of the two, speaks for it.
    blind = np.array([0.0, 10.0, 4.0])
    assert pooled_error(illuminance, blind, neighbours, areas=areas)[0] == pytest.approx(
        np.sqrt(0.25 * 10.0), rel=EXACT
    )
    # Almost dark is as good as 5 % of the mean: (1 + 2 x 1000 + 400) / 4 x 0.05 = 30.0125 lx.
    dark = pooled_error(np.array([1.0, 1000.0, 400.0]), blind, neighbours, areas=areas)
    assert dark[0] == pytest.approx(np.sqrt(0.25 * 100.0 * 30.0125 / 1000.0), rel=EXACT)


def test_percentiles_are_by_area():
    """Errors of 1 to 100 % on equal areas: 95 % of the area lies at 95 % or below; twice the area counts twice."""
    illuminance, error = np.full(100, 50.0), np.arange(1, 101) * 0.5
    reached = error_reached(illuminance, error, areas=np.ones(100))
    assert reached.p95 == pytest.approx(0.95, abs=0.01)
    assert reached.p99 == pytest.approx(0.99, abs=0.01)
    areas = np.ones(100)
    areas[-1] = 99.0
    assert error_reached(illuminance, error, areas=areas).p95 == pytest.approx(1.0, rel=EXACT)


def test_nothing_lit_has_no_error_to_speak_of_and_no_warning():
    error = error_reached(np.zeros(3), np.zeros(3), areas=np.ones(3))
    assert (error.rms, error.p95, error.p99) == (0.0, 0.0, 0.0)
