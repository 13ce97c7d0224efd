"""A small result folder to report on, and what reading a broken one says.

The folder is honest: a box of 6 x 4 x 3 m with two luminous panels in its ceiling, illuminance from the
panels as small Lambertian sources plus a constant indirect part, pictures by intersecting each pixel's ray
with the box.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import numpy as np
import pytest
from photofiles import ldt, wallwasher

from lelight.camera import Fisheye
from lelight.errors import OutputError
from lelight.photometry.reading import read_photometry
from lelight.pipelines.datasheets import data_sheet
from lelight.reports.folder import open_folder
from lelight.reports.nodemesh import read_lit_mesh
from lelight.reports.pictures import read_picture
from lelight.reports.viewpoints import read_grids
from lelight.writing.files import safe_names
from lelight.writing.pictures import write_exr
from lelight.writing.polydata import PolyData, write_polydata

ROOM = np.array([6.0, 4.0, 3.0])
PANELS = np.array([[1.5, 2.0, 3.0], [4.5, 2.0, 3.0]])
PANEL_SIDE, PANEL_LUMINANCE = 0.6, 3000.0
INDIRECT, REFLECTANCE = 60.0, 0.5


def illuminance(points, normals):
    """Lux from the panels as small sources, E = L A cos cos / r², plus the indirect part."""
    rays = PANELS[:, None] - points
    distance = np.maximum(np.linalg.norm(rays, axis=2), 0.1)
    arriving = np.clip(np.einsum("pnk,nk->pn", rays, normals) / distance, 0, None)
    leaving = np.clip(rays[..., 2] / distance, 0, None)
    return INDIRECT + (PANEL_LUMINANCE * PANEL_SIDE**2 * arriving * leaving / distance**2).sum(axis=0)


def box_mesh(step=0.5):
    """Nodes, triangles and inward normals of the six faces, a grid each."""
    points, triangles, normals = [], [], []
    for axis in range(3):
        u, v = [other for other in range(3) if other != axis]
        for at, inward in ((0.0, 1.0), (ROOM[axis], -1.0)):
            a, b = (np.linspace(0, ROOM[k], round(ROOM[k] / step) + 1) for k in (u, v))
            face = np.zeros((len(b), len(a), 3))
            face[..., u], face[..., v], face[..., axis] = a[None, :], b[:, None], at
            index = np.arange(face[..., 0].size).reshape(len(b), len(a)) + sum(map(len, points))
            corners = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
            triangles += [
                np.stack([corners[i].ravel() for i in three], axis=1) for three in ((0, 1, 2), (0, 2, 3))
            ]
            points.append(face.reshape(-1, 3))
            normals.append(np.tile(inward * np.eye(3)[axis], (face[..., 0].size, 1)))
    return np.concatenate(points), np.concatenate(triangles), np.concatenate(normals)


def luminance_picture(position, direction, pixels):
    """Fisheye (n, n) in cd/m² of the box seen from inside, 0 outside the disc."""
    camera = Fisheye(np.asarray(position, float), np.asarray(direction, float))
    origins, rays = camera.rays(pixels, pixels)
    with np.errstate(divide="ignore"):
        far = np.where(rays > 0, ROOM - origins, -origins) / rays
    far = np.where(np.isfinite(far) & (far >= 0), far, np.inf)
    axis = far.argmin(axis=1)
    hits = origins + far.min(axis=1, keepdims=True) * rays
    normals = -np.sign(np.take_along_axis(rays, axis[:, None], 1)) * np.eye(3)[axis]
    luminance = illuminance(hits, normals) * REFLECTANCE / np.pi
    ceiling = (axis == 2) & (rays[:, 2] > 0)
    for panel in PANELS:
        within = (np.abs(hits[:, :2] - panel[:2]) < PANEL_SIDE / 2).all(axis=1)
        luminance[ceiling & within] = PANEL_LUMINANCE
    picture = np.zeros((pixels, pixels))
    picture[camera.mask(pixels, pixels)] = luminance
    return picture, camera.view(pixels, pixels)


def figure(value, unit, std_error=None, **more):
    return {"value": value, "unit": unit, "std_error": std_error, "method": "grid"} | more


def write_plane(out, stem, rows, columns):
    along_x, along_y = (
        (np.arange(columns) + 0.5) / columns * 5 + 0.5,
        (np.arange(rows) + 0.5) / rows * 3 + 0.5,
    )
    x, y = np.meshgrid(along_x, along_y)
    points = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.75)], axis=1)
    lux = illuminance(points, np.tile([0.0, 0.0, 1.0], (len(points), 1)))
    table = np.column_stack([points, lux, 0.01 * lux, 0.4 * lux])
    header = "x_m,y_m,z_m,illuminance_lx,illuminance_std_error_lx,cylindrical_illuminance_lx"
    path = out / "planes" / f"{stem}.csv"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.9g", encoding="utf-8")
    return lux


def plane_entry(out, stem, rows=6, columns=10):
    lux = write_plane(out, stem, rows, columns)
    mean, least, most = float(lux.mean()), float(lux.min()), float(lux.max())
    clause = "EN 12464-1, maintained illuminance"
    return {
        "file": stem,
        "grid": {"rows": rows, "columns": columns},
        "mean_illuminance": figure(mean, "lx", 1.7, verdict="fail", target=500.0, clause=clause),
        "minimum_illuminance": figure(least, "lx", 2.4),
        "maximum_illuminance": figure(most, "lx", 3.1),
        "uniformity": figure(least / mean, "1", 0.012, verdict="undecided", target=0.6),
        "diversity": figure(least / most, "1", 0.009),
        "mean_cylindrical_illuminance": figure(0.4 * mean, "lx", 0.9),
        "modelling": figure(0.4, "1", 0.0021),
        "some_new_figure": figure(12.3456, "lx", 0.1),
    }


def panel_source(number, position, direction):
    ray = PANELS[number] - position
    distance = np.linalg.norm(ray)
    forward, right = np.asarray(direction, float), np.cross(direction, [0, 0, 1])
    along, sideways, up = ray @ forward, ray @ right, ray[2]
    ahead = along > 0
    counts = ahead and abs(sideways / along) <= 3 and up / along <= 1.9
    outside = "outside the field of the position table" if ahead else "behind the observer"
    return {
        "name": f"panel {number + 1}",
        "luminance_cd_m2": PANEL_LUMINANCE,
        "solid_angle_sr": PANEL_SIDE**2 * ray[2] / distance**3,
        "direction": (ray / distance).tolist(),
        "t_over_r": abs(sideways / along) if ahead else None,
        "h_over_r": up / along if ahead else None,
        "position_index": 3.3 + number if counts else None,
        "visible_fraction": 1.0,
        "share": 0.5,
        "excluded": "" if counts else outside,
    }


def observer_entry(out, stem, number, pixels):
    position, direction = (
        ([0.4, 1.2, 1.2], [1, 0, 0]) if number % 2 == 0 else ([3.0, 3.4, 1.2], [0.6, -0.8, 0])
    )
    picture, view = luminance_picture(position, direction, pixels)
    write_exr(out / "observers" / f"{stem}.exr", picture, view=view)
    ugr = 17.83 if number else 9.4
    return {
        "file": stem,
        "position": position,
        "direction": direction,
        "ugr": figure(ugr, "1", 0.06, verdict="pass", target=19.0, clause="CIE 117:1995"),
        "background_luminance": figure(INDIRECT / np.pi, "cd/m²", 0.21),
        "direct_vertical_illuminance": figure(87.654, "lx", 0.0),
        "indirect_vertical_illuminance": figure(INDIRECT, "lx", 0.66),
        "ugr_picture": figure(18.21, "1", None),
        "dgp": figure(
            0.1934, "1", None, note="outside the range DGP was made for: 380 lx and more, 0.2 to 0.8"
        ),
        "sources": [panel_source(k, np.array(position), direction) for k in range(2)],
    }


def view_entry(number):
    """What is no single figure: a rose that falls off to the back, and statistics of the view."""
    turns = 15.0 * np.arange(24)
    rose = [
        {"turn": turn, "ugr": 12 + 5 * np.cos(np.radians(turn)) if abs(turn - 180) > 60 else None, "std_error": 0.1,
         "background_luminance": 20.0}
        for turn in turns.tolist()
    ]  # fmt: skip
    zone = {"mean": 30.25, "median": 20.5, "p5": 5.125, "p95": 60.5, "max": 3000.0, "solid_angle": 0.5}
    return {"rose": rose, "luminance": dict.fromkeys(("task", "surround", "background", "view"), zone)}


def lamp_entry(name, position):
    return {
        "name": name,
        "position": position,
        "intensity_cd": [1200.0] * 3,
        "photometry": "lamps/panel.ldt",
        "sha256": "5a" * 32,
        "flux_lm": 2400.0,
        "power_w": 25.0,
        "aim": [0, 0, -1],
        "c0": [0, 1, 0],
        "opening": "rectangle",
        "opening_m": [0.3, 0.6, 0.0],
    }


def sheet_entry():
    """Data sheet of a file that the tests write themselves."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "panel.ldt").write_text(ldt(wallwasher, symmetry=2))
        sheet = data_sheet(read_photometry(Path(folder) / "panel.ldt"))
    return sheet | {"path": "lamps/panel.ldt", "used_by": ["lamp 1", "lamp 2"]}


def run_entry():
    return {
        "lelight": "0.1.0",
        "scene": "office",
        "date": "2026-03-04T05:06:07+00:00",
        "plan": [
            {"decision": "channels", "value": 1, "reason": "all materials are grey"},
            {
                "decision": "sh_degree",
                "value": {"wall": 0, "floor": 9},
                "reason": "exponent 32 needs degree 9",
            },
            {"decision": "two_sided", "value": True, "reason": "no side of a wall but the inner one is lit"},
        ],
        "settings": {"target": 0.02, "edge": 0.25, "method": "sh", "time": None},
        "seed": 0,
        "seconds": {
            "read": 0.1,
            "remesh": 0.6,
            "pilot": 0.2,
            "estimate": 12.34,
            "fit": 0.3,
            "write": 0.9,
            "total": 14.44,
        },
        "rays": 123456789,
        "chains": 65536,
        "replicates": 8,
        "doublings": 3,
        "nodes": 4321,
        "error": {"rms": 0.0187, "p95": 0.034, "p99": 0.052, "target": 0.02, "met": True},
        "convergence": [
            {"replicates": 8, "doublings": k, "seconds": 0.8 * 2**k, "rms": 0.0735 * 2 ** (-k / 2)}
            for k in range(5)
        ],
        "bias": ["Exponents above 256 are looked up along the mirrored view ray."],
        "warnings": ["office.mtl:4: map_Kd has no photometric meaning here and is ignored"],
        "versions": {"lelight": "0.1.0", "numpy": "2.4.6", "embreex": "4.4.0"},
        "materials": [
            {
                "name": "wall",
                "area_m2": 60.0,
                "reflectance": [0.5, 0.5, 0.5],
                "specular": [0, 0, 0],
                "exponent": 1,
                "luminance_cd_m2": [0, 0, 0],
                "origin": "office.mtl:12",
            },
            {
                "name": "floor wood",
                "area_m2": 24.0,
                "reflectance": [0.3, 0.22, 0.15],
                "specular": [0.05, 0.05, 0.05],
                "exponent": 32,
                "luminance_cd_m2": [0, 0, 0],
                "origin": 'office.toml "floor*"',
            },
            {
                "name": "panel",
                "area_m2": 0.72,
                "reflectance": [0, 0, 0],
                "specular": [0, 0, 0],
                "exponent": 1,
                "luminance_cd_m2": [3000, 3000, 3000],
                "origin": 'office.toml "panel"',
            },
        ],
        "luminaires": [
            {"name": "bare lamp", "position": [2.0, 1.5, 2.8], "intensity": [100, 100, 100]},
            lamp_entry("lamp 1", [1.5, 2.0, 3.0]),
            lamp_entry("lamp 2", [4.5, 2.0, 3.0]),
        ],
        "data_sheets": [sheet_entry()],
        "files": {"office.obj": "ab" * 32, "office.toml": "0f" * 32},
    }


def face_ends(triangles):
    """Where the triangles of each of the six faces but the last end: grids of 8 x 6, 12 x 6 and 12 x 8 squares."""
    return np.cumsum([2 * 8 * 6, 2 * 8 * 6, 2 * 12 * 6, 2 * 12 * 6, 2 * 12 * 8])


def glossy_arrays(count, floor):
    """Harmonics of degree 1: luminance a + b cos of the angle to a direction 45° off the normal, on the floor."""
    harmonics = np.zeros((count, 4), dtype=np.float32)
    harmonics[:, 0] = 10.0 * np.sqrt(4 * np.pi)
    slope = 4.0 * np.sqrt(4 * np.pi / 3) / np.sqrt(2)
    harmonics[floor, 2] = harmonics[floor, 3] = slope
    degrees = np.zeros(count, dtype=np.int32)
    degrees[floor] = 1
    return {"radiance_sh": harmonics, "sh_degree": degrees}


def make_result_folder(
    out, *, planes=("work plane",), observers=("desk 1", "desk 2"), pixels=64, grid=(6, 10)
):
    """Write a result folder with planes and observers of these names."""
    for part in (out, out / "planes", out / "observers"):
        part.mkdir(exist_ok=True)
    points, triangles, normals = box_mesh()
    arrays = {
        "illuminance_lx": illuminance(points, normals),
        "normal": normals,
        "hidden": np.zeros(len(points), "u1"),
    }
    faces = np.repeat([1, 1, 1, 1, 0, 2], [len(part) for part in np.split(triangles, face_ends(triangles))])
    floor = np.flatnonzero((points[:, 2] == 0.0) & (normals[:, 2] == 1.0))
    write_polydata(
        out / "field.vtp",
        PolyData(
            points=points,
            polygons=triangles,
            point_arrays=arrays | glossy_arrays(len(points), floor),
            cell_arrays={"material_id": faces.astype(np.int32)},
            texts={"material_names": ("floor wood", "wall", "panel")},
        ),
    )
    plane_stems, observer_stems = safe_names(planes), safe_names(observers)
    metrics = {
        "planes": {n: plane_entry(out, s, *grid) for n, s in zip(planes, plane_stems, strict=True)},
        "observers": {
            n: observer_entry(out, s, k, pixels)
            for k, (n, s) in enumerate(zip(observers, observer_stems, strict=True))
        },
        "room": {"mean_room_surface_exitance": figure(44.4, "lm/m²", 0.5)},
        "views": {name: view_entry(number) for number, name in enumerate(observers)},
    }
    (out / "metrics.json").write_text(json.dumps(metrics), encoding="utf-8")
    (out / "run.json").write_text(json.dumps(run_entry()), encoding="utf-8")
    return out


@pytest.fixture
def out(tmp_path):
    return make_result_folder(tmp_path / "office ü.lelight")


def test_subjects_come_in_the_order_of_the_file(out):
    folder = open_folder(out)
    assert [plane.name for plane in folder.planes] == ["work plane"]
    assert [observer.name for observer in folder.observers] == ["desk 1", "desk 2"]
    assert folder.run["seed"] == 0


def test_figures_come_in_printing_order_and_unknown_ones_last(out):
    keys = [reading.key for reading in open_folder(out).planes[0].readings]
    assert keys[0] == "mean_illuminance"
    assert keys[-1] == "some_new_figure"
    assert len(keys) == 8


def test_a_stem_cannot_lead_out_of_the_folder(out):
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    metrics["observers"]["desk 1"]["file"] = "../../secret"
    (out / "metrics.json").write_text(json.dumps(metrics), encoding="utf-8")
    assert open_folder(out).observers[0].stem == "secret"


def test_the_grid_is_the_rectangle_that_was_measured(out):
    # Cells of 0.5 m from (0.5, 0.5) to (5.5, 3.5) m, 0.75 m above the floor.
    (grid,) = read_grids(open_folder(out))
    assert grid.illuminance.shape == (6, 10)
    np.testing.assert_allclose(grid.spacing, (0.5, 0.5), rtol=1e-8)
    corners = [[0.5, 0.5, 0.75], [5.5, 0.5, 0.75], [5.5, 3.5, 0.75], [0.5, 3.5, 0.75]]
    np.testing.assert_allclose(grid.outline, corners, rtol=1e-8)


def test_the_plan_shows_what_faces_up_only(out):
    mesh = read_lit_mesh(out / "field.vtp")
    assert np.all(mesh.points[mesh.upward, 2] == 0.0)
    # The floor is 12 x 8 squares of two triangles.
    assert len(mesh.upward) == 192
    # Each face is bordered by its own edges: 2 (12 + 8) + 2 (12 + 6) + 2 (8 + 6), and every face twice.
    assert len(mesh.border) == 2 * (40 + 36 + 28)


def test_picture_statistics_weigh_by_solid_angle(tmp_path):
    # Upper half of the view 100 cd/m², lower half 10 cd/m²: each is half of the solid angle.
    luminance = np.where(np.arange(64)[:, None] < 32, 100.0, 10.0) * np.ones((64, 64))
    write_exr(tmp_path / "half.exr", luminance, view="")
    picture = read_picture(tmp_path / "half.exr")
    assert picture.mean == pytest.approx(55.0, rel=1e-12)
    assert picture.quantile(0.49) == 10.0
    assert picture.quantile(0.51) == 100.0
    assert picture.luminance[picture.extremum(largest=True)] == 100.0
    assert picture.luminance[picture.extremum(largest=False)] == 10.0


@pytest.mark.parametrize(
    ("file", "content", "told"),
    [
        ("metrics.json", "{", "not JSON"),
        ("metrics.json", "[]", "list instead of an object"),
        ("metrics.json", '{"planes": []}', "'planes' is not an object"),
        ("metrics.json", '{"planes": {"p": 1}}', "'planes.p' is not an object"),
        ("run.json", "\x00", "not JSON"),
    ],
)
def test_a_broken_json_file_is_told_in_one_line(out, file, content, told):
    (out / file).write_text(content, encoding="utf-8")
    with pytest.raises(OutputError, match=r"^[^\n]+$") as error:
        open_folder(out)
    assert told in str(error.value)
    assert file in str(error.value)
    assert "lelight calc" in str(error.value)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "no column x_m"),
        ("x_m,y_m,z_m,illuminance_lx\n1,2,3,4\n", "1 points, metrics.json announces 6 x 10"),
        ("x_m,y_m,z_m,illuminance_lx\n1,2,3,bright\n", "not a table of numbers"),
    ],
)
def test_a_broken_plane_is_told_in_one_line(out, content, told):
    Path(out / "planes" / "work plane.csv").write_text(content, encoding="utf-8")
    with pytest.raises(OutputError, match=r"^[^\n]+$") as error:
        read_grids(open_folder(out))
    assert told in str(error.value)


def test_a_picture_that_is_not_square_is_refused(tmp_path):
    write_exr(tmp_path / "wide.exr", np.ones((4, 8)), view="")
    with pytest.raises(OutputError, match="a fisheye is square"):
        read_picture(tmp_path / "wide.exr")
