"""Figures: the jackknife against closed forms, verdicts against Student's interval."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lelight.metrics.figure import Figure, from_replicates, judge, measured, ratio

EXACT = 1e-9
REPLICATES = np.random.default_rng(7).normal(100.0, 5.0, size=(8, 3))


def test_jackknife_of_the_mean_is_the_textbook_error():
    # For a linear function the jackknife is s / sqrt(R), whatever the batches.
    value, std_error = from_replicates(lambda e: float(e[1]), REPLICATES)
    assert value == pytest.approx(REPLICATES[:, 1].mean(), rel=EXACT)
    assert std_error == pytest.approx(REPLICATES[:, 1].std(ddof=1) / math.sqrt(8), rel=EXACT)


def test_jackknife_of_a_ratio_follows_error_propagation():
    # Delta method: var(a/b) ≈ sum of (a_r - q b_r)² / (b² R) with q = a/b; relative noise of 0.1 %
    # leaves its second-order terms far below 1 %.
    batches = np.array([1.0, 2.0]) * (1 + 1e-3 * np.random.default_rng(1).normal(size=(16, 2)))
    value, std_error = from_replicates(lambda e: float(e[0] / e[1]), batches)
    defects = batches[:, 0] - value * batches[:, 1]
    expected = math.sqrt(np.sum(defects**2) / (16 * 15)) / batches[:, 1].mean()
    assert std_error == pytest.approx(expected, rel=0.01)


def test_jackknife_error_covers_the_truth_of_a_logarithm():
    # 2000 repetitions with 10 batches: |estimate - truth| <= t(0.975, 9) · error in 95 % of them; the
    # binomial standard deviation of that share is 0.5 %: four of them either way. Half the error must not
    # pass.
    generator = np.random.default_rng(3)
    covered = halved = 0
    for _ in range(2000):
        value, std_error = from_replicates(
            lambda e: 8 * math.log10(float(e)), generator.normal(50, 2, size=10)
        )
        assert std_error is not None
        miss = abs(value - 8 * math.log10(50.0)) / std_error
        covered += miss <= 2.262157
        halved += miss <= 2.262157 / 2
    assert 0.93 < covered / 2000 < 0.97
    assert halved / 2000 < 0.93


def test_one_batch_has_no_error():
    assert from_replicates(lambda e: float(e.min()), REPLICATES[:1]) == (REPLICATES[0].min(), None)


def test_a_function_that_hangs_on_one_batch_has_no_error():
    value, std_error = from_replicates(lambda e: ratio(1.0, float(e)), np.array([0.0, 0.0, 6.0]))
    assert (value, std_error) == (0.5, None)


@pytest.mark.parametrize("wrong", [REPLICATES[:0], REPLICATES * math.nan, REPLICATES * math.inf])
def test_missing_and_impossible_batches_are_refused(wrong):
    with pytest.raises(ValueError, match="replicates must hold"):
        from_replicates(lambda e: float(e.min()), wrong)


@pytest.mark.parametrize(
    ("value", "std_error", "sense", "verdict"),
    [
        (520.0, 10.0, "at_least", "pass"),  # 520 - 1.96 · 10 = 500.4
        (519.0, 10.0, "at_least", "undecided"),  # 499.4
        (481.0, 10.0, "at_least", "undecided"),  # 500.6
        (480.0, 10.0, "at_least", "fail"),  # 499.6
        (480.0, 10.0, "at_most", "pass"),
        (520.0, 10.0, "at_most", "fail"),
        (500.0, 0.0, "at_least", "pass"),
        (500.0, 0.0, "at_most", "pass"),
        (499.9, 0.0, "at_least", "fail"),
        (900.0, None, "at_least", "undecided"),
    ],
)
def test_verdict_is_undecided_while_the_interval_holds_the_target(value, std_error, sense, verdict):
    assert judge(value, std_error, target=500.0, sense=sense) == verdict


def test_few_batches_widen_the_interval():
    # Student t(0.975, 3) = 3.182: 520 - 3.182 · 10 = 488.2 no longer clears 500.
    assert judge(520.0, 10.0, target=500.0, sense="at_least", degrees_of_freedom=3) == "undecided"
    assert judge(531.9, 10.0, target=500.0, sense="at_least", degrees_of_freedom=3) == "pass"
    assert judge(531.7, 10.0, target=500.0, sense="at_least", degrees_of_freedom=3) == "undecided"


@given(st.floats(0, 1e4), st.floats(0, 1e3), st.floats(0, 1e4))
def test_at_least_and_at_most_never_contradict(value, std_error, target):
    at_least = judge(value, std_error, target=target, sense="at_least")
    at_most = judge(-value, std_error, target=-target, sense="at_most")
    assert at_least == at_most


def test_undefined_figures_carry_their_reason_instead_of_nan():
    figure = measured(
        lambda e: ratio(e.min(), 0.0),
        REPLICATES,
        unit="1",
        method="m",
        target=0.6,
        undefined="no light",
    )
    assert (figure.value, figure.std_error, figure.verdict, figure.note) == (
        None,
        None,
        "undecided",
        "no light",
    )


@pytest.mark.parametrize("wrong", [math.nan, math.inf])
def test_a_figure_refuses_what_json_cannot_hold(wrong):
    with pytest.raises(ValueError, match="value must be finite"):
        Figure(wrong, "lx", None, "m")
    with pytest.raises(ValueError, match="std_error must be finite"):
        Figure(1.0, "lx", wrong, "m")


def test_json_has_a_verdict_only_with_a_target():
    assert Figure(1.0, "lx", 0.1, "m").to_json() == {
        "value": 1.0,
        "unit": "lx",
        "std_error": 0.1,
        "method": "m",
    }
    judged = Figure(1.0, "lx", 0.1, "m", "fail", 2.0, "c", "n").to_json()
    assert list(judged) == ["value", "unit", "std_error", "method", "verdict", "target", "clause", "note"]
