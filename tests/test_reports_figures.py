"""What the figures of the reports choose to show, before it is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from test_reports_resultfolder import ROOM, make_result_folder

from lelight.reports.angular import ANGLES, angular_pages, chosen_nodes, read_angular_field
from lelight.reports.figures.isometric import TO_CAMERA, _painted
from lelight.reports.figures.planechart import isolines
from lelight.reports.figures.scales import _told_apart, illuminance_scale, luminance_scale
from lelight.reports.folder import open_folder
from lelight.reports.glare import _dgp_class
from lelight.reports.nodemesh import read_lit_mesh
from lelight.reports.reading import Reading
from lelight.reports.texts import languages, read_texts
from lelight.reports.viewpoints import read_layout


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return open_folder(make_result_folder(tmp_path_factory.mktemp("figures") / "x", pixels=16))


def test_the_angular_field_is_that_of_the_harmonics(folder):
    field = read_angular_field(folder)
    (node,) = chosen_nodes(field)
    # The floor sends 10 + 4 cos(angle to the direction halfway between the normal and x).
    assert field.points[node][2] == 0.0
    angle = np.radians(30.0)
    direction = np.array([[np.sin(angle), 0.0, np.cos(angle)]])
    assert field.luminance(node, direction)[0] == pytest.approx(10 + 4 * np.cos(np.radians(15.0)), rel=1e-6)
    # Exitance over π: 10 + 4 / √2 · 2/3.
    assert field.even[node] == pytest.approx(10 + 4 / np.sqrt(2) * 2 / 3, rel=1e-3)
    page, figures = angular_pages(folder)
    assert [entry["material"] for entry in page["nodes"]] == ["floor wood"]
    assert float(page["nodes"][0]["ratio"]) == pytest.approx(14.0 / 11.886, abs=0.006)
    assert list(figures) == ["radiance-N1.svg"]
    assert np.ptp(ANGLES) < 180.0


def test_the_isometric_view_shows_what_faces_the_eye_the_nearest_last(folder):
    mesh = read_lit_mesh(folder.path / "field.vtp")
    shapes, _, _ = _painted(mesh, illuminance_scale(mesh.illuminance))
    faces = np.array([shape for shape in shapes if len(shape) == 3])
    # Floor of 12 x 8, far walls of 8 x 6 and 12 x 6 squares, two triangles each; no ceiling, no near wall.
    assert len(faces) == 2 * (96 + 48 + 72)
    flat = [np.all(faces[:, :, axis] == at, axis=1) for axis, at in ((0, ROOM[0]), (1, ROOM[1]), (2, 0.0))]
    assert np.all(np.any(flat, axis=0))
    assert np.all(np.diff(faces.mean(axis=1) @ TO_CAMERA) >= -1e-12)


def test_plan_knows_luminaires_and_what_shines(folder):
    layout = read_layout(folder, [])
    assert [lamp.mark for lamp in layout.lamps] == ["L1", "L2", "L3"]
    # 0.3 m along C0, which points along y, and 0.6 m along C90.
    np.testing.assert_allclose(np.ptp(layout.lamps[1].outline, axis=0), (0.6, 0.3, 0.0), atol=1e-12)
    # The material "panel" is that of the whole ceiling in this folder: its outline, 2 (12 + 8) edges.
    assert layout.shining.shape == (40, 2, 3)
    assert np.all(layout.shining[:, :, 2] == ROOM[2])


def test_a_small_bright_lamp_leaves_the_scale_to_the_room():
    room = np.geomspace(5.0, 80.0, 10_000)
    lamp = np.full(50, 50_000.0)
    scale = luminance_scale([np.concatenate([room, lamp])])
    assert (scale.smallest, scale.largest) == (3.0, 100.0)
    assert (scale.below, scale.above) == (False, True)
    assert not luminance_scale([room]).above


def test_numbers_of_a_legend_have_room():
    ticks = illuminance_scale(np.geomspace(0.2, 1500.0, 1000)).ticks
    assert _told_apart(ticks, height=100.0) == list(ticks)
    # Eight numbers of 3.4 mm have room on 40 mm, eleven and more have not.
    assert _told_apart(ticks, height=40.0) == [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0]
    assert _told_apart(ticks, height=20.0) == [1.0, 10.0, 100.0, 1000.0]


@pytest.mark.parametrize(
    ("span", "standard", "even"),
    [
        # 300 alone between the extremes tells little; from 150 lx on there are steps enough.
        ((260.0, 480.0), [300.0], True),
        ((120.0, 480.0), [150.0, 200.0, 300.0], False),
        ((310.0, 460.0), [], True),
    ],
)
def test_isolines_stand_at_the_steps_of_the_standard_and_between_few_of_them(span, standard, even):
    of_standard, between = isolines(np.linspace(*span, 12).reshape(3, 4))
    assert of_standard == standard
    assert bool(between) == even
    assert not set(between) & set(standard)


@pytest.mark.parametrize(
    ("value", "named"),
    [(0.2, "imperceptible"), (0.35, "perceptible"), (0.44, "disturbing"), (0.6, "intolerable")],
)
def test_classes_of_dgp(value, named):
    texts = read_texts()
    assert _dgp_class(Reading("dgp", texts.term("dgp"), value, ""), texts) == named


def test_every_language_has_every_text():
    assert "en" in languages()
    with pytest.raises(ValueError, match="'xx' is none of en"):
        read_texts("xx")
    english = read_texts("en")
    for texts in map(read_texts, languages()):
        assert set(texts.labels) == set(english.labels)
        assert list(texts.terms) == list(english.terms)
        assert len(texts.glossary) == len(english.glossary)
