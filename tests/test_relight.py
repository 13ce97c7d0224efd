"""The last bounce's material changed after the run: against brute force, a full run, and on the command line."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from commandline import QUICK, lelight, write_room
from rooms import grey, lit, panel
from scipy.stats import t as student
from shapes import box
from test_angular import arrivals_at, expected_radiance, irradiances, made, upper_views

from lelight.checkpoint.keeper import Keeper
from lelight.comparison import sidak_level
from lelight.errors import OutputError
from lelight.estimate.angular import HarmonicDetail, angular_detail
from lelight.estimate.batch import estimate_batch
from lelight.estimate.blocks import Effort
from lelight.harmonics.basis import evaluate
from lelight.incident import IncidentLight
from lelight.preparation import prepare
from lelight.receivers import ILLUMINANCE
from lelight.settings import Settings
from lelight.storeddegree import lobe_degree
from lelight.writing.incidentfile import read_incident, write_incident

#: Tile of the room below: its side in m, and the number of directions in which it is looked at.
TILE, VIEWS, REPLICATES = 0.06, 24, 8


@pytest.mark.parametrize("exponent", [2.0, 8.0, 64.0, 200.0])
def test_one_accumulation_serves_every_exponent(exponent):
    """Kept once for exponents up to 256, against the sum over the same arrivals of the lobes themselves."""
    _, receivers = made(256.0)
    arrivals, views, degree = arrivals_at(receivers), upper_views(), lobe_degree(256.0)
    kept = HarmonicDetail(degree, 3, np.array([degree])).collect(receivers, arrivals)
    reflectances, _ = made(exponent)
    owner, _, light = irradiances(receivers, arrivals)
    illuminance = np.zeros((3, 3))
    np.add.at(illuminance, owner, light)
    lobes = np.array([lobe_degree(exponent)])
    coefficients = HarmonicDetail(degree, 3, lobes).coefficients(
        kept, receivers=receivers, illuminance=illuminance, reflectances=reflectances
    )
    found = np.einsum("vt,rtc->rvc", evaluate(degree, views), coefficients)
    expected = expected_radiance(receivers, arrivals, exponent, views)
    peaks = reflectances.specular[0] * (exponent + 2) / (2 * np.pi) * illuminance
    assert np.all(np.abs(found - expected) <= 0.01 * peaks[:, None, :] + 1e-9)


def room_with_tile(exponent):
    """A Lambertian room, and in it a glossy tile so small that what it sends back to the room is nothing."""
    tile = panel((2.0, 1.2, 1.0), (TILE, 0, 0), (0, TILE, 0))
    lamp = panel((1.2, 0.9, 2.4), (0.0, 0.8, 0.0), (1.1, 0.0, 0.0))
    materials = [
        grey("walls", 0.5),
        grey("tile", 0.1, specular=0.6, exponent=exponent),
        grey("lamp", 0.5, luminance=1000.0),
    ]
    return lit(box((4.0, 3.0, 2.5)), tile, lamp, materials=materials)


def tile_radiance(scene, other=None, *, seed):
    """Radiance (REPLICATES, VIEWS) of the tile's first node, by its own material or another stage's; and the stage."""
    settings = Settings(edge=0.6, relightable=64.0)
    with ThreadPoolExecutor(2) as executor:
        stage = prepare(scene, settings, executor, Keeper())
        lit_by = other or stage
        detail = angular_detail(stage.plan, stage.world.reflectances)
        detail = replace(detail, lobes=lit_by.plan.lobes)
        nodes = np.flatnonzero((stage.mesh.materials == 1) & (stage.mesh.sides == 1))[:1]
        receivers = stage.receivers[nodes]
        views = np.random.default_rng(5).normal(size=(VIEWS, 3))
        views[:, 2] = np.abs(views[:, 2])
        basis = evaluate(detail.degree, views / np.linalg.norm(views, axis=1)[:, None])
        rows = []
        for replicate in range(REPLICATES):
            batch = estimate_batch(
                stage.world,
                receivers,
                effort=Effort(11, 4, 12, 0.2),
                seed=(seed, replicate),
                base=stage.base,
                detail=detail,
                executor=executor,
            )
            coefficients = detail.coefficients(
                batch.angular,
                receivers=receivers,
                illuminance=(batch.direct + batch.indirect)[:, ILLUMINANCE],
                reflectances=lit_by.world.reflectances,
            )
            rows.append(basis @ coefficients[0, :, 0])
    return np.array(rows), stage


def smallest_p(one, other):
    """Smallest p value over the directions, Welch's t."""
    variances = one.var(axis=0, ddof=1) / len(one), other.var(axis=0, ddof=1) / len(other)
    t = (one.mean(axis=0) - other.mean(axis=0)) / np.sqrt(sum(variances))
    freedom = sum(variances) ** 2 / sum(v**2 / (REPLICATES - 1) for v in variances)
    return float((2 * student.sf(np.abs(t), freedom)).min())


def test_relit_equals_a_full_run_in_which_only_the_last_bounce_differs():
    full, sharp = tile_radiance(room_with_tile(64.0), seed=10)
    blunt, _ = tile_radiance(room_with_tile(4.0), seed=11)
    relit, _ = tile_radiance(room_with_tile(4.0), sharp, seed=11)
    level = sidak_level(VIEWS)
    assert smallest_p(relit, full) > level
    # It would be noticed: errors are small beside what the material makes.
    assert np.all(full.std(axis=0, ddof=1) / np.sqrt(REPLICATES) < 0.03 * full.mean())
    assert smallest_p(blunt, full) < 1e-3 * level


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    scene = write_room(tmp_path_factory.mktemp("relight") / "Büro ☀")
    outcome = lelight("calc", scene, *QUICK, "--relightable", "20", "--target", "20%")
    assert outcome.status == 0, outcome.stderr
    return scene.with_name("room.lelight")


def test_command_writes_a_folder_that_other_commands_read(out, tmp_path):
    to = tmp_path / "other"
    change = "wall={ reflectance = 0.2, specular = 0.4, exponent = 18 }"
    outcome = lelight("relight", out, "--material", change, "-o", to)
    assert outcome.status == 0, outcome.stderr
    assert outcome.stdout.strip() == str(to)
    assert "every illuminance, is still that of the old one" in outcome.stderr
    record = json.loads((to / "run.json").read_text())
    assert record["relit"] == {"wall": {"reflectance": 0.2, "specular": 0.4, "exponent": 18}}
    assert any(statement.startswith("Relit: wall") for statement in record["bias"])
    rendered = lelight("render", to, "--view", "1,1,1:1,0,0", "--size", "32")
    assert rendered.status == 0, rendered.stderr
    again = lelight("relight", to, "--material", change)
    assert again.status == 1 and "relit already" in again.stderr


def test_same_material_gives_the_same_field(out, tmp_path):
    from lelight.pipelines.render import stored_field

    change = "floor={ reflectance = 0.3, specular = 0.2, exponent = 12.0000000001 }"
    assert lelight("relight", out, "--material", change, "-o", tmp_path / "same").status == 0
    before, after = stored_field(out).values, stored_field(tmp_path / "same").values
    assert np.array_equal(before.illuminance, after.illuminance)
    scale = np.abs(before.radiance_sh).max()
    np.testing.assert_allclose(after.radiance_sh, before.radiance_sh, rtol=0, atol=1e-6 * scale)
    assert np.abs(before.radiance_sh[:, 1:]).max() > 0.01 * scale


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("wall={ specular = 0.2, exponent = 100 }", "--relightable 100"),
        ("wall={ luminance = 3 }", '"luminance" cannot be changed after a run'),
        ("wall={ specular = 0.9 }", "allowed is a sum of at most 1"),
        ("wall=0.3", "allowed is NAME={"),
        ("wall", "allowed is NAME={"),
        ("wall={ exponent = -1 }", "exponent: found -1"),
        ("roof={ reflectance = 0.3 }", 'matches no material; there are "floor", "wall", "panel"'),
        ("wall={ reflectance = [0.3, 0.2, 0.1] }", "coloured material in a grey run"),
    ],
)
def test_what_cannot_be_is_one_line(out, tmp_path, change, told):
    outcome = lelight("relight", out, "--material", change, "-o", tmp_path / "not")
    assert outcome.status == 1
    assert outcome.stderr.startswith("lelight: ") and outcome.stderr.count("\n") == 1
    assert told in outcome.stderr
    assert not (tmp_path / "not").exists()


def test_mirror_and_lambertian_surfaces_need_nothing_kept(out, tmp_path):
    (out / "incident.npz").rename(out / "aside.npz")
    try:
        matt = lelight("relight", out, "--material", "floor={ specular = 0 }", "-o", tmp_path / "matt")
        mirror = lelight(
            "relight", out, "--material", "panel={ specular = 0.4, exponent = 5000 }", "-o", tmp_path / "m"
        )
        glossy = lelight("relight", out, "--material", "floor={ exponent = 18 }", "-o", tmp_path / "glossy")
    finally:
        (out / "aside.npz").rename(out / "incident.npz")
    assert matt.status == 0 and mirror.status == 0, matt.stderr + mirror.stderr
    assert glossy.status == 1 and "no angular distribution" in glossy.stderr


def test_relightable_refuses_the_grid(tmp_path):
    scene = write_room(tmp_path / "grid")
    outcome = lelight("calc", scene, *QUICK, "--relightable", "20", "--method", "grid")
    assert outcome.status == 1 and "--relightable needs --method sh" in outcome.stderr


def small_light():
    degrees = np.array([1, 3, 2])
    coefficients = np.random.default_rng(3).normal(size=(3, 16, 2)).astype(np.float32)
    coefficients[np.arange(16) >= ((degrees + 1) ** 2)[:, None]] = 0.0
    return IncidentLight(np.array([2, 5, 9]), degrees, coefficients)


def test_incident_light_survives_its_file_to_the_bit(tmp_path):
    light = small_light()
    write_incident(tmp_path / "incident.npz", light)
    back = read_incident(tmp_path / "incident.npz")
    assert all(np.array_equal(vars(light)[name], vars(back)[name]) for name in vars(light))
    assert len(light.packed) == 4 + 16 + 9


def test_damaged_files_are_one_line(tmp_path):
    path = tmp_path / "incident.npz"
    write_incident(path, small_light())
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    for _ in range(200):
        content = bytearray(whole)
        for place in rng.integers(0, len(whole), 3):
            content[place] = rng.integers(256)
        path.write_bytes(content[: rng.integers(1, len(whole) + 1)])
        try:
            read_incident(path)
        except OutputError as error:
            assert "\n" not in str(error)
    packed = replace(small_light(), nodes=np.array([2, 2, 9]))
    write_incident(path, packed)
    with pytest.raises(OutputError, match="its nodes do not rise"):
        read_incident(path)
