"""``lelight validate``: verdicts on made-up readings, and the command on the cases that take no time."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from commandline import lelight

from lelight.analytic import catalogue, pointsource, reflector
from lelight.analytic.case import Readings
from lelight.analytic.verdicts import judge, noise, student_limit
from lelight.pipelines import validate

CASE = replace(pointsource.isotropic_case(), tolerance=0.01, precision=0.003)


def readings(found, std_error, **others):
    count = len(found)
    given = {
        "labels": tuple("abcdefgh"[:count]),
        "reference": np.full(count, 100.0),
        "allowance": np.zeros(count),
        "found": np.array(found, dtype=float),
        "std_error": np.array(std_error, dtype=float),
        "freedom": 7.0,
        "tested": count,
        "slack": np.ones(count),
    }
    return Readings(**given | others)


def test_limit_is_students():
    # Table of Student's t: 97.5 % at 7 degrees of freedom 2.3646, 99.5 % at 10 degrees 3.1693.
    assert student_limit(7, 1, level=0.05) == pytest.approx(2.3646, abs=5e-5)
    assert student_limit(10, 1, level=0.01) == pytest.approx(3.1693, abs=5e-5)
    # Šidák: of independent values that each keep to their limit, all do with the stated probability.
    assert student_limit(7, 3, level=1 - 0.95**3) == pytest.approx(student_limit(7, 1, level=0.05), rel=1e-9)


def test_verdicts():
    judged = judge(CASE, readings([100.2, 102.0, 102.0, 100.9], [0.2, 0.2, 0.9, 0.1]))
    # Right; wrong by t; too noisy to tell; within the tolerance but many standard errors off.
    assert judged.verdicts == ("pass", "fail", "undecided", "fail")
    assert judged.verdict == "fail"
    np.testing.assert_allclose(judged.t, [1.0, 10.0, 2.0 / 0.9, 9.0], rtol=1e-6)


def test_more_than_the_tolerance_fails_without_noise_and_with_little():
    assert judge(CASE, readings([101.5], [0.0])).verdict == "fail"
    assert judge(CASE, readings([100.5], [0.0])).verdict == "pass"
    assert judge(CASE, readings([101.2], [0.29])).verdict == "fail"


def test_what_the_reference_may_be_off_is_allowed():
    off = readings([102.0], [0.1])
    assert judge(CASE, off).verdict == "fail"
    assert judge(CASE, replace(off, allowance=np.array([1.95]))).verdict == "pass"


def test_nan_fails():
    assert judge(CASE, readings([math.nan], [0.1])).verdict == "fail"
    assert judge(CASE, readings([100.0], [math.nan])).verdict != "pass"


def test_single_nodes_have_more_room():
    loose = readings([102.0], [1.0], slack=np.array([10.0]))
    assert judge(CASE, loose).verdict == "pass"
    assert noise(CASE, loose) == pytest.approx(1.0 / 3.0)


def outcome_of(case):
    return validate.run_case(case, seed=3)


def test_a_sampled_case_passes_and_its_wrong_reference_fails():
    case = reflector.screen_case()
    right = outcome_of(case)
    assert right.verdict == "pass"
    assert right.judgement.std_error.max() <= case.precision
    assert np.any(right.judgement.std_error > 0)

    def wrong(run):
        read = case.read(run)
        return replace(read, reference=1.02 * read.reference)

    assert outcome_of(replace(case, read=wrong)).verdict == "fail"


def test_another_run_where_the_first_was_not_precise():
    case = replace(reflector.screen_case(), target=0.006)
    outcome = outcome_of(case)
    assert outcome.runs > 1
    assert outcome.verdict == "pass"


@pytest.fixture(scope="module")
def validated(tmp_path_factory):
    out = tmp_path_factory.mktemp("validate") / "out"
    return lelight("validate", "--only", "cie171-5.[23]*", "-o", out), out


def test_command_prints_a_table_and_writes_json_and_pdf(validated):
    run, out = validated
    assert run.status == 0, run.stderr
    for name in ("cie171-5.2-isotropic", "cie171-5.2-diffuse", "cie171-5.3"):
        assert f"{name}: CIE 171:2006" in run.stdout
    assert "3 of 3 cases pass" in run.stderr
    record = json.loads((out / "validation.json").read_text(encoding="utf-8"))
    assert record["verdict"] == "pass"
    first = record["cases"][0]["points"][0]
    assert first["reference"] == pytest.approx(1000 / 9, rel=1e-9)
    assert abs(first["relative_difference"]) < 1e-6
    assert first["t"] is None
    assert first["verdict"] == "pass"
    assert (out / "validation.pdf").read_bytes().startswith(b"%PDF")


def test_command_prints_json(tmp_path):
    run = lelight("validate", "--only", "rectangles-parallel", "--json", "-o", tmp_path)
    assert run.status == 0, run.stderr
    assert json.loads(run.stdout) == json.loads((tmp_path / "validation.json").read_text(encoding="utf-8"))


def test_a_wrong_reference_ends_in_one_line(tmp_path, monkeypatch):
    case = pointsource.isotropic_case()

    def wrong(run):
        read = case.read(run)
        return replace(read, reference=1.002 * read.reference)

    monkeypatch.setattr(catalogue, "FAMILIES", (lambda _full: iter([replace(case, read=wrong)]),))
    run = lelight("validate", "-o", tmp_path)
    assert run.status == 1
    last = run.stderr.strip().splitlines()[-1]
    assert last.startswith("lelight: 1 case does not pass: cie171-5.2-isotropic")
    assert json.loads((tmp_path / "validation.json").read_text(encoding="utf-8"))["verdict"] == "fail"


def test_an_unknown_case_is_refused(tmp_path):
    run = lelight("validate", "--only", "nonsense", "-o", tmp_path / "none")
    assert run.status == 2
    assert "nonsense" in run.stderr
    assert not (tmp_path / "none").exists()
