"""Two results against each other: numbers, pairs of replicates, and the command."""

from __future__ import annotations

import io
import json
import math
import shutil
from dataclasses import replace

import numpy as np
import pytest
from commandline import NASTY, ROOM_MTL, lelight, write_room
from rooms import furnace
from scipy import stats

from lelight.calculation import calculate
from lelight.comparison import (
    Difference,
    freedom_of,
    paired,
    rating_replicates,
    sidak_level,
    unpaired,
)
from lelight.metrics.figure import from_replicates
from lelight.pipelines.compare import run_compare
from lelight.settings import Settings
from lelight.writing.replicatesfile import read_replicates
from lelight.writing.vtpreading import read_polydata


@pytest.fixture(scope="module")
def brighter(run, tmp_path_factory):
    """The room with its floor at 0.32 instead of 0.30, sampled like the first run, and on its own."""
    folder = tmp_path_factory.mktemp("brighter")
    scene = write_room(folder, mtl=ROOM_MTL.replace("Kd 0.3 0.3 0.3", "Kd 0.32 0.32 0.32"))
    alike = lelight("calc", scene, "--like", run.out, "-o", folder / "alike", "--quiet")
    assert (alike.status, alike.stdout, alike.stderr) == (0, "", "")
    return folder / "alike"


def test_pairs_and_welch_against_scipy():
    rng = np.random.default_rng(4)
    common = rng.normal(size=(8, 3))
    first, second = 5 + common + 0.1 * rng.normal(size=(8, 3)), 5.2 + common + 0.1 * rng.normal(size=(8, 3))
    related = stats.ttest_rel(second, first)
    np.testing.assert_allclose(paired(first, second).p_values, related.pvalue, rtol=1e-9)
    np.testing.assert_allclose(
        paired(first, second).half_width_95(),
        related.confidence_interval().high - paired(first, second).difference,
    )
    apart = stats.ttest_ind(second, first[:6], equal_var=False)
    found = unpaired(first[:6], second)
    np.testing.assert_allclose(found.p_values, apart.pvalue, rtol=1e-9)
    np.testing.assert_allclose(found.degrees_of_freedom, apart.df, rtol=1e-9)
    np.testing.assert_allclose(2 * stats.norm.sf(np.abs(found.z)), found.p_values, rtol=1e-9)
    assert np.all(np.sign(found.z) == np.sign(found.difference))


def test_many_comparisons_of_nothing_find_something_in_one_of_twenty():
    """Šidák over 50 quantities without any difference, 2000 times: 5 % within four standard errors."""
    rng = np.random.default_rng(5)
    alarms = sum(bool(paired(*rng.normal(size=(2, 10, 50))).significant().any()) for _ in range(2000))
    assert abs(alarms / 2000 - 0.05) < 4 * math.sqrt(0.05 * 0.95 / 2000)
    assert 1 - (1 - sidak_level(50)) ** 50 == pytest.approx(0.05)


def test_what_is_not_random_differs_or_does_not():
    zero, nine = np.zeros(3), np.full(3, 9.0)
    found = Difference(
        np.full(3, 100.0), np.array([100.0, 100.00001, 100.1]), np.array([0, 1e-5, 0.1]), zero, nine
    )
    assert found.significant().tolist() == [False, False, True]
    assert np.all(np.isfinite(found.z))


@pytest.mark.parametrize("freedom", [1.0, 7.0, 11.0])
def test_the_degrees_of_freedom_of_a_stated_interval(freedom):
    assert freedom_of(2.0, 2.0 * stats.t.ppf(0.975, freedom)) == pytest.approx(freedom, rel=1e-6)
    assert freedom_of(2.0, 2.0 * stats.norm.ppf(0.975)) == freedom_of(0.0, 0.0) == math.inf


def test_a_rating_has_the_jackknifes_error():
    background = np.random.default_rng(6).uniform(80.0, 120.0, 9)
    each = rating_replicates(17.0, background)
    _, error = from_replicates(lambda mean: -8.0 * math.log10(mean), background)
    assert each.mean() == pytest.approx(17.0, abs=1e-12)
    assert each.std(ddof=1) / 3.0 == pytest.approx(error, rel=1e-9)


def test_sampling_alike_is_the_same_run_where_the_scene_is(run, tmp_path):
    again = lelight("calc", run.scene, "--like", run.out, "-o", tmp_path / "again", "--quiet")
    assert again.status == 0, again.stderr
    one, two = (read_replicates(out / "replicates.npz") for out in (run.out, tmp_path / "again"))
    np.testing.assert_allclose(two.nodes, one.nodes, rtol=1e-5)
    told = lelight("compare", run.out, tmp_path / "again")
    assert told.status == 0
    assert told.stdout.endswith("no significant difference\n")
    assert "pairs of replicates" in told.stdout


def test_pairs_resolve_what_independent_runs_do_not(run, brighter):
    """Variance of the difference over the nodes at least ten times smaller: as many chains fewer."""
    one, two = (read_replicates(out / "replicates.npz") for out in (run.out, brighter))
    plane = (
        one.planes["work plane"].mean(axis=1, keepdims=True),
        two.planes["work plane"].mean(axis=1, keepdims=True),
    )
    for first, second in (
        (one.nodes.mean(axis=1, keepdims=True), two.nodes.mean(axis=1, keepdims=True)),
        plane,
    ):
        assert unpaired(first, second).std_error[0] ** 2 > 10 * paired(first, second).std_error[0] ** 2
    told = json.loads(lelight("compare", run.out, brighter, "--json").stdout)
    (floor,) = (each for each in told["figures"] if each["group"] == "room" and each["paired"])
    assert floor["significant"] and floor["difference"] > 3 * floor["std_error"]
    eye = {each["figure"]: each for each in told["figures"] if each["name"] == NASTY and each["paired"]}
    assert set(eye) == {"ugr", "vertical_illuminance"}
    assert told["nodes"]["compared"] > 50
    assert told["pairs"] == len(one.nodes)


def test_differences_at_the_nodes_are_written(run, brighter, tmp_path):
    found = run_compare(run.out, brighter, out=tmp_path / "d.vtp")
    arrays = read_polydata(tmp_path / "d.vtp").point_arrays
    before, after = (
        read_polydata(out / "field.vtp").point_arrays["illuminance_lx"] for out in (run.out, brighter)
    )
    seen = arrays["hidden"] == 0
    np.testing.assert_allclose(
        arrays["difference_lx"][seen], (after - before)[seen], atol=1e-3 * before.max()
    )
    assert int(arrays["significant"].sum()) == found.significant_nodes
    assert np.all(arrays["difference_std_error_lx"][seen] >= 0)


def test_starts_of_another_scene_leave_the_estimate_unbiased():
    """A furnace of 0.3 sampled as one of 0.7 was: E = 1 / (1 - 0.3) within Student's interval at 0.1 %."""
    settings = Settings(preset="draft", edge=0.4, batches=8, threads=2)
    other = calculate(furnace(0.7), settings)
    found = calculate(furnace(0.3), settings, like=other.sampling)
    seen = ~found.field.mesh.hidden
    means = (
        found.replicates.at_nodes[:, seen] @ found.field.mesh.areas[seen] / found.field.mesh.areas[seen].sum()
    )
    t = (means.mean() - 1 / 0.7) / (means.std(ddof=1) / math.sqrt(8))
    assert abs(t) < stats.t.ppf(0.9995, 7)
    assert found.sampling.starts.probability.tolist() == other.sampling.starts.probability.tolist()
    assert found.effort == other.effort


def test_starts_that_leave_a_surface_out_are_not_taken():
    """Sampled like a furnace with a black face, whose starts would miss it."""
    settings = Settings(preset="draft", edge=0.4, batches=2, threads=2)
    sampling = calculate(furnace(0.5), settings).sampling
    fewer = replace(
        sampling.starts,
        triangle=sampling.starts.triangle[1:],
        side=sampling.starts.side[1:],
        segments=sampling.starts.segments[1:],
        probability=sampling.starts.probability[sampling.starts.segments[0] ** 2 :],
    )
    found = calculate(furnace(0.5), settings, like=replace(sampling, starts=fewer))
    assert len(found.sampling.starts.triangle) == len(sampling.starts.triangle)


def test_other_places_and_misuse_are_told_in_one_line(run, tmp_path):
    flat = write_room(tmp_path / "flat", toml=None)
    other = lelight("calc", flat, "--like", run.out, "-o", tmp_path / "out", "--quiet")
    assert other.status == 1
    assert "compute without --like" in other.stderr
    assert other.stderr.count("\n") == 1
    assert lelight("calc", flat, "--like", run.out, "--target", "5%").status == 2
    assert lelight("compare", run.out).status == 2


@pytest.mark.parametrize(
    ("damage", "told"),
    [
        (lambda path: path.unlink(), "no such file"),
        (lambda path: path.write_bytes(b"PK\x03\x04 cut off"), "damaged"),
        (lambda path: path.write_bytes(path.read_bytes()[:500]), "damaged"),
        (lambda path: np.savez(path, nodes_lx=np.zeros((2, 3))), "is missing"),
        (lambda path: np.savez(path, nodes_lx=np.array([{}])), "damaged"),
        (lambda path: path.write_bytes(_npy()), "damaged"),
    ],
)
def test_what_is_wrong_with_kept_replicates_is_told(run, tmp_path, damage, told):
    folder = tmp_path / "b"
    shutil.copytree(run.out, folder)
    damage(folder / "replicates.npz")
    outcome = lelight("compare", run.out, folder)
    assert outcome.status == 1
    assert told in outcome.stderr and "replicates.npz" in outcome.stderr
    assert outcome.stderr.count("\n") == 1


def _npy() -> bytes:
    """Bytes of an array that is no archive."""
    held = io.BytesIO()
    np.save(held, np.zeros(3))
    return held.getvalue()
