"""The dial and the forecast: what a short run tells of a long one, and how a run keeps to its budget."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from commandline import lelight, write_room
from rooms import furnace, grey, lit, panel
from scipy.optimize import brentq
from shapes import box

from lelight.calculation import calculate
from lelight.checkpoint.keeper import Keeper
from lelight.dial import COARSEST, FINEST, edge_scale
from lelight.dialvalues import POINTS, POWER
from lelight.estimate.blocks import Effort
from lelight.estimate.effort import batches_for
from lelight.estimate.schedule import WANTED_BATCHES
from lelight.forecast import MOST_TARGET, Pilot, dialled_edge, forecast, pilot_run
from lelight.pipelines.pacing import paced
from lelight.settings import PRESETS, Settings

#: A machine of a million rays a second; 1000 receivers at an edge of 1 m, of which 900 nodes.
PILOT = Pilot(
    edge=1.0,
    vertices=900,
    nodes=900,
    receivers=1000,
    per_area=800.0,
    bare=100.0,
    remeshing=0.1,
    preparing=2.0,
    parts=np.array([3e-4, 2e-3, 2.5e-3]),
    ray_rate=1e6,
    effort=Effort(5, 2, 2, 1.0, variance=np.array([50.0, 0.5, 0.5]), cost=np.array([0.3, 2.0, 2.5])),
    least=0.2,
    pictures=3.0,
    pace=1.0,
    seconds=4.0,
)


def room():
    shapes = box((4.0, 3.0, 2.5)), panel((1.2, 0.9, 2.4), (0.0, 0.8, 0.0), (1.1, 0.0, 0.0))
    return lit(*shapes, materials=[grey("walls", 0.6), grey("lamp", 0.5, luminance=100.0)])


def test_presets_lie_on_the_dial():
    for name, values in PRESETS.items():
        assert Settings(preset=name).edge_scale == edge_scale(values.target)


def test_the_dial_passes_through_what_was_found_and_goes_on_by_its_power():
    for target, scale in POINTS:
        assert edge_scale(target) == pytest.approx(scale)
    (tightest, finest), (second, coarser) = POINTS[:2]
    assert edge_scale(math.sqrt(tightest * second)) == pytest.approx(math.sqrt(finest * coarser))
    assert edge_scale(tightest / 2.0) == pytest.approx(finest / 2.0**POWER)


def test_finer_targets_go_with_shorter_edges_within_limits():
    scales = [edge_scale(target) for target in (0.9, 0.2, 0.05, 0.02, 0.005, 1e-5)]
    assert scales == sorted(scales, reverse=True)
    assert all(FINEST <= scale <= COARSEST for scale in scales)
    assert edge_scale(1e-9) == FINEST
    assert Settings(target=0.05).edge_scale == edge_scale(0.05)


def test_work_grows_with_nodes_and_the_square_of_the_target():
    assert PILOT.vertices_at(0.5) == pytest.approx(100.0 + 3200.0)
    assert PILOT.growth(1.0) == pytest.approx(1.0)
    assert PILOT.growth(0.5) == pytest.approx(3.4)
    assert PILOT.estimate(1.0, 0.005) == pytest.approx(4.0 * PILOT.estimate(1.0, 0.01), rel=0.3)
    assert PILOT.estimate(0.5, 0.02) > 2.0 * PILOT.estimate(1.0, 0.02)
    # No run takes fewer rays than the pilot.
    assert PILOT.estimate(1.0, 0.5) == PILOT.estimate(1.0, 0.9)


def test_error_in_a_time_is_the_inverse_of_time_for_an_error():
    for target in (0.01, 0.03):
        seconds = PILOT.seconds_for(0.7, target)
        assert PILOT.error_in(0.7, seconds) == pytest.approx(target, rel=0.05)
    assert PILOT.error_in(0.7, 0.0) == PILOT.least


def test_the_edge_that_a_budget_buys_fills_it():
    edges = [dialled_edge(PILOT, 0.4, seconds) for seconds in (20.0, 60.0, 400.0)]
    assert edges == sorted(edges, reverse=True)
    for seconds, edge in zip((20.0, 60.0, 400.0), edges, strict=True):
        # The target that goes with the edge, by the dial the other way round.
        target = brentq(lambda each, edge=edge: 0.4 * edge_scale(each) - edge, 1e-4, POINTS[-2][0])
        assert PILOT.seconds_for(edge, target) == pytest.approx(seconds, rel=0.05)
    assert dialled_edge(PILOT, 0.4, 1.0) == pytest.approx(0.4 * edge_scale(MOST_TARGET))


def test_one_more_mesh_corrects_how_vertices_are_counted():
    corrected = PILOT.through(0.25, 20_000)
    assert corrected.vertices_at(0.25) == pytest.approx(20_000)
    assert corrected.vertices_at(PILOT.edge) == pytest.approx(PILOT.vertices)
    assert dialled_edge(corrected, 0.4, 400.0) > dialled_edge(PILOT, 0.4, 400.0)


def test_a_forecast_tells_nodes_memory_and_work_within_a_factor_of_one_and_a_half():
    # Not seconds: other work on the machine would decide. Rays stand for them.
    # The target asks for more than the least run there is.
    scene, settings = room(), Settings(edge=0.25, target=0.02, threads=2)
    told, _ = forecast(scene, settings)
    run = calculate(scene, settings)
    pilot, _ = pilot_run(scene, settings)
    assert told.nodes == pytest.approx(len(run.field.mesh), rel=0.1)
    assert told.error == 0.02
    count, samples = batches_for(pilot.effort, 0.02, batches=WANTED_BATCHES)
    foretold, taken = count * samples, run.replicates.units * run.effort.samples
    assert 1 / 1.5 < (foretold @ pilot.parts) / (taken @ pilot.parts) < 1.5
    assert 0.7 <= run.error.in_targets(0.02) <= 1.0


def test_a_loose_target_is_told_to_be_beaten():
    # In a small furnace the least run there is does better than 30 %.
    told, _ = forecast(furnace(0.5), Settings(edge=0.3, target=0.3, threads=2))
    assert told.error < 0.15


def test_pace_is_settled_once_and_only_for_a_budget():
    scene = room()
    keep = Keeper()
    assert paced(scene, Settings(edge=0.5), keep, spent=0.0) == (Settings(edge=0.5), None)
    assert paced(scene, Settings(time=60.0, batches=3), keep, spent=0.0)[1] is None
    settings, pace = paced(scene, Settings(time=30.0, threads=2), keep, spent=1.0)
    assert settings.edge is not None
    assert pace is not None
    assert 1.0 < pace.reserve < pace.before
    longer, _ = paced(scene, Settings(time=300.0, threads=2), keep, spent=1.0)
    assert longer.edge < settings.edge
    kept, _ = paced(scene, Settings(time=30.0, threads=2, edge=0.4), keep, spent=1.0)
    assert kept.edge == 0.4


def test_a_run_in_a_budget_says_what_it_took(tmp_path):
    scene = write_room(tmp_path)
    outcome = lelight("calc", scene, "--time", "15s", "--threads", "2")
    assert outcome.status == 0, outcome.stderr
    run = json.loads((tmp_path / "room.lelight" / "run.json").read_text(encoding="utf-8"))
    # Beyond the budget only by what the machine gives to others while results are written.
    assert 0.6 * 15.0 < run["seconds"]["total"] < 2.0 * 15.0
    assert run["replicates"] >= 8


def test_check_foretells_and_names_the_plan_of_what_light_reaches(tmp_path):
    scene = write_room(tmp_path)
    outcome = lelight("check", scene, "--preset", "draft", "--edge", "0.5", "--threads", "2")
    assert outcome.status == 0, outcome.stderr
    assert "to a relative standard error of" in outcome.stdout
    assert "patch sides carry nodes" in outcome.stdout
    assert "indirect light: chains" in outcome.stdout
