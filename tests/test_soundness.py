"""No NaN, no infinity and no negative light leaves a stage; stage and place are named."""

from __future__ import annotations

import numpy as np
import pytest
from commandline import ROOM_TOML, lelight, write_room

from lelight import calculation, outcome
from lelight.calculation import calculate
from lelight.errors import NumberError
from lelight.pipelines.eyes import look
from lelight.reading.loading import load
from lelight.receivers import ILLUMINANCE
from lelight.settings import Settings
from lelight.soundness import require_sound, require_sound_picture

SETTINGS = Settings(edge=0.7, batches=2, threads=1)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return load(write_room(tmp_path_factory.mktemp("room"), toml=ROOM_TOML))


def spoilt(function, spoil):
    """A stage whose finding is tampered with."""

    def stage(*arguments, **options):
        found = function(*arguments, **options)
        spoil(found)
        return found

    return stage


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_direct_light_of_a_batch_is_a_number(scene, monkeypatch, wrong):
    def spoil(batch):
        batch.direct[3, ILLUMINANCE, 0] = wrong

    monkeypatch.setattr(calculation, "estimate_batch", spoilt(calculation.estimate_batch, spoil))
    with pytest.raises(NumberError, match=rf"stage estimate: direct light at node 3, \(.*is {wrong!r} "):
        calculate(scene, SETTINGS)


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (lambda batch: batch.indirect.__setitem__((5, 2), np.nan), "indirect light at node 5"),
        (lambda batch: batch.indirect.__setitem__((-1, 2), np.inf), r"indirect light at the place \("),
        (lambda batch: batch.angular.__setitem__((0, 1), np.nan), "angular detail at node .* on 'floor'"),
    ],
)
def test_everything_else_of_a_batch_is_a_number(scene, monkeypatch, spoil, named):
    monkeypatch.setattr(calculation, "estimate_batch", spoilt(calculation.estimate_batch, spoil))
    with pytest.raises(NumberError, match=f"stage estimate: {named}"):
        calculate(scene, SETTINGS)


def test_mesh_base_field_and_planes_are_checked(scene, monkeypatch, tmp_path):
    prepare = calculation.prepare
    for spoil, named in (
        (lambda stage: stage.mesh.positions.__setitem__((2, 1), np.nan), "stage mesh: positions at node 2"),
        (lambda stage: stage.mesh.areas.__setitem__(4, -1.0), "stage mesh: area at node 4"),
        (
            lambda stage: stage.base.illuminance.__setitem__((1, 0), np.nan),
            "stage base: illuminance at node 1",
        ),
    ):
        monkeypatch.setattr(calculation, "prepare", spoilt(prepare, spoil))
        with pytest.raises(NumberError, match=named):
            calculate(scene, SETTINGS)
    monkeypatch.setattr(calculation, "prepare", prepare)
    for name, quantity in (("illuminance", "illuminance"), ("std_error", "standard error")):
        spoil = lambda field, name=name: getattr(field.values, name).__setitem__(7, -0.5)  # noqa: E731
        monkeypatch.setattr(calculation, "found_field", spoilt(outcome.found_field, spoil))
        with pytest.raises(NumberError, match=rf"stage fit: {quantity} at node 7, .* is -0.5 \(1 of"):
            calculate(scene, SETTINGS)
    monkeypatch.setattr(calculation, "found_field", outcome.found_field)
    monkeypatch.setattr(
        calculation,
        "found_on_planes",
        spoilt(outcome.found_on_planes, lambda planes: planes[0].cylindrical.__setitem__(6, np.nan)),
    )
    out = tmp_path / "out"
    told = lelight("calc", scene.path, "-o", out, "--edge", "0.7", "--target", "20%", "--quiet")
    assert told.status == 1 and told.stderr.startswith(
        "lelight: stage fit: cylindrical at point 6 of plane 'work plane' is nan"
    )
    assert not (out / "field.vtp").exists()


def test_pictures_are_checked(scene):
    from concurrent.futures import ThreadPoolExecutor

    run = calculate(scene, SETTINGS)
    run.field.values.illuminance[:] = np.inf
    with ThreadPoolExecutor(1) as executor, pytest.raises(NumberError, match=r"stage picture: luminance at"):
        look(run.field, scene.observers[0], size=32, samples=1, executor=executor)
    require_sound_picture(np.ones(4), "desk")


def test_a_sum_that_overflows_is_no_fault_of_its_terms():
    require_sound(np.full((3, 2), 1e308), stage="x", quantity="y", named=str)
    require_sound(np.zeros((0, 2)), stage="x", quantity="y", named=str)
