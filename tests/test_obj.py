"""OBJ files as exporters write them, and as nobody should."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lelight.errors import InputError
from lelight.reading.obj import ObjGeometry, read_obj
from lelight.reading.polygons import ear_clipping
from lelight.scene import triangle_areas

SQUARE = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read(folder: Path, contents: bytes) -> ObjGeometry:
    path = folder / "Möbel 1.obj"
    path.write_bytes(contents)
    return read_obj(path)


def complaint(folder: Path, contents: bytes) -> str:
    with pytest.raises(InputError) as caught:
        read(folder, contents)
    text = str(caught.value)
    assert text.isprintable()
    return text.removeprefix(f"{folder / 'Möbel 1.obj'}:")


def test_polygon_becomes_a_fan_with_its_winding(tmp_path: Path) -> None:
    geometry = read(tmp_path, SQUARE + b"f 1 2 3 4\n")
    assert geometry.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert geometry.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert geometry.material_names == ("default",)
    assert geometry.triangle_materials.tolist() == [0, 0]
    assert geometry.warnings == ()


@pytest.mark.parametrize(
    "face",
    [b"f 1/1 2/2 3/3", b"f 1//1 2//1 3//1", b"f 1/4/1 2/4/1 3/4/1", b"f -4 -3 -2", b"f\t1  2\t3 # corner"],
)
def test_corner_forms_mean_the_same_triangle(tmp_path: Path, face: bytes) -> None:
    assert read(tmp_path, SQUARE + face).triangles.tolist() == [[0, 1, 2]]


def test_negative_numbers_count_back_from_their_own_line(tmp_path: Path) -> None:
    geometry = read(tmp_path, SQUARE + b"f -4 -3 -2\n" + SQUARE + b"f -4 -3 -2\n")
    assert geometry.triangles.tolist() == [[0, 1, 2], [4, 5, 6]]


def test_vertices_keep_every_digit_and_drop_weight_and_colour(tmp_path: Path) -> None:
    lines = b"v 0.1234567890123456 1e-3 -2.5E+1\nv 1 0 0 1.0\nv 0 1 0 0.5 0.5 0.5\nf 1 2 3\n"
    vertices = read(tmp_path, lines).vertices
    assert vertices.tolist() == [[0.1234567890123456, 1e-3, -25.0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize("ending", [b"\n", b"\r\n", b"\r"])
def test_line_ends_mark_and_continuation(tmp_path: Path, ending: bytes) -> None:
    text = (
        b"\xef\xbb\xbf# a path C:\\\n"
        + SQUARE
        + b"g a\no b\ns 1\nvt 0 0\nvn 0 0 1\nf 1 \\\n 2 \\\n 3\nl 1 2\np 1"
    )
    assert read(tmp_path, text.replace(b"\n", ending)).triangles.tolist() == [[0, 1, 2]]


def test_continued_lines_keep_the_numbering(tmp_path: Path) -> None:
    assert complaint(tmp_path, SQUARE + b"f 1 \\\n2 3\nf 1 \\\n2 9\n").startswith(
        "7: f: found vertex number 9;"
    )


def test_materials_follow_usemtl(tmp_path: Path) -> None:
    names = "usemtl weiße Wand\nf 1 2 3\nusemtl b#2\nf 1 2 3\nusemtl weiße Wand\nf 1 3 4\n"
    geometry = read(tmp_path, SQUARE + b"f 1 2 3\n" + names.encode())
    assert geometry.material_names == ("default", "weiße Wand", "b#2")
    assert geometry.triangle_materials.tolist() == [0, 1, 2, 1]


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_names_in_either_encoding(tmp_path: Path, encoding: str) -> None:
    geometry = read(tmp_path, SQUARE + "usemtl à Möbel\nf 1 2 3\n".encode(encoding))
    assert geometry.material_names == ("à Möbel",)


def test_unknown_statements_are_said_once(tmp_path: Path) -> None:
    geometry = read(tmp_path, b"surf 0 1\n" + SQUARE + b"surf 0 1\nf 1 2 3\n")
    assert geometry.warnings == ('Möbel 1.obj:1: statements that are not read: "surf"',)


def test_concave_polygon_covers_its_own_area(tmp_path: Path) -> None:
    """An L of three unit squares, first corner so that a fan would cover the notch: area 3, normal +z."""
    outline = b"v 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\n"
    geometry = read(tmp_path, outline + b"f 1 2 3 4 5 6\nf 6 5 4 3 2 1\nf 1 2 3\n")
    corners = geometry.vertices[geometry.triangles]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (doubled[:4] > 0).all()
    assert (doubled[4:8] < 0).all()
    assert doubled[:4].sum() == pytest.approx(6, rel=1e-12)
    assert doubled[4:8].sum() == pytest.approx(-6, rel=1e-12)
    assert geometry.triangles[8].tolist() == [0, 1, 2]


@pytest.mark.parametrize("turn", range(10))
def test_hole_over_a_bridge(turn: int) -> None:
    """A 4 x 4 square with a 2 x 2 hole, joined by a doubled edge as exporters do: area 16 - 4."""
    ring = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]
    corners = np.array([(x, 1.5, y) for x, y in np.roll(ring, turn, axis=0)], dtype=np.float64)
    triangles = ear_clipping(corners)
    assert triangles is not None
    assert triangle_areas(corners[triangles]).sum() == pytest.approx(12, rel=1e-12)
    centres = corners[triangles].mean(axis=1)[:, [0, 2]]
    assert not (np.abs(centres - 2) < 1).all(axis=1).any()


@given(st.lists(st.floats(0.2, 1.0), min_size=5, max_size=40), st.integers(0, 2), st.booleans())
def test_star_shaped_polygons_are_covered(radii: list[float], axis: int, clockwise: bool) -> None:
    """Triangles that cover a polygon without overlap have its area, which is the shoelace formula's."""
    angles = 2 * np.pi * np.arange(len(radii)) / len(radii)
    plane = np.array(radii)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    plane = plane[::-1] if clockwise else plane
    corners = np.insert(plane, axis, 0.3, axis=1)
    x, y = plane.T
    shoelace = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    triangles = ear_clipping(corners)
    assert triangles is not None
    assert triangle_areas(corners[triangles]).sum() == pytest.approx(shoelace, rel=1e-9)


def test_outline_that_crosses_itself_is_said(tmp_path: Path) -> None:
    bow = b"v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 3 0\nf 1 2 3 4\n"
    assert read(tmp_path, bow).warnings == (
        "Möbel 1.obj:5: 1 polygons whose outline crosses itself, cut as a fan",
    )


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (b"f 1 2", "5: f: found 2 corners; allowed are 3 or more"),
        (b"f 1 2 0", "5: f: found vertex number 0; allowed are 1 to 4, or -1 to -4"),
        (b"f 1 2 5", "5: f: found vertex number 5; allowed are 1 to 4"),
        (b"f 1 2 -5", "5: f: found vertex number -5; allowed are 1 to 4"),
        (b"f 1 2 x", '5: f: found "1 2 x"; allowed are corners like'),
        (b"f 1/2/3/4 2 3", '5: f: found "1/2/3/4 2 3"; allowed are corners like'),
        (b"f 1 2 1_0", '5: f: found "1 2 1_0"; allowed are corners like'),
        (b"f 1 2 99999999999999999999", '5: f: found "1 2 99999999999999999999"; allowed are vertex numbers'),
        (b"v 1 2", "5: v: found 2 numbers; allowed are 3"),
        (b"v 1 2 3 4 5", "5: v: found 5 numbers; allowed are 3"),
        (b"v 1 2 3,5", '5: v: found "3,5"; allowed are numbers like'),
        (b"v 1 2 1_0", '5: v: found "1 2 1_0"; allowed are numbers like'),
        (b"v 1 nan 3\nf 1 2 3", "5: v: found [1.0, nan, 3.0]; allowed are finite numbers"),
        (b"v 1 -inf 3\nf 1 2 3", "5: v: found [1.0, -inf, 3.0]; allowed are finite numbers"),
        (b"v 1 1e300 3\nf 1 2 3", "5: v: found [1.0, 1e+300, 3.0]; allowed are finite numbers up to 1e+12"),
        (b"mtllib", "5: mtllib: found no file name"),
        (b"", " has no faces"),
    ],
)
def test_mistakes_name_their_line(tmp_path: Path, line: bytes, says: str) -> None:
    assert complaint(tmp_path, SQUARE + line).startswith(says)


def test_libraries_with_spaces_or_several(tmp_path: Path) -> None:
    for name in ("a.mtl", "b.mtl", "c d.mtl", "ü.mtl"):
        (tmp_path / name).touch()
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "e.mtl").touch()

    def libraries(names: str) -> list[str]:
        geometry = read(tmp_path, SQUARE + f"mtllib {names}\nf 1 2 3".encode())
        return [path.relative_to(tmp_path).as_posix() for path in geometry.material_libraries]

    assert libraries("c d.mtl") == ["c d.mtl"]
    assert libraries("a.mtl b.mtl") == ["a.mtl", "b.mtl"]
    assert libraries("a.mtl c d.mtl ü.mtl") == ["a.mtl", "c d.mtl", "ü.mtl"]
    assert libraries(".\\sub\\e.mtl\nmtllib a.mtl\nmtllib a.mtl") == ["sub/e.mtl", "a.mtl"]


def test_missing_library_names_file_and_folder(tmp_path: Path) -> None:
    text = complaint(tmp_path, b"mtllib not there.mtl\n" + SQUARE + b"f 1 2 3")
    assert text.startswith(
        f'1: mtllib: "not there.mtl" is not in the folder {tmp_path}; put it there, or delete'
    )


@pytest.mark.parametrize("name", ["{outside}/x.mtl", "../x.mtl", "sub/../../x.mtl", "link.mtl", "C:\\x.mtl"])
def test_libraries_outside_the_folder_are_refused(tmp_path: Path, name: str) -> None:
    inside = tmp_path / "scene"
    inside.mkdir()
    (tmp_path / "x.mtl").write_text("newmtl secret\n", encoding="utf-8")
    (inside / "link.mtl").symlink_to(tmp_path / "x.mtl")
    text = complaint(inside, f"mtllib {name.format(outside=tmp_path)}\n".encode() + SQUARE + b"f 1 2 3")
    assert "leads out of the folder of the OBJ file" in text


def test_files_that_are_not_obj(tmp_path: Path) -> None:
    assert "binary" in complaint(tmp_path, bytes(range(256)) * 10)
    assert "has no faces" in complaint(tmp_path, b"")
    assert "has no faces" in complaint(tmp_path, b"\x89PNG\x1b[31m \x7f\n" * 1000)
    assert "1: found a line of more than 1048576 bytes" in complaint(tmp_path, b"f 1" + b" 1" * 2**20)
    assert "1: found a line of more than 1048576 bytes" in complaint(tmp_path, b"f 1 1 1 1\\\n" * 2**17)
    with pytest.raises(InputError, match="is a folder; give the file itself"):
        read_obj(tmp_path)
    os.mkfifo(tmp_path / "pipe.obj")
    with pytest.raises(InputError, match="is not a regular file"):
        read_obj(tmp_path / "pipe.obj")
    with pytest.raises(InputError, match="no such file"):
        read_obj(tmp_path / "absent.obj")


def test_concave_polygon_too_large_to_cut(tmp_path: Path) -> None:
    """A comb of 10 002 corners; a convex polygon of as many is a fan and passes."""
    n_corners = 10_002
    angles = 2 * np.pi * np.arange(n_corners) / n_corners
    indices = b"f " + b" ".join(b"%d" % corner for corner in range(1, n_corners + 1))

    def star(radii: np.ndarray) -> bytes:
        points = radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return b"".join(b"v %.17g %.17g 0\n" % (x, y) for x, y in points) + indices

    assert len(read(tmp_path, star(np.ones(n_corners))).triangles) == n_corners - 2
    text = complaint(tmp_path, star(1 + 0.3 * (np.arange(n_corners) % 2)))
    assert text.startswith("10003: f: found a concave polygon of 10002 corners; allowed are 10000")


def test_mutated_files_are_read_or_refused_in_one_line(tmp_path: Path) -> None:
    sample = (
        b"mtllib a.mtl\no b\n" + SQUARE + b"usemtl m\nf 1/1/1 2/1/1 3/1/1 \\\n 4/1/1\nf -1 -2 -3\nl 1 2\n"
    )
    (tmp_path / "a.mtl").touch()
    rng = np.random.default_rng(1)
    outcomes = {"read": 0, "refused": 0}
    for _ in range(400):
        text = bytearray(sample)
        for _ in range(rng.integers(1, 5)):
            place = int(rng.integers(len(text)))
            text[place : place + int(rng.integers(3))] = rng.choice(
                [b"9", b"-", b"\n", b"\xff", b" ", b"/", b"e", b"v"]
            )
        try:
            geometry = read(tmp_path, bytes(text))
        except InputError as error:
            assert str(error).isprintable()
            outcomes["refused"] += 1
        else:
            assert geometry.triangles.min() >= 0
            assert geometry.triangles.max() < len(geometry.vertices)
            assert np.isfinite(geometry.vertices).all()
            outcomes["read"] += 1
    assert min(outcomes.values()) > 50
