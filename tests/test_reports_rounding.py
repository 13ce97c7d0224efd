"""How numbers are printed."""

from __future__ import annotations

import doctest
import re
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lelight.reports import rounding, vocabulary
from lelight.reports.figures import scales
from lelight.reports.reading import Reading, readings_of
from lelight.reports.rounding import MISSING, fixed, rounded, significant
from lelight.reports.texts import read_texts


@pytest.mark.parametrize("module", [rounding, vocabulary, scales])
def test_examples_in_docstrings(module):
    assert doctest.testmod(module).failed == 0


@pytest.mark.parametrize(
    ("value", "standard_error", "printed"),
    [
        # Half widths 0.119, 0.367 and 0.99: the three cases of the Particle Data Group's rule.
        (0.827, 0.119 / 2, ("0.83", "0.12")),
        (0.827, 0.367 / 2, ("0.8", "0.4")),
        (0.827, 0.99 / 2, ("0.8", "1.0")),
        (512.3456, 6.8, ("512", "14")),
        (12345.6, 335.0, ("12\u202f300", "700")),
        (-0.01, 0.3, ("0.0", "0.6")),
        (500.0, 0.0, ("500", "0")),
        (500.0, None, ("500", "")),
        # An error below what is worth printing is never told smaller than the last digit.
        (500.0, 1e-12, ("500.000", "0.001")),
        (0.0, 0.02, ("0.00", "0.04")),
    ],
)
def test_the_error_decides_the_digits(value, standard_error, printed):
    assert rounded(value, standard_error) == printed


@given(st.floats(-1e6, 1e6), st.floats(1e-9, 1e6))
def test_value_and_error_end_at_the_same_decimal_and_are_right_to_half_of_it(value, standard_error):
    texts = [text.replace("\u202f", "").replace("\u2212", "-") for text in rounded(value, standard_error)]
    printed_value, printed_error = map(Decimal, texts)
    assert printed_value.as_tuple().exponent == printed_error.as_tuple().exponent
    assert len(re.sub(r"^[0.]+|\.|0+$", "", texts[1])) <= 2
    # Half of the last digit that the error has: a tenth of its power of ten, at the most.
    last_digit = max(10.0 ** (Decimal(texts[1]).adjusted()), 10.0 ** printed_error.as_tuple().exponent)
    assert abs(float(printed_value) - value) <= 0.5 * last_digit * (1 + 1e-9)


@given(st.floats(1e-6, 1e9))
def test_significant_digits_are_right_to_half_of_the_last(value):
    printed = float(significant(value).replace("\u202f", ""))
    assert abs(printed / value - 1) <= 0.005 * (1 + 1e-9)


def test_thousands_are_apart_only_where_there_are_ten_of_them():
    assert fixed(9999, 0) == "9999"
    assert fixed(123456789, 0) == "123\u202f456\u202f789"


@pytest.mark.parametrize(
    ("value", "printed"), [(9.4, ("<10", "")), (10.4, ("10.4", "±\u00a01.0")), (None, (MISSING, ""))]
)
def test_ratings_below_ten_are_not_told_apart(value, printed):
    for key in ("ugr", "ugr_picture"):
        assert Reading(key, read_texts().term(key), value, "", 1.0).number == printed


def test_requirements_know_their_good_side():
    term = read_texts().term
    assert Reading("ugr", term("ugr"), 20.0, "", target=19.0).requirement == "≤\u00a019"
    mean = Reading("mean_illuminance", term("mean_illuminance"), 20.0, "lx", target=500.0)
    assert mean.requirement == "≥\u00a0500\u00a0lx"


def test_the_interval_is_printed_where_there_is_one():
    figure = {
        "value": 512.3456,
        "unit": "lx",
        "std_error": 6.8,
        "interval": [512.3456 - 21.0, 512.3456 + 21.0],
    }
    (reading,) = readings_of({"mean_illuminance": figure}, read_texts())
    assert reading.number == ("512", "±\u00a021")
    figure["interval"] = None
    (reading,) = readings_of({"mean_illuminance": figure}, read_texts())
    assert reading.number == ("512", "±\u00a014")


def test_what_is_no_figure_is_left_out_and_what_is_no_number_is_missing():
    entry = {
        "file": "x",
        "sources": [{"value": 1}],
        "ugr": {"value": "high", "unit": "1"},
        "grid": {"rows": 1},
    }
    (reading,) = readings_of(entry, read_texts())
    assert (reading.key, reading.value, reading.unit) == ("ugr", None, "")
