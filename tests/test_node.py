"""``lelight node``: numbers, glyph and picture of one node, against the field and closed forms."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from commandline import NASTY, lelight

from lelight.nodelight import luminance_body, nearest_node, seen_from
from lelight.pipelines.render import stored_field
from lelight.writing.bodyfile import write_glyph
from lelight.writing.polydata import PolyData
from lelight.writing.vtpreading import read_polydata


@pytest.fixture(scope="module")
def out(run, tmp_path_factory):
    """The folder of results once more, so that others find theirs as it was."""
    folder = Path(shutil.copytree(run.scene.parent, tmp_path_factory.mktemp("node") / "room"))
    return folder / run.out.name


@pytest.fixture(scope="module")
def field(out):
    return stored_field(out)


@pytest.fixture(scope="module")
def floor(field):
    return nearest_node(field, np.array([1.0, 1.0, 0.0]))


def test_numbers_picture_and_glyph(out):
    outcome = lelight("node", out, "--at", "1,1,0", "--json")
    assert outcome.status == 0, outcome.stderr
    table = json.loads(outcome.stdout)
    stem = out / "nodes" / str(table["node"])
    assert json.loads(stem.with_suffix(".json").read_text(encoding="utf-8")) == table
    assert stem.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    assert table["material"] == "floor" and table["side"] == "front"
    assert np.shape(table["luminance_cd_m2"]) == (31, 72)
    assert table["largest"]["luminance_cd_m2"] == np.max(table["luminance_cd_m2"])
    assert sum(table["energy_share_by_degree"]) == pytest.approx(1.0)
    assert len(table["energy_share_by_degree"]) == table["sh_degree"] + 1
    glyph = read_polydata(stem.with_suffix(".vtp"))
    reach = np.linalg.norm(glyph.points - table["position_m"], axis=1)
    assert reach.max() == pytest.approx(0.05 * np.sqrt(12), rel=1e-6)
    largest = glyph.point_arrays["luminance_cd_m2"].max()
    np.testing.assert_allclose(
        reach, glyph.point_arrays["luminance_cd_m2"] / largest * reach.max(), atol=1e-9
    )


def test_summary_names_what_was_written(out):
    outcome = lelight("node", out, "--at", "1,0.1,2", "--facing", "0,0,-1", "--length", "0.5")
    assert outcome.status == 0, outcome.stderr
    lines = outcome.stdout.splitlines()
    assert lines[0].startswith("node ") and "of wall" in lines[0]
    assert [line.rpartition(".")[2] for line in lines[-3:]] == ["png", "vtp", "json"]
    assert any(line.startswith(f"toward {NASTY}: ") for line in lines)


def test_body_is_the_field_at_that_node(field, floor):
    body = luminance_body(field, floor)
    position = np.tile(field.mesh.positions[floor], (6, 1))
    chosen = body.directions[::6, 10]
    parts = seen_from(field, floor, chosen)
    np.testing.assert_allclose(
        body.luminance[::6, 10] - body.images[::6, 10], parts.stored + parts.emitted, rtol=1e-12
    )
    # The field draws highlights by other numbers: what is stored agrees to rounding, all of it to their noise.
    around = field.radiance(position, chosen)[:, 0]
    np.testing.assert_allclose(body.luminance[::6, 10], around, rtol=0.15)


def test_exitance_of_a_lambertian_node_is_its_flux(field):
    wall = nearest_node(field, np.array([0.0, 1.0, 1.0]))
    body = luminance_body(field, wall)
    assert np.ptp(body.luminance) < 1e-6 * body.luminance.max()
    assert body.exitance == pytest.approx(0.6 * field.illuminance[wall], rel=1e-3)


def test_emission_stands_in_the_body(field):
    panel = nearest_node(field, np.array([1.0, 1.0, 1.9]), facing=np.array([0.0, 0.0, -1.0]))
    assert luminance_body(field, panel).emitted == pytest.approx(4000.0)
    above = nearest_node(field, np.array([1.0, 1.0, 1.9]), facing=np.array([0.0, 0.0, 1.0]))
    assert luminance_body(field, above).emitted == 0.0


def test_glyph_is_closed_and_faces_outside(field, floor, tmp_path):
    body = luminance_body(field, floor)
    write_glyph(tmp_path / "glyph.vtp", body, position=field.mesh.positions[floor], length=1.0)
    glyph: PolyData = read_polydata(tmp_path / "glyph.vtp")
    corners = glyph.points[glyph.polygons] - field.mesh.positions[floor]
    volume = np.einsum("tx,tx->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    # int r^3 / 3 over the hemisphere, as the luminance in units of its largest value.
    shape = (body.luminance / body.luminance.max()) ** 3 / 3
    expected = np.trapezoid(shape.mean(axis=1) * 2 * np.pi * np.sin(body.zenith), body.zenith)
    assert volume == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "status", "told"),
    [
        (("--at", "1,1"), 2, "is not X,Y,Z"),
        (("--at", "1,1,nan"), 2, "is not X,Y,Z"),
        (("--at", "1,1,0", "--facing", "0,0,0"), 1, "no visible node looks that way"),
        ((), 2, "--at"),
    ],
)
def test_what_cannot_be_is_told(out, arguments, status, told):
    outcome = lelight("node", out, *arguments)
    assert outcome.status == status and told in outcome.stderr
