"""Lint rules, each on a scene that has the fault and on one that has not."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from lelight.reading.lint import Finding, lint, material_table
from lelight.scene import FloatArray, IntArray, Material, Scene

WALL = Material("wall", np.full(3, 0.5))
LAMP = Material("lamp", np.full(3, 0.5), luminance=np.full(3, 100.0))

#: Unit cube seen from outside, two triangles a face; the first two are the floor, the next two the ceiling.
CUBE = np.array(
    [
        *([0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4]),
        *([1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]),
    ]
)
CUBE_VERTICES = np.array(
    [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float
)


def room(*, lamp_out: bool = False) -> Scene:
    """A closed cube whose walls face inward; its ceiling emits."""
    triangles = CUBE[:, ::-1].copy()
    triangles[2:4] = CUBE[2:4] if lamp_out else triangles[2:4]
    materials = np.array([0, 0, 1, 1] + [0] * 8)
    return Scene("cube", CUBE_VERTICES, triangles, materials, (WALL, LAMP))


def rules(scene: Scene) -> list[str]:
    return [finding.rule for finding in lint(scene)]


@dataclass(frozen=True)
class _Hits:
    triangle: IntArray


@dataclass(frozen=True)
class _AlwaysMeets:
    """A caster whose rays all meet the same triangle, or -1 for none."""

    answer: int

    def closest(self, origins: FloatArray, _directions: FloatArray) -> _Hits:
        return _Hits(np.full(len(origins), self.answer))


def test_a_sound_room_has_no_findings() -> None:
    assert lint(room()) == ()


def test_what_reading_said_is_passed_on() -> None:
    scene = replace(room(), warnings=('a.toml: materials."x*" matches no material',))
    assert lint(scene) == (Finding("reading", "warning", 'a.toml: materials."x*" matches no material'),)


def test_duplicate_faces_are_counted_whatever_their_winding_and_vertices() -> None:
    scene = room()
    vertices = np.concatenate([scene.vertices, scene.vertices + 1e-9])
    triangles = np.concatenate([scene.triangles, scene.triangles[:2, ::-1] + 8])
    materials = np.append(scene.triangle_materials, [0, 0])
    findings = lint(replace(scene, vertices=vertices, triangles=triangles, triangle_materials=materials))
    assert [finding.rule for finding in findings] == ["duplicate faces"]
    assert findings[0].text.startswith("2 faces lie on another one, the first at (")


def test_open_edges_are_counted_and_placed() -> None:
    """Without one floor triangle, (0, 2, 1), three edges belong to one face only."""
    scene = room()
    findings = lint(
        replace(scene, triangles=scene.triangles[1:], triangle_materials=scene.triangle_materials[1:])
    )
    assert [(finding.rule, finding.severity) for finding in findings] == [("open edges", "note")]
    assert findings[0].text.startswith("3 edges of one face only, the first at (0.")


def test_seams_between_unshared_vertices_are_not_open() -> None:
    scene = room()
    apart = replace(scene, vertices=scene.corners.reshape(-1, 3), triangles=np.arange(36).reshape(-1, 3))
    assert lint(apart) == ()


def test_slivers_are_degenerate() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-7, 0], [0, 1, 0.0]])
    scene = Scene("sliver", vertices, np.array([[0, 1, 2], [0, 1, 3]]), np.array([0, 0]), (WALL,))
    assert "degenerate faces" in rules(scene)
    assert "degenerate faces" not in rules(replace(scene, triangles=np.array([[0, 1, 3], [1, 2, 3]])))


def test_emitter_turned_out_of_the_room() -> None:
    findings = lint(room(lamp_out=True))
    assert [(finding.rule, finding.severity) for finding in findings] == [("flipped emitters", "warning")]
    assert 'material "lamp"' in findings[0].text


def test_emission_from_both_sides_cannot_be_flipped() -> None:
    scene = room(lamp_out=True)
    assert lint(replace(scene, materials=(WALL, replace(LAMP, emission_sides="both")))) == ()


@pytest.mark.parametrize(
    ("lamp_out", "answer", "flipped"),
    [
        (False, 0, False),  # the floor, 1 m below the lamp
        (False, -1, False),  # nothing below, but the lamp looks towards the middle
        (True, -1, True),  # out into the open
        (False, 2, True),  # its own plane: a surface at once
    ],
)
def test_flipped_emitters_by_rays(lamp_out: bool, answer: int, flipped: bool) -> None:
    findings = lint(room(lamp_out=lamp_out), caster=_AlwaysMeets(answer))
    assert [finding.rule for finding in findings] == ["flipped emitters"] * flipped


def test_odd_materials() -> None:
    bright = Material("snow", np.full(3, 0.9), specular=np.array([0.0, 0.06, 0.0]), exponent=10)
    idle = Material("paint", np.full(3, 0.5), exponent=10)
    findings = lint(replace(room(), materials=(bright, idle)))
    assert [(finding.rule, finding.severity) for finding in findings] == [
        ("bright material", "warning"),
        ("idle exponent", "note"),
    ]
    assert findings[0].text.startswith('material "snow" reflects (0.9, 0.96, 0.9) of the light')


def test_material_table_counts_faces_and_areas() -> None:
    wall, lamp = material_table(room())
    assert (wall.name, wall.faces, lamp.name, lamp.faces) == ("wall", 10, "lamp", 2)
    assert (wall.area, lamp.area) == pytest.approx((5, 1), rel=1e-12)
    assert lamp.luminance.tolist() == [100, 100, 100]
    assert (wall.reflectance.tolist(), wall.origin) == ([0.5] * 3, "default")
