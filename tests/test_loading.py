"""From files to a scene: units, axes, materials, fixtures, refusals."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

from lelight.errors import InputError, LelightError, SceneError
from lelight.reading.loading import load
from lelight.scene import Material, Scene, triangle_areas

#: A 2 x 3 floor in the plane z = 0 and a 1 x 1 lamp at z = 4.
OBJ = """mtllib room.mtl
v 0 0 0
v 2 0 0
v 2 3 0
v 0 3 0
v 0 0 4
v 1 0 4
v 1 1 4
v 0 1 4
usemtl floor oak
f 1 2 3 4
usemtl lamp
f 8 7 6 5
"""
MTL = "newmtl floor oak\nKd 0.4 0.3 0.2\nKs 0.1\nNs 40\nnewmtl lamp\nKd 0.7\nKe 1000 900 800\n"


def write(folder: Path, *, toml: str | None = None, obj: str = OBJ, mtl: str | None = MTL) -> Path:
    (folder / "room.obj").write_text(obj, encoding="utf-8")
    if mtl is not None:
        (folder / "room.mtl").write_text(mtl, encoding="utf-8")
    if toml is not None:
        (folder / "room.toml").write_text(toml, encoding="utf-8")
    return folder / "room.obj"


def material(scene: Scene, name: str) -> Material:
    return next(one for one in scene.materials if one.name == name)


def refusal(path: Path, kind: type[LelightError]) -> str:
    with pytest.raises(kind) as caught:
        load(path)
    assert str(caught.value).isprintable()
    return str(caught.value)


def test_obj_and_mtl_as_written(tmp_path: Path) -> None:
    scene = load(write(tmp_path))
    floor, lamp = material(scene, "floor oak"), material(scene, "lamp")
    assert floor.diffuse.tolist() == [0.4, 0.3, 0.2]
    assert floor.specular.tolist() == [0.1, 0.1, 0.1]
    assert (floor.exponent, floor.origin, floor.emits) == (40, "room.mtl:1", False)
    assert lamp.luminance.tolist() == [1000, 900, 800]
    assert lamp.emission_sides == "front"
    assert (scene.name, scene.unit, scene.up, scene.warnings) == ("room", "m", "z", ())
    assert triangle_areas(scene.corners).sum() == pytest.approx(7, rel=1e-12)
    assert scene.path == tmp_path / "room.obj"


def test_hashes_are_those_of_the_files(tmp_path: Path) -> None:
    scene = load(write(tmp_path, toml="[calc]\nseed = 3\n"))
    expected = {
        name: hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()
        for name in ("room.obj", "room.mtl", "room.toml")
    }
    assert scene.files == expected
    assert scene.settings == {"seed": 3}


@pytest.mark.parametrize(
    ("unit", "metres"), [("m", 1), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)]
)
def test_units(tmp_path: Path, unit: str, metres: float) -> None:
    scene = load(write(tmp_path, toml=f'unit = "{unit}"'))
    assert np.ptp(scene.vertices, axis=0) == pytest.approx(metres * np.array([2, 3, 4]), rel=1e-12)


def test_y_up_is_turned_not_mirrored(tmp_path: Path) -> None:
    """A triangle that faces up, +y, in the file must face +z in the scene."""
    obj = "v 0 1 0\nv 0 1 1\nv 1 1 0\nusemtl lamp\nf 1 2 3\n"
    scene = load(write(tmp_path, obj=obj, mtl=None, toml='up = "y"\nmaterials.lamp.luminance = 5'))
    assert scene.corners[0].tolist() == [[0, 0, 1], [0, -1, 1], [1, 0, 1]]
    a, b, c = scene.corners[0]
    assert np.cross(b - a, c - a).tolist() == [0, 0, 1]


def test_every_later_pattern_overrides_only_its_keys(tmp_path: Path) -> None:
    toml = """[materials]
"*" = { reflectance = 0.2, specular = 0.3, exponent = 5 }
"floor*" = { reflectance = [0.6, 0.5, 0.4] }
"*oak" = { specular = 0.05 }
"Floor*" = { reflectance = 0.1 }
"""
    scene = load(write(tmp_path, toml=toml))
    floor = material(scene, "floor oak")
    assert floor.diffuse.tolist() == [0.6, 0.5, 0.4]
    assert floor.specular.tolist() == [0.05] * 3
    assert floor.exponent == 5
    assert floor.origin == 'room.mtl:1, room.toml "*", room.toml "floor*", room.toml "*oak"'
    assert scene.warnings == ('room.toml: materials."Floor*" matches no material',)


@pytest.mark.parametrize(("sides", "area"), [("front", 1), ("both", 2)])
def test_flux_becomes_the_luminance_of_its_area(tmp_path: Path, sides: str, area: float) -> None:
    """A Lambertian emitter of luminance L and area A gives pi L A; the lamp has 1 m² a side."""
    scene = load(write(tmp_path, toml=f'[materials]\nlamp = {{ flux = 3400, sides = "{sides}" }}'))
    assert material(scene, "lamp").luminance == pytest.approx(3400 / (np.pi * area), rel=1e-12)
    assert material(scene, "lamp").emission_sides == sides


def test_luminance_and_flux_override_each_other(tmp_path: Path) -> None:
    toml = '[materials]\n"l*" = {{ {} = 100 }}\n"lamp" = {{ {} = 50 }}'
    scene = load(write(tmp_path, toml=toml.format("flux", "luminance")))
    assert material(scene, "lamp").luminance.tolist() == [50, 50, 50]
    scene = load(write(tmp_path, toml=toml.format("luminance", "flux")))
    assert material(scene, "lamp").luminance == pytest.approx(50 / np.pi, rel=1e-12)


def test_undefined_material_is_grey_and_said(tmp_path: Path) -> None:
    scene = load(write(tmp_path, mtl="newmtl lamp\nKe 10\n"))
    floor = material(scene, "floor oak")
    assert (floor.diffuse.tolist(), floor.origin) == ([0.5] * 3, "default")
    assert scene.warnings == ('material "floor oak" is defined nowhere: reflectance 0.5 is assumed',)


def test_only_what_is_used_stays(tmp_path: Path) -> None:
    obj = OBJ + "v 1e11 0 0\nusemtl idle\nf 1 1 2\nf 1 2 2\n"
    scene = load(write(tmp_path, obj=obj))
    assert [one.name for one in scene.materials] == ["floor oak", "lamp"]
    assert scene.vertices.shape == (8, 3)
    assert scene.warnings == ("2 triangles without area are left out",)


def test_fixtures(tmp_path: Path) -> None:
    toml = """
[[luminaires]]
name = "L1"
position = [1, 2, 3]
intensity = [100, 50, 25]
dimming = 0.5
maintenance = 0.8
[[observers]]
name = "eye"
position = [1, 1, 1]
direction = [0, 3e-200, 4e-200]
[[planes]]
name = "desk"
origin = [0, 0, 0.75]
u = [2, 0, 0]
v = [0, 3, 0]
target = { ugr = 19 }
"""
    scene = load(write(tmp_path, toml='unit = "mm"\n' + toml))
    assert scene.luminaires[0].position.tolist() == [1, 2, 3]
    assert scene.luminaires[0].intensity == pytest.approx([40, 20, 10], rel=1e-15)
    assert scene.observers[0].direction == pytest.approx([0, 0.6, 0.8], rel=1e-15)
    assert scene.planes[0].normal.tolist() == [0, 0, 1]
    assert scene.planes[0].target == {"ugr": 19}


def test_scene_file_names_its_geometry(tmp_path: Path) -> None:
    (tmp_path / "models").mkdir()
    write(tmp_path / "models")
    scene_path = tmp_path / "evening.toml"
    scene_path.write_text('geometry = "models/room.obj"', encoding="utf-8")
    scene = load(str(scene_path))
    assert (scene.name, set(scene.files)) == (
        "evening",
        {"models/room.obj", "models/room.mtl", "evening.toml"},
    )


def test_scene_file_and_obj_give_the_same_scene(tmp_path: Path) -> None:
    path = write(tmp_path, toml='[materials]\n"*" = { reflectance = 0.3, specular = 0 }')
    first, second = load(path), load(path.with_suffix(".toml"))
    assert first.files == second.files
    np.testing.assert_array_equal(first.corners, second.corners)
    assert material(first, "lamp").diffuse.tolist() == material(second, "lamp").diffuse.tolist() == [0.3] * 3


@pytest.mark.parametrize(
    ("toml", "mtl", "says"),
    [
        (
            None,
            "newmtl lamp\nKd 1.4\nKe 1",
            'material "lamp" (room.mtl:1): found reflectance 1.4 and specular 0;',
        ),
        (None, "newmtl lamp\nKd 0.8\nKs 0.1 0.3 0.1", "reflectance 0.8 and specular (0.1, 0.3, 0.1);"),
        (
            "[materials]\nlamp = { specular = 0.4 }",
            MTL,
            'material "lamp" (room.mtl:5, room.toml "lamp"): found',
        ),
        (None, "newmtl lamp\nKe 1e16", "found luminance 1e+16 cd/m²; allowed is at most 1e+15"),
        (None, "newmtl lamp\nNs 1e7", "found exponent 1e+07; allowed is at most 1e+06"),
        (
            None,
            "newmtl lamp\nKd 0.5",
            "no light: no material emits and no luminaire has an intensity; give a",
        ),
        ("[materials]\nlamp = { luminance = 0 }", MTL, "no light:"),
    ],
)
def test_scenes_that_cannot_be_lit(tmp_path: Path, toml: str | None, mtl: str, says: str) -> None:
    assert says in refusal(write(tmp_path, toml=toml, mtl=mtl), SceneError)


def test_sum_of_reflectances_may_pass_one_by_rounding_only(tmp_path: Path) -> None:
    assert load(write(tmp_path, mtl="newmtl lamp\nKd 0.7\nKs 0.3000000001\nKe 1\n")).materials
    path = write(tmp_path, mtl="newmtl lamp\nKd 0.7\nKs 0.30000001\nKe 1\n")
    assert "allowed is a sum of at most 1" in refusal(path, SceneError)


@pytest.mark.parametrize(
    ("obj", "toml", "says"),
    [
        ("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", None, "no face has an area"),
        ("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", None, "no face has an area"),
        (
            "v 0 0 0\nv 1e10 0 0\nv 0 1 0\nf 1 2 3\n",
            None,
            "found a vertex 1e+10 m from the origin; allowed are 1e+09 m",
        ),
    ],
)
def test_extents_that_are_none(tmp_path: Path, obj: str, toml: str | None, says: str) -> None:
    assert says in refusal(write(tmp_path, obj=obj, toml=toml), SceneError)


def test_missing_photometry_files_are_named_by_key(tmp_path: Path) -> None:
    toml = '[[luminaires]]\nname = "L"\nposition = [0, 0, 1]\nphotometry = "a.ldt"\n'
    text = refusal(write(tmp_path, toml=toml), InputError)
    assert text.startswith(
        f'{tmp_path / "room.toml"}: luminaires[0].photometry: found "a.ldt", which is not there'
    )


@pytest.mark.parametrize(
    "name", ["../{stem}", "{outside}/{stem}", "sub/../../{stem}", "link-{stem}", "C:\\\\{stem}"]
)
@pytest.mark.parametrize(
    ("toml", "stem"),
    [
        ('geometry = "{name}"', "x.obj"),
        ('[[luminaires]]\nname = "L"\nposition = [0, 0, 1]\nphotometry = "{name}"', "x.ldt"),
        ('[materials]\n"*" = {{ reflectance = "{name}" }}', "x.csv"),
        ('[materials]\n"*" = {{ luminance = 1, spectrum = "{name}" }}', "x.spdx"),
    ],
)
def test_names_in_scene_files_stay_in_the_folder(tmp_path: Path, toml: str, stem: str, name: str) -> None:
    inside = tmp_path / "inside"
    (inside / "sub").mkdir(parents=True)
    (tmp_path / stem).write_text("secret", encoding="utf-8")
    (inside / f"link-{stem}").symlink_to(tmp_path / stem)
    named = toml.format(name=name.format(stem=stem, outside=tmp_path))
    text = refusal(write(inside, toml=named).with_suffix(".toml"), InputError)
    assert "leads out of the folder of the scene" in text and "secret" not in text


def test_paths_that_are_no_scene(tmp_path: Path) -> None:
    assert "no such file" in refusal(tmp_path / "absent.obj", InputError)
    assert "no such file" in refusal(tmp_path / "absent.toml", InputError)
    assert 'found the ending ".ply"; allowed are .obj and .toml' in refusal(tmp_path / "a.ply", InputError)
    (tmp_path / "folder.obj").mkdir()
    assert "is a folder" in refusal(tmp_path / "folder.obj", InputError)
    assert "cannot be read" in refusal(tmp_path / ("n" * 300 + ".obj"), InputError)


@pytest.mark.parametrize(
    ("given", "geometry", "says"),
    [
        ("room.toml", "absent.obj", "which is not there"),
        ("room.toml", "room.stl", "allowed is an .obj file"),
        ("room.obj", "other.obj", "was asked for; give one of the two"),
        ("room.toml", "a\\u0000.obj", "which is not there"),
    ],
)
def test_geometry_that_does_not_fit(tmp_path: Path, given: str, geometry: str, says: str) -> None:
    write(tmp_path, toml=f'geometry = "{geometry}"')
    text = refusal(tmp_path / given, InputError)
    assert text.startswith(f"{tmp_path / 'room.toml'}: geometry: found")
    assert says in text
