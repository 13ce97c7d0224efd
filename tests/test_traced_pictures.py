"""Pictures by double local estimation: against the brute-force path tracer, unit by unit, and from the command line."""

from __future__ import annotations

import json
import math
import shutil
import signal
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from commandline import NASTY, lelight, process
from conftest import Run
from pathtracer import PathTracer
from test_against_path_tracer import Estimates, agree, relative_error
from threeglosses import drawn_directions, three_glosses

from lelight.calculation import calculate
from lelight.camera import Fisheye
from lelight.doublelocal import DoubleLocal, Unit, stored_base, traced_view
from lelight.estimate.blocks import Effort
from lelight.estimate.effort import bound_for
from lelight.estimate.variants import VARIANTS
from lelight.field import RadianceField
from lelight.pipelines.trace import Chains
from lelight.scene import FloatArray
from lelight.settings import Settings
from lelight.tracedpicture import Exposing, Exposure, Sums, units
from lelight.writing.pictures import read_exr

RAYS, REPLICATES = 96, 16
STEM = "a_b_ _üλ_ _x_"


@cache
def rough_field() -> RadianceField:
    """A field far from right: what is traced on it has to be right all the same."""
    return calculate(three_glosses(), Settings(edge=1.0, batches=2, target=0.3)).field


@pytest.fixture(scope="module")
def executor() -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(max_workers=2) as threads:
        yield threads


def traced(
    chains: Chains, executor: ThreadPoolExecutor, *, sharpest: float = 256.0, seed: int = 1
) -> FloatArray:
    """Estimates (replicates, rays) in cd/m² along the drawn directions."""
    field = rough_field()
    base = stored_base(field, seed=seed, executor=executor) if chains == "field" else None
    variant = VARIANTS["base" if chains == "field" else "emitters"]
    estimate = DoubleLocal(traced_view(field, sharpest=sharpest), base, variant, seed, executor)
    effort = Effort(log2_chains=6, log2_direct=3, log2_near=7, bound=0.4 * bound_for(field.world.area, 1024))
    rays = drawn_directions(RAYS)
    return np.stack([estimate.radiance(*rays, Unit(r, effort))[:, 0] for r in range(REPLICATES)])


@cache
def path_traced(floor_gloss: float) -> Estimates:
    scene = three_glosses()
    materials = (replace(scene.materials[0], specular=np.full(3, floor_gloss)), *scene.materials[1:])
    paths = PathTracer(replace(scene, materials=materials), seed=8).radiance(
        *drawn_directions(RAYS), paths=2048
    )
    return Estimates.of_paths(paths[..., 0])


@pytest.mark.parametrize(
    ("chains", "sharpest"), [("field", 256.0), ("emitters", 256.0), ("field", 32.0)], ids=str
)
def test_radiance_is_that_of_the_path_tracer(
    chains: Chains, sharpest: float, executor: ThreadPoolExecutor
) -> None:
    found = Estimates.of(traced(chains, executor, sharpest=sharpest))
    right = path_traced(0.3)
    assert relative_error(found, right) < 0.08
    assert agree(found, right)


def test_another_gloss_of_the_floor_is_told_apart(executor: ThreadPoolExecutor) -> None:
    assert not agree(Estimates.of(traced("field", executor)), path_traced(0.15))


def test_the_stored_field_agrees_where_the_mesh_is_fine(executor: ThreadPoolExecutor) -> None:
    # The mesh of the rough field is not: on it the same rays differ by far more than their errors.
    found = Estimates.of(traced("field", executor))
    stored = rough_field().seen(*drawn_directions(RAYS))[:, 0]
    off = np.abs(stored - found.mean) / found.std_error
    assert np.mean(off > 4.0) > 0.1


def test_parts_of_the_first_replicate_double_from_one_chain_on() -> None:
    effort = Effort(log2_chains=4, log2_direct=2, log2_near=6, bound=1.0)
    first = list(islice(units(effort), 7))
    assert [unit.effort.log2_chains for unit in first] == [0, 1, 2, 3, 4, 4, 4]
    assert [unit.effort.log2_near for unit in first] == [2, 3, 4, 5, 6, 6, 6]
    assert [unit.effort.log2_direct for unit in first] == [0, 0, 0, 1, 2, 2, 2]
    assert [unit.replicate for unit in first] == [0, 0, 0, 0, 0, 1, 2]


def test_sums_hold_mean_and_standard_error() -> None:
    replicates = np.random.default_rng(1).gamma(2.0, size=(7, 5))
    sums = Sums(np.zeros(5), np.zeros(5))
    sums.preview = np.full(5, 9.0)
    assert sums.std_error is None
    np.testing.assert_array_equal(sums.luminance, 9.0)
    for replicate in replicates:
        sums.add(replicate)
    np.testing.assert_allclose(sums.luminance, replicates.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(sums.std_error, replicates.std(axis=0, ddof=1) / math.sqrt(7), rtol=1e-12)


@pytest.fixture(scope="module")
def exposing(executor: ThreadPoolExecutor) -> Exposing:
    field = rough_field()
    estimate = DoubleLocal(traced_view(field), None, VARIANTS["emitters"], 3, executor)
    exposure = Exposure(Fisheye(*(ray[0] for ray in drawn_directions(1))), 24, 24, samples=2)
    effort = Effort(log2_chains=2, log2_direct=1, log2_near=1, bound=bound_for(field.world.area, 1024))
    return Exposing(estimate, exposure, effort)


def test_a_picture_is_there_after_one_chain_and_ends_with_the_target(exposing: Exposing) -> None:
    taken = list(exposing.run(target=0.7, time=None, clock=time.perf_counter))
    assert [each.chains for each in taken[:4]] == [1, 2, 4, 8]
    inside = exposing.exposure.camera.mask(24, 24)
    assert np.isfinite(taken[0].luminance[inside]).all()
    assert taken[0].luminance[inside].mean() > 1.0
    assert taken[0].error is None
    last = taken[-1]
    assert last.replicates >= 8
    assert last.meets(0.7)
    assert not any(each.meets(0.7) for each in taken[:-1])


def test_two_nodes_of_a_chain_give_more_than_its_first(exposing: Exposing) -> None:
    one, two = (exposing.first_nodes(nodes) for nodes in (1, 2))
    inside = exposing.exposure.camera.mask(24, 24)
    assert np.all(one[inside] <= two[inside])
    assert np.nansum(one) < np.nansum(two)


def test_the_clock_ends_a_picture(exposing: Exposing) -> None:
    ticks = iter(range(1000))
    taken = list(exposing.run(target=None, time=5.0, clock=lambda: float(next(ticks))))
    assert 1 <= len(taken) <= 3


@pytest.fixture
def copy(run: Run) -> Iterator[Path]:
    folder = run.scene.with_name("traced.lelight")
    shutil.copytree(run.out, folder)
    yield folder
    shutil.rmtree(folder)


def test_the_command_writes_picture_error_and_record(copy: Path) -> None:
    told = lelight(
        "render", copy, "--observer", NASTY, "--method", "trace", "--size", "24", "--target", "20%"
    )
    assert told.status == 0, told.stderr
    stem = copy / "renders" / f"{STEM}-trace"
    assert told.stdout == f"{stem}.png\n"
    assert "relative standard error" in told.stderr.splitlines()[-1]
    record = json.loads(stem.with_name(f"{stem.name}.json").read_text(encoding="utf-8"))
    assert record["target_met"] is True
    assert record["error"]["rms"] <= 0.2
    luminance = read_exr(stem.with_name(f"{stem.name}.exr"))
    error = read_exr(stem.with_name(f"{stem.name}-error.exr"))
    assert luminance.shape == error.shape == (24, 24)
    assert 0 < error.sum() < 0.5 * luminance.sum()


def test_frames_begin_with_the_first_node(copy: Path) -> None:
    told = lelight(
        "render", copy, "--view", "1,1,1:1,0,0", "--method", "trace", "--size", "16", "--progress-frames"
    )
    assert told.status == 0, told.stderr
    frames = sorted(path.stem for path in (copy / "renders" / "view-trace-frames").glob("*.png"))
    assert frames[:3] == ["001 1 chain, 1 node", "002 1 chain, 2 nodes", "003 1 chain"]
    assert frames[-1] == "013 1024 chains"


def test_what_an_interrupted_picture_was_is_kept(copy: Path) -> None:
    picture = copy / "renders" / "view-trace.exr"
    arguments = ("--view", "1,1,1:1,0,0", "--method", "trace", "--size", "48", "--target", "0.01%")
    record = picture.with_suffix(".json")  # written after the picture
    running = process("render", copy, *arguments, "--threads", "1")
    due = time.monotonic() + 60
    while not record.exists() and time.monotonic() < due:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    _, stderr = running.communicate(timeout=30)
    assert running.returncode == 130
    assert "chains is kept in" in stderr.splitlines()[-1]
    assert read_exr(picture).max() > 0
    assert not list(picture.parent.glob(".lelight-*"))


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--target", "1%"), "--target is for --method trace"),
        (("--progress-frames",), "--progress-frames is for --method trace"),
        (("--method", "trace", "--progress-frames", "--chains", "field"), "leave --chains out"),
        (("--range", "1,100", "--decades", "3"), "leave --decades out"),
        (("--range", "100,1"), "positive and ascend"),
        (("--range", "1"), "not LOW,HIGH"),
        (("--isolines", "a"), "not a list of numbers"),
        (("--angle", "90"), "leave --angle out"),
        (("--projection", "perspective", "--angle", "200"), "179° at most"),
    ],
)
def test_misuse_is_told(arguments: tuple[str, ...], told: str) -> None:
    outcome = lelight("render", "out", "--view", "1,1,1:1,0,0", *arguments)
    assert outcome.status == 2
    assert told in " ".join(outcome.stderr.split())
