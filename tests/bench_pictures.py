"""Pictures of a room with exponents 8, 64 and 256: field and trace against each other and against other programs.

``pytest tests/bench_pictures.py -s`` prints what the README tells; a quarter of an hour on two free cores.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pathtracer import PathTracer
from test_pictures import evalglare
from threeglosses import EYE, FORWARD, drawn_directions, three_glosses

from lelight.calculation import calculate
from lelight.camera import Fisheye
from lelight.comparison import unpaired
from lelight.doublelocal import DoubleLocal, Unit, stored_base, traced_view
from lelight.estimate.blocks import Effort
from lelight.estimate.effort import bound_for
from lelight.estimate.variants import VARIANTS
from lelight.field import RadianceField
from lelight.scene import FloatArray
from lelight.settings import Settings
from lelight.tracedpicture import Exposing, Exposure, picture_effort
from lelight.writing.radiancehdr import write_hdr

RAYS, REPLICATES = 2000, 96
#: Root mean square of the difference that is allowed, as share of the mean radiance.
BAR = 0.02
#: Light is linear: the lamp of 4000 cd/m2, so that evalglare takes it for a source of glare.
BRIGHTER = 4.0
#: Draws for images of the lamp, as power of two, where no picture's time matters.
LOG2_IMAGES = 10


@cache
def field() -> RadianceField:
    return calculate(three_glosses(), Settings(target=0.02)).field


@pytest.fixture(scope="module")
def executor() -> Iterator[ThreadPoolExecutor]:
    with ThreadPoolExecutor(max_workers=2) as threads:
        yield threads


def estimate(executor: ThreadPoolExecutor) -> DoubleLocal:
    base = stored_base(field(), seed=5, executor=executor)
    return DoubleLocal(traced_view(field()), base, VARIANTS["base"], 5, executor)


@cache
def stored() -> FloatArray:
    """(rays,) cd/m²."""
    return field().seen(*drawn_directions(RAYS), log2_highlights=LOG2_IMAGES)[:, 0]


@pytest.fixture(scope="module")
def traced(executor: ThreadPoolExecutor) -> FloatArray:
    """(replicates, rays) cd/m²."""
    effort = Effort(
        log2_chains=6, log2_direct=4, log2_near=9, bound=0.4 * bound_for(field().world.area, 1024)
    )
    one = estimate(executor)
    rays = drawn_directions(RAYS)
    return np.stack([one.radiance(*rays, Unit(r, effort))[:, 0] for r in range(REPLICATES)])


@cache
def by_path_tracer() -> FloatArray:
    """(32, rays) cd/m², 2048 paths each: one path in a hundred carries most of the variance."""
    tracer = PathTracer(three_glosses(), seed=8)
    rays = drawn_directions(RAYS)
    parts = [[tracer.radiance(*rays, paths=128)[..., 0].mean(axis=1) for _ in range(16)] for _ in range(32)]
    return np.mean(parts, axis=1)


@cache
def by_mitsuba() -> FloatArray:
    """(16, rays) cd/m², 2048 paths each."""
    pytest.importorskip("mitsuba")
    from mitsuba_scene import mitsuba_scene, radiance_by_mitsuba

    scene = mitsuba_scene(three_glosses())
    rays = drawn_directions(RAYS)
    return np.stack([radiance_by_mitsuba(scene, *rays, paths=2048, seed=k + 1) for k in range(16)])


def rms_beyond_noise(found: FloatArray, found_error: FloatArray | float, reference: FloatArray) -> float:
    """Root mean square difference of ``found`` (k,) from what independent references (R, k) estimate, over their mean.

    Two halves of the references have independent noise, so that the product of both differences has none; the noise of
    what was found is taken off.
    """
    halves = reference[::2].mean(axis=0), reference[1::2].mean(axis=0)
    square = np.mean((found - halves[0]) * (found - halves[1]) - found_error**2)
    return float(np.sqrt(max(0.0, square)) / reference.mean())


@pytest.mark.parametrize("reference", [by_path_tracer, by_mitsuba])
def test_both_methods_have_the_radiance_of_other_programs(reference, traced: FloatArray) -> None:
    right = reference()
    trace_error = traced.std(axis=0, ddof=1) / np.sqrt(len(traced))
    noise = np.sqrt(np.mean(right.var(axis=0, ddof=1) / len(right))) / right.mean()
    for name, found, error in (("field", stored(), 0.0), ("trace", traced.mean(axis=0), trace_error)):
        raw = np.sqrt(np.mean((found - right.mean(axis=0)) ** 2)) / right.mean()
        beyond = rms_beyond_noise(found, error, right)
        print(
            f"{name} against {reference.__name__}: rms {raw:.4f}, beyond noise {beyond:.4f}; noise {noise:.4f}"
        )
        assert beyond < BAR
    different = unpaired(right, traced).significant()
    print(f"trace differs significantly along {different.sum()} of {RAYS} rays")
    assert not different.any()


def test_field_and_trace_agree_within_what_they_say(traced: FloatArray) -> None:
    # The field's own noise is 2 % of the illuminance and it interpolates; together they may differ by the bar.
    error = traced.std(axis=0, ddof=1) / np.sqrt(len(traced))
    off = stored() - traced.mean(axis=0)
    beyond = np.sqrt(max(0.0, np.mean(off**2 - error**2))) / traced.mean()
    print(f"field against trace: beyond noise {beyond:.4f}, mean {off.mean() / traced.mean():+.4f}")
    assert beyond < BAR


def test_a_picture_from_the_field_takes_less_than_two_seconds(executor: ThreadPoolExecutor) -> None:
    seconds, processor = [], []
    for shift in (0.0, 0.1, 0.2, 0.3):
        camera = Fisheye(EYE + np.array([shift, 0.0, 0.0]), FORWARD)
        began, spent = time.perf_counter(), time.process_time()
        field().picture(camera, 1000, 1000, samples=1, executor=executor)
        seconds.append(time.perf_counter() - began)
        processor.append(time.process_time() - spent)
    print(f"1000 x 1000 from the field: {min(seconds):.2f} s, {min(processor):.2f} processor seconds")
    # The first picture compiles or loads compiled code.
    assert min(seconds[1:]) < 2.0


def test_evalglare_rates_both_pictures_alike(executor: ThreadPoolExecutor, tmp_path: Path) -> None:
    camera, size = Fisheye(EYE, FORWARD), 400
    one = estimate(executor)
    exposure = Exposure(camera, size, size, samples=4)
    exposing = Exposing(one, exposure, picture_effort(one, exposure, target=0.05))
    pictures = {"field": field().picture(camera, size, size, samples=4, executor=executor)}
    for taken in exposing.run(target=0.05, time=None, clock=time.perf_counter):
        pictures["trace"] = taken.luminance
    told = {}
    for name, luminance in pictures.items():
        write_hdr(tmp_path / f"{name}.hdr", BRIGHTER * luminance, view=camera.view(size, size))
        told[name] = evalglare(tmp_path / f"{name}.hdr")
        print(name, {key: told[name][key] for key in ("dgp", "ugr", "E_v", "av_lum")})
    assert told["field"]["ugr"] > 0
    assert abs(told["field"]["dgp"] - told["trace"]["dgp"]) < 0.01
    assert abs(told["field"]["ugr"] - told["trace"]["ugr"]) < 0.5
