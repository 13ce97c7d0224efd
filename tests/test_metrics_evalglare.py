"""Ratings of pictures against evalglare 3.06: numbers it printed, and the program itself where it is installed."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest
from commandline import lelight
from radianceprograms import environment, program
from test_metrics_picture import OBSERVER, ONE, THREE, WEAK, fisheye, rate, scene

from lelight.camera import Fisheye
from lelight.metrics.daylight_glare import (
    View,
    cgi,
    dgi,
    dgi_modified,
    dgp,
    pgsv_contrast,
    pgsv_saturation,
    ugp,
    ugp2,
    ugr,
    ugr_experimental,
    vcp,
    veiling_cie,
    veiling_poynter,
)
from lelight.metrics.eye import carried
from lelight.metrics.picture import picture_glare
from lelight.metrics.zones import threshold_luminance, zone_statistics
from lelight.scene import Threshold
from lelight.writing.radiancehdr import write_hdr

SCENES = Path(__file__).parents[1] / "scenes"
AXIS = [(0, 0, 3, 10001.6)]
BELOW = [(0, -20, 5, 10001.6)]

# Discs, field; DGI, CGI and VCP as evalglare printed them and in closed form.
CASES = {
    "one": (ONE, 100.338, (19.372, 19.340), (27.610, 27.578), (11.79, 11.91)),
    "axis": (AXIS, 100.338, (22.092, 22.100), (29.613, 29.621), (5.05, 5.04)),
    "below": (BELOW, 100.338, (22.860, 22.869), (31.098, 31.107), (3.22, 3.21)),
    "three": (THREE, 59.958, (19.529, 19.499), (26.404, 26.361), (20.95, 21.12)),
    "weak": (WEAK, 39.943, (15.597, 15.560), (22.322, 22.285), (40.5, 40.8)),
}


@pytest.mark.parametrize("name", CASES)
def test_further_ratings_of_discs(name):
    # Pixels give a disc of 3 degrees its area to 0.3 %, which is 10 · 0.8 log10(1.003) = 0.01 of DGI.
    discs, field, *expected = CASES[name]
    view = rate(discs, field).view
    for function, (printed, closed), tolerance in zip(
        (dgi, cgi, vcp), expected, (0.01, 0.01, 0.06), strict=True
    ):
        assert function(view) == pytest.approx(closed, abs=tolerance)
        assert function(view) == pytest.approx(printed, abs=0.06 if function is not vcp else 0.35)


def one_source(**more):
    given = {
        "luminance": np.array([10_000.0]),
        "solid_angle": np.array([0.01]),
        "position": np.array([2.0]),
        "theta": np.array([math.radians(20)]),
        "vertical": 500.0,
        "direct": 100.0,
        "background": 400.0 / math.pi,
        "mean": 120.0,
    }
    return View(**given | more)


def test_ratings_of_one_source_by_hand():
    # L² ω / P² = 2.5e5, L ω / P² = 25, Lb = 127.324 cd/m².
    view = one_source()
    background = 400 / math.pi
    assert ugr(view) == pytest.approx(8 * math.log10(0.25 * 2.5e5 / background), rel=1e-12)
    assert ugp(view) == pytest.approx(0.26 * math.log10(0.25 * 2.5e5 / background), rel=1e-12)
    assert ugp2(view) == pytest.approx((1 + 2 / 7 * (2.5e5 / background) ** -0.2) ** -10, rel=1e-12)
    assert cgi(view) == pytest.approx(8 * math.log10(2 * 1.2 / 500 * 2.5e5), rel=1e-12)
    assert ugr_experimental(view) == pytest.approx(8 * math.log10(500 / math.pi * 25 / background), rel=1e-12)
    shaped = 0.478 * 1e4**1.6 * 0.0025**0.8
    assert dgi(view) == pytest.approx(10 * math.log10(shaped / (background + 70)), rel=1e-12)
    assert dgi_modified(view) == pytest.approx(
        10 * math.log10(shaped / ((500 / math.pi) ** 0.85 + 70)), rel=1e-12
    )
    assert veiling_cie(view) == pytest.approx(10 * 100 * math.cos(math.radians(20)) / 400, rel=1e-12)
    assert veiling_poynter(view) == pytest.approx(5 * 100 * math.cos(math.radians(20)) / 20, rel=1e-12)


def test_a_view_without_sources():
    none = np.zeros(0)
    view = one_source(luminance=none, solid_angle=none, position=none, theta=none, direct=0.0)
    assert vcp(view) == 100.0
    assert veiling_cie(view) == 0.0
    assert all(math.isnan(function(view)) for function in (ugr, dgi, cgi, ugp, ugp2, ugr_experimental))
    assert dgp(view) == pytest.approx(5.87e-5 * 500 + 0.159)


def test_a_source_on_the_line_of_sight_veils_without_end_but_for_the_clamp():
    assert veiling_cie(one_source(theta=np.zeros(1))) == pytest.approx(10 * 100 / 0.01, rel=1e-12)


def test_comfort_ends_at_both_sides():
    assert vcp(one_source(luminance=np.array([1e7]))) == 0.0
    assert vcp(one_source(luminance=np.array([1.0]))) == 100.0


def test_pgsv():
    assert pgsv_saturation(math.pi * 1250) == pytest.approx(3.3 - 3.87 / 2, rel=1e-12)
    assert pgsv_contrast(1000.0, 100.0, 0.1) == pytest.approx(
        9.6 + 0.64 + 2 * (-0.79 - 0.61) - 8.2, rel=1e-12
    )


def test_the_error_of_the_background_moves_all_but_the_sources():
    view = one_source()
    more = view.with_background(1.1)
    assert more.background == pytest.approx(1.1 * view.background)
    assert more.vertical == pytest.approx(100 + 440)
    assert more.direct == view.direct
    assert ugr(view) - ugr(more) == pytest.approx(8 * math.log10(1.1), rel=1e-9)


def test_thresholds_follow_task_and_picture():
    solid_angles, directions = fisheye()
    luminance = scene([(0, 0, 10.2, 400)], 100)
    arguments = (luminance, solid_angles, directions, OBSERVER)
    assert threshold_luminance(Threshold(1500.0), *arguments) == 1500.0
    assert threshold_luminance(Threshold(5.0, "task"), *arguments) == pytest.approx(2000.0)
    mean = 100 + 300 * (1 - math.cos(math.radians(10.2)))
    assert threshold_luminance(Threshold(7.0, "picture"), *arguments) == pytest.approx(7 * mean, rel=1e-3)


def test_zones_are_rings_around_the_task():
    solid_angles, directions = fisheye()
    luminance = scene([(0, 0, 10, 300)], 100)
    found = zone_statistics(luminance, solid_angles, directions, OBSERVER)
    assert found["task"]["mean"] == pytest.approx(300.0)
    assert found["surround"]["mean"] == pytest.approx(100.0, rel=0.01)
    assert found["background"]["median"] == 100.0
    rings = [
        2 * math.pi * (math.cos(math.radians(a)) - math.cos(math.radians(b)))
        for a, b in ((0, 10), (10, 30), (30, 60))
    ]
    assert [found[zone]["solid_angle"] for zone in ("task", "surround", "background")] == pytest.approx(
        rings, rel=5e-3
    )


def test_merging_and_peaks_can_be_chosen():
    discs = [(3.5, 20, 2, 5000), (-3.5, 20, 2, 5000)]
    assert len(rate(discs, 50).sources) == 1
    assert len(rate(discs, 50, gap=0.01).sources) == 2
    nested = [*ONE, (0, 20, 1, 99882)]
    (single,) = rate(nested, 100.338, peak=math.inf).sources
    # evalglare -x: one source of 13418.8 cd/m², UGR 26.995, DGP 0.2714.
    assert single.luminance == pytest.approx(13418.8, rel=5e-3)
    assert rate(nested, 100.338, peak=math.inf).ugr == pytest.approx(26.995, abs=0.06)


def evalglare(picture: Path) -> dict[str, float]:
    """What evalglare says of a picture; the test is skipped where it is not installed."""
    told = subprocess.run(
        [program("evalglare"), "-d", picture],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
        env=environment(),
    )
    names, _, numbers = told.stdout.strip().splitlines()[-1].partition(":")
    return dict(zip(names.split(","), map(float, numbers.split()), strict=True))


@pytest.mark.parametrize("name", ["below", "three"])
def test_evalglare_rates_our_pictures_alike(tmp_path, name):
    discs, field, *_ = CASES[name]
    luminance = np.where(fisheye()[0] > 0, scene(discs, field), 0.0)
    picture = tmp_path / "discs.hdr"
    write_hdr(picture, luminance, view=Fisheye(OBSERVER.position, OBSERVER.direction).view(1000, 1000))
    told, ours = evalglare(picture), picture_glare(luminance, *fisheye(), OBSERVER)
    assert ours.ugr == pytest.approx(told["ugr"], abs=0.06)
    assert ours.dgp == pytest.approx(told["dgp"], abs=7e-4)
    assert dgi(ours.view) == pytest.approx(told["dgi"], abs=0.06)
    assert cgi(ours.view) == pytest.approx(told["cgi"], abs=0.06)
    assert vcp(ours.view) == pytest.approx(told["vcp"], abs=0.4)
    assert ugp(ours.view) == pytest.approx(told["ugp"], abs=2e-3)
    assert ugp2(ours.view) == pytest.approx(told["ugp2"], abs=2e-3)
    assert dgi_modified(ours.view) == pytest.approx(told["dgi_mod"], abs=0.06)
    assert ugr_experimental(ours.view) == pytest.approx(told["ugr_exp"], abs=0.06)
    assert ours.vertical_illuminance == pytest.approx(told["E_v"], rel=1e-3)
    # Both veils follow the place of the source, which evalglare rounds down to a pixel.
    assert veiling_poynter(ours.view) == pytest.approx(told["Lveil"], rel=0.03)


def agree(out: Path):
    """Compare all observers of a result folder with evalglare."""
    observers = json.loads((out / "metrics.json").read_text(encoding="utf-8"))["observers"]
    for figures in observers.values():
        told = evalglare(out / "observers" / f"{figures['file']}.hdr")
        assert figures["dgp"]["value"] == pytest.approx(told["dgp"], abs=1e-3)
        assert figures["ugr_picture"]["value"] == pytest.approx(told["ugr"], abs=0.1)


@pytest.mark.parametrize("name", ["office", "cornell"])
def test_evalglare_rates_our_scenes_alike(tmp_path, name):
    hurried = ("--preset", "draft", "--target", "30%", "--threads", "2")
    outcome = lelight("calc", SCENES / f"{name}.toml", "-o", tmp_path, *hurried)
    assert outcome.status == 0, outcome.stderr
    agree(tmp_path)


def test_evalglare_rates_the_glossy_room_alike(run):
    agree(run.out)


def test_what_the_sources_alone_make_is_not_given_the_error_of_the_indirect_light():
    indirect = np.array([90.0, 100.0, 110.0])
    veil = carried(veiling_cie, one_source(), indirect, unit="cd/m²", method="picture", clause="CIE 146")
    assert (veil.std_error, veil.interval, veil.method) == (None, None, "picture")
    rating = carried(ugr, one_source(), indirect, unit="1", method="picture", clause="CIE 117")
    assert rating.std_error > 0.01
    assert rating.method != "picture"
