from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lelight.harmonics import bynode
from lelight.harmonics.basis import evaluate, terms
from lelight.harmonics.projection import (
    break_even,
    deposit,
    project,
    project_groups,
)
from lelight.harmonics.synthesis import synthesise_at
from lelight.harmonics.transform import transform


def contributions(seed, count, channels):
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return directions, rng.uniform(0, 100, (count, channels))


def summed(degree, directions, weights):
    return evaluate(degree, directions).T @ weights


@pytest.mark.parametrize(("degree", "channels"), [(0, 1), (1, 3), (12, 3), (30, 2), (49, 1)])
@pytest.mark.parametrize("count", [1, 30, 2500])
def test_projection_is_the_weighted_sum_of_harmonics(degree, channels, count):
    directions, weights = contributions(degree, count, channels)
    expected = summed(degree, directions, weights)
    found = project(degree, directions, weights)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("degree", [0, 1, 12, 49, 128])
def test_transform_agrees_with_the_loop(degree):
    directions, weights = contributions(degree, 2000, 3)
    directions[:6] = [[0, 0, 1], [0, 0, -1], [-1, 0, 0], [0, -1, 0], [-1, -0.0, 0], [1, -1e-300, 0]]
    expected = summed(degree, directions, weights)
    looped = np.zeros((1, terms(degree), 3))
    columns = tuple(np.ascontiguousarray(column) for column in directions.T)
    deposit(degree, np.array([0, 2000]), np.array([0]), columns, np.ascontiguousarray(weights.T), looped)
    np.testing.assert_allclose(looped[0], expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    found = transform(degree, directions, weights)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def test_break_even_follows_the_measured_costs():
    # 3 channels at degree 11: a contribution costs 55 ns in the loop, 160 ns in the transform: it never pays.
    assert break_even(11, 3) == np.inf
    assert 500 < break_even(48, 1) < 900
    assert break_even(59, 1) < break_even(49, 1) < break_even(30, 1)


def test_groups_are_independent_and_the_same_bits_as_alone():
    degree, channels = 49, 2
    counts = np.array([0, 5, 2000, 0, 150, 900])
    assert (counts > break_even(degree, channels)).tolist() == [False, False, True, False, False, True]
    offsets = np.concatenate([[0], np.cumsum(counts)])
    directions, weights = contributions(7, offsets[-1], channels)
    found = project_groups(degree, offsets, directions, weights)
    for g, (start, stop) in enumerate(pairwise(offsets)):
        np.testing.assert_array_equal(found[g], project(degree, directions[start:stop], weights[start:stop]))
    assert np.all(found[[0, 3]] == 0)


def test_threads_give_the_same_bits():
    sets = [contributions(seed, 1500, 1) for seed in range(8)]
    alone = [project(16, *each) for each in sets]
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda each: project(16, *each), sets))
    np.testing.assert_array_equal(together, alone)


def test_deposit_adds_to_what_is_there():
    directions, weights = contributions(3, 4, 2)
    out = np.ones((3, 9, 2))
    columns = tuple(np.ascontiguousarray(column) for column in directions.T)
    chosen, offsets = np.array([2, 0]), np.array([0, 1, 1, 4])
    deposit(2, offsets, chosen, columns, np.ascontiguousarray(weights.T), out)
    np.testing.assert_allclose(out[0], 1 + summed(2, directions[:1], weights[:1]), rtol=1e-13)
    np.testing.assert_array_equal(out[1], 1)
    np.testing.assert_allclose(out[2], 1 + summed(2, directions[1:], weights[1:]), rtol=1e-13)


@given(st.integers(0, 12), st.integers(1, 3), st.integers(0, 10_000))
@settings(deadline=None, max_examples=30)
def test_projection_is_the_adjoint_of_synthesis(degree, channels, seed):
    # <w, S c> = <S* w, c> for every c and w.
    directions, weights = contributions(seed, 20, channels)
    field = np.random.default_rng(seed + 1).normal(size=(terms(degree), channels))
    node, alone = np.zeros((20, 1), dtype=np.int64), np.ones((20, 1))
    values = synthesise_at(field[None], degree, node, alone, directions[:, None])
    inner = np.sum(project(degree, directions, weights) * field)
    np.testing.assert_allclose(np.sum(weights * values), inner, rtol=0, atol=1e-9 * np.abs(weights).sum())


def test_mix_evaluates_each_corner_in_its_own_frame():
    rng = np.random.default_rng(5)
    fields = rng.normal(size=(6, terms(7), 3)).astype(np.float32)
    nodes = rng.integers(0, 6, (10, 3))
    weights = rng.dirichlet([1, 1, 1], 10)
    weights[0] = [1, 0, 0]
    directions = contributions(9, 30, 1)[0].reshape(10, 3, 3)
    found = synthesise_at(fields, 7, nodes, weights, directions)
    corners = [
        weights[:, [j]] * np.einsum("kt,ktc->kc", evaluate(7, directions[:, j]), fields[nodes[:, j]])
        for j in range(3)
    ]
    np.testing.assert_allclose(found, np.sum(corners, axis=0), rtol=0, atol=1e-12)
    wrong = synthesise_at(fields, 7, nodes, weights, np.ascontiguousarray(directions[:, ::-1]))
    assert np.abs(wrong - found).max() > 0.1


def test_mix_leaves_out_terms_above_the_degree():
    fields = np.ones((1, terms(5), 1))
    pole = np.array([[[0.0, 0.0, 1.0]]])
    found = synthesise_at(fields, 2, np.array([[0]]), np.ones((1, 1)), pole)
    # At the pole only m = 0 is left: sum of sqrt((2l + 1) / (4 pi)) for l = 0, 1, 2.
    np.testing.assert_allclose(found, [[np.sqrt([1, 3, 5]).sum() / np.sqrt(4 * np.pi)]], rtol=1e-14)


def test_a_corner_without_weight_may_hold_nan():
    fields = np.stack([np.ones((4, 1)), np.full((4, 1), np.nan)])
    pole = np.tile([0.0, 0.0, 1.0], (1, 2, 1))
    found = synthesise_at(fields, 1, np.array([[0, 1]]), np.array([[1.0, 0.0]]), pole)
    np.testing.assert_allclose(found, [[(1 + np.sqrt(3)) / np.sqrt(4 * np.pi)]], rtol=1e-14)


def test_nothing_arrives():
    assert np.all(project(3, np.empty((0, 3)), np.empty((0, 2))) == np.zeros((16, 2)))


@pytest.mark.parametrize("offsets", [[0, 3], [1, 4], [0, 5, 4]])
def test_rejects_groups_that_do_not_tile(offsets):
    with pytest.raises(ValueError, match="offsets must rise from 0 to 4"):
        project_groups(2, np.array(offsets), *contributions(0, 4, 1))


def test_rejects_wrong_shapes():
    directions, weights = contributions(0, 4, 1)
    with pytest.raises(ValueError, match=r"weights must have shape \(4, C\)"):
        project(2, directions, weights[:3])
    with pytest.raises(ValueError, match=r"directions must have shape \(k, 3\)"):
        project(2, directions[:, :2], weights)
    with pytest.raises(ValueError, match="degree must lie between"):
        project(129, directions, weights)


@pytest.mark.parametrize(("degree", "channels"), [(0, 1), (4, 3), (13, 3), (48, 1)])
@pytest.mark.parametrize("count", [0, 5, 2000])
def test_synthesis_by_node_is_that_of_single_places(degree, channels, count):
    # 2000 places around 4 nodes ask them often enough for the transform at degrees 13 and 48, 5 never do.
    rng = np.random.default_rng(degree)
    coefficients = rng.normal(size=(6, terms(degree + 1), channels)).astype(np.float32)
    nodes = np.array([rng.choice(4, 3, replace=False) for _ in range(count)], dtype=np.int64).reshape(-1, 3)
    weights = rng.dirichlet(np.ones(3), size=count)
    weights[::7] = [1.0, 0.0, 0.0]
    directions = rng.normal(size=(count, 3, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    expected = synthesise_at(coefficients, degree, nodes, weights, directions)
    found = bynode.synthesise_by_node(coefficients, degree, nodes, weights, directions)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max(initial=0.0))
    asked = np.bincount(nodes[weights != 0.0], minlength=1)
    transformed = asked.max() > bynode.break_even(degree, channels)
    assert bool(np.any(found != expected)) == transformed == (count == 2000 and degree > 4)
