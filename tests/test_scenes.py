"""The example scenes are what their comments say: size, closedness, winding, lamps, furniture that stands."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lelight.estimate.direct import direct_light, with_clear_share
from lelight.reading.loading import load
from lelight.receivers import ILLUMINANCE, space_receivers, with_surface
from lelight.scene import LUMINANCE_WEIGHTS, FloatArray, IntArray, Scene, triangle_areas, triangle_normals
from lelight.tracing.rays import RayCaster
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import build_world

SCENES = Path(__file__).parents[1] / "scenes"
NAMES = sorted(path.stem for path in SCENES.glob("*.toml") if path.stem != "hall")
CLOSED = ("office", "corridor", "sphere", "furnace")
FURNISHED = ("office", "corridor")
#: Two coordinates written alike are equal to this, in m, after reading: only float64 rounding remains.
ROUNDING = 1e-9


def welded(scene: Scene) -> IntArray:
    """Triangles (n_t, 3) into points that differ by more than the rounding of the files."""
    _, number = np.unique(np.round(scene.vertices, 7), axis=0, return_inverse=True)
    return number.reshape(-1)[scene.triangles]


def solids(scene: Scene) -> list[FloatArray]:
    """Corners (n, 3, 3) of each connected surface, the one around everything first."""
    triangles = welded(scene)
    size = triangles.max() + 1
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    _, label = connected_components(coo_array((np.ones(len(pairs)), pairs.T), shape=(size, size)))
    of_triangle = label[triangles[:, 0]]
    parts = [scene.corners[of_triangle == part] for part in np.unique(of_triangle)]
    return sorted(parts, key=lambda corners: -float(np.prod(np.ptp(corners.reshape(-1, 3), axis=0))))


def signed_volume(corners: FloatArray) -> float:
    """Volume in m³ by Gauss' theorem, negative where the surface is wound towards its inside."""
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)


def lone_edges(scene: Scene) -> IntArray:
    """Directed edges (k, 2) of the welded mesh without a partner that runs the other way exactly once."""
    triangles = welded(scene)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    both, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    assert np.max(count) <= 2
    assert len(np.unique(edges, axis=0)) == len(edges)
    return np.asarray(both[count == 1])


def lamp_corners(scene: Scene) -> FloatArray:
    """Corners (n, 3, 3) in m of the triangles that emit."""
    emits = np.array([material.emits for material in scene.materials])
    return np.asarray(scene.corners[emits[scene.triangle_materials]])


def lamp_area(scene: Scene) -> float:
    """Area in m² that emits."""
    return float(triangle_areas(lamp_corners(scene)).sum())


def lamp_normals(scene: Scene) -> FloatArray:
    """Directions (n, 3) into which the lamps' fronts look."""
    return triangle_normals(lamp_corners(scene))


def triangles_in_readme(name: str) -> int:
    """Count that the table of scenes/README.md gives for a scene file."""
    table = (SCENES / "README.md").read_text(encoding="utf-8")
    (row,) = [line for line in table.splitlines() if f"`{name}.toml`" in line and line.startswith("|")]
    return int(row.split("|")[2].replace(" ", ""))


def extents(parts: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Low and high corners, (n, 3) each, of the boxes around the parts."""
    points = [part.reshape(-1, 3) for part in parts]
    return np.array([p.min(axis=0) for p in points]), np.array([p.max(axis=0) for p in points])


@pytest.mark.parametrize("name", NAMES)
def test_scene_loads_without_complaint_and_has_light(name: str) -> None:
    scene = load(SCENES / f"{name}.toml")
    assert scene.warnings == ()
    assert len(scene.triangles) == triangles_in_readme(name)
    assert scene.observers
    assert scene.luminaires or lamp_area(scene) > 0


@pytest.mark.parametrize("name", sorted(path.stem for path in SCENES.glob("*.obj") if path.stem != "hall"))
def test_comment_states_what_the_file_holds(name: str) -> None:
    heading = (SCENES / f"{name}.obj").read_text(encoding="utf-8").partition("mtllib")[0]
    stated = re.search(r"# (\d+) triangles .* area (\S+) m2(?:; lamps (\S+) m2)?\.", heading)
    assert stated is not None
    scene = load(SCENES / f"{name}.obj")
    assert len(scene.triangles) == int(stated[1])
    assert triangle_areas(scene.corners).sum() == pytest.approx(float(stated[2]), abs=6e-4)
    assert lamp_area(scene) == pytest.approx(float(stated[3] or 0), rel=1e-5)


@pytest.mark.parametrize("name", CLOSED)
def test_every_edge_belongs_to_two_faces_that_agree(name: str) -> None:
    assert len(lone_edges(load(SCENES / f"{name}.obj"))) == 0


def test_a_missing_triangle_is_noticed() -> None:
    scene = load(SCENES / "office.obj")
    assert len(lone_edges(replace(scene, triangles=scene.triangles[1:]))) == 3


def test_cornell_box_is_open_at_the_front_only() -> None:
    scene = load(SCENES / "cornell.obj")
    edges = lone_edges(scene)
    welded_points = np.unique(np.round(scene.vertices, 7), axis=0)
    assert len(edges) == 4
    # Published z = 0 is y = 0 with z up.
    np.testing.assert_array_equal(welded_points[edges.ravel(), 1], 0.0)


def test_sobolev_discs_end_at_their_rims() -> None:
    scene = load(SCENES / "sobolev.obj")
    edges = lone_edges(scene)
    welded_points = np.unique(np.round(scene.vertices, 7), axis=0)
    assert len(edges) == 2 * 60
    radius = np.hypot(welded_points[edges.ravel(), 0], welded_points[edges.ravel(), 1])
    np.testing.assert_allclose(radius, 10.0, atol=1e-3)


# Office 6 x 4.5 x 2.8. Corridor (12 + 6) x 2 x 2.6 and five recesses of 0.9 x 0.15 x 2.1. Furnace: a prism
# cut by the plane z = 2.6 - 0.3 x holds its plan times the height over the plan's centroid; by the shoelace
# formula ABC, ACD, ADE, AEF have 3.25, 1.25, 2.5, 1.5 m² and their centroids x = 3.5, 5.5/3, 2.5/3, 1/3.
@pytest.mark.parametrize(
    ("name", "shell_area", "volume"),
    [
        ("office", 2 * (6 * 4.5 + 6 * 2.8 + 4.5 * 2.8), 6 * 4.5 * 2.8),
        ("corridor", 2 * 36 + (12 + 8 + 10 + 6 + 2 + 2) * 2.6 + 5 * 0.15 * 2 * (0.9 + 2.1), 95.0175),
        ("furnace", None, 3.25 * 1.55 + 1.25 * (2.6 - 0.55) + 2.5 * (2.6 - 0.25) + 1.5 * 2.5),
    ],
)
def test_shell_is_wound_inwards_and_has_its_size(name: str, shell_area: float | None, volume: float) -> None:
    shell, *inside = solids(load(SCENES / f"{name}.obj"))
    assert signed_volume(shell) == pytest.approx(-volume, rel=1e-12)
    assert min(signed_volume(part) for part in inside) > 0
    if shell_area is not None:
        assert triangle_areas(shell).sum() == pytest.approx(shell_area, rel=1e-12)


@pytest.mark.parametrize(("name", "count"), [("office", 60), ("corridor", 3)])
def test_furniture_is_made_of_boxes_that_do_not_overlap(name: str, count: int) -> None:
    parts = solids(load(SCENES / f"{name}.obj"))
    assert len(parts) == count
    low, high = extents(parts[1:])
    volumes = [signed_volume(part) for part in parts[1:]]
    np.testing.assert_allclose(volumes, np.prod(high - low, axis=1), rtol=1e-9)
    depth = (np.minimum(high[:, None], high) - np.maximum(low[:, None], low)).min(axis=2)
    np.fill_diagonal(depth, 0.0)
    assert depth.max() < ROUNDING


@pytest.mark.parametrize("name", FURNISHED)
def test_furniture_hangs_together_with_the_room(name: str) -> None:
    low, high = extents(solids(load(SCENES / f"{name}.obj")))
    overlap = np.sort(np.minimum(high[:, None], high) - np.maximum(low[:, None], low), axis=2)
    touching = (np.abs(overlap[..., 0]) < ROUNDING) & (overlap[..., 1] > ROUNDING)
    touching[0] |= (low[:, 2] == low[0, 2]) | (high[:, 2] == high[0, 2])
    pieces, _ = connected_components(touching, directed=False)
    assert pieces == 1


@pytest.mark.parametrize(
    ("name", "luminous_flux"),
    [("office", 13572.0), ("corridor", 7917.0), ("cornell", 428.8), ("sobolev_phong", 6785.84)],
)
def test_lamps_shine_downwards_with_the_stated_flux(name: str, luminous_flux: float) -> None:
    scene = load(SCENES / f"{name}.toml")
    np.testing.assert_allclose(lamp_normals(scene)[:, 2], -1.0, rtol=1e-12)
    (lamp,) = [material for material in scene.materials if material.emits]
    luminance = lamp.luminance @ LUMINANCE_WEIGHTS
    assert np.pi * luminance * lamp_area(scene) == pytest.approx(luminous_flux, abs=0.6)


def test_office_needs_one_channel_only() -> None:
    scene = load(SCENES / "office.toml")
    colours = np.array([[m.diffuse, m.specular, m.luminance] for m in scene.materials])
    np.testing.assert_array_equal(colours, colours[..., :1].repeat(3, axis=-1))


def test_no_lamp_is_seen_from_the_dark_leg_of_the_corridor() -> None:
    scene = load(SCENES / "corridor.toml")
    rng = np.random.default_rng(3)
    lamps = rng.uniform((10.5, 6.4, 2.539), (10.8, 7.6, 2.539), (4000, 3))
    lamps[::2, 0] += 0.7
    dark = rng.uniform((0.01, 0.01, 0.01), (9.3, 1.99, 2.59), (4000, 3))
    lit = rng.uniform((10.01, 2.3, 0.01), (11.99, 7.99, 2.0), (4000, 3))
    caster = RayCaster.of(scene)
    assert not caster.visible(dark, lamps).any()
    assert caster.visible(lit, lamps).all()


def test_sphere_stands_on_the_unit_sphere_and_faces_its_centre() -> None:
    scene = load(SCENES / "sphere.toml")
    np.testing.assert_allclose(np.linalg.norm(scene.vertices, axis=1), 1.0, atol=1.5e-6)
    inward = -np.einsum("tx,tx->t", triangle_normals(scene.corners), scene.corners.mean(axis=1))
    assert inward.min() > 0.99
    # rho Phi / (A (1 - rho)), as stated in the comments.
    mean_indirect = 400 * np.pi / triangle_areas(scene.corners).sum()
    assert mean_indirect == pytest.approx(100.4788, abs=1e-4)
    assert 9 * mean_indirect == pytest.approx(904.309, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "reflectances"),
    [("sphere", [0.5]), ("sphere90", [0.9]), ("sobolev", [0.5, 0.5]), ("sobolev_offset", [0.5, 0.8])],
)
def test_analytic_scenes_have_their_reflectances(name: str, reflectances: list[float]) -> None:
    materials = load(SCENES / f"{name}.toml").materials
    found = {material.name: material.diffuse.tolist() for material in materials}
    assert [found[key] for key in sorted(found)] == [[value] * 3 for value in reflectances]


def test_sobolev_planes_face_each_other_and_have_equal_sound_triangles() -> None:
    corners = load(SCENES / "sobolev.toml").corners
    normals = triangle_normals(corners)
    np.testing.assert_allclose(normals[:, 2], 1.0 - corners[:, 0, 2], rtol=1e-12)
    # A regular 60-gon of circumradius 10 has the area 60/2 10^2 sin(6 degrees).
    for height in (0.0, 2.0):
        disc = triangle_areas(corners[corners[:, 0, 2] == height])
        assert disc.sum() == pytest.approx(30 * 100 * np.sin(np.radians(6)), abs=0.02)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert np.max(sides.max(axis=1) / sides.min(axis=1)) < 1.5


def test_furnace_emits_and_reflects_alike_everywhere() -> None:
    (material,) = load(SCENES / "furnace.toml").materials
    np.testing.assert_array_equal(material.diffuse, 0.6)
    np.testing.assert_array_equal(material.luminance, 100.0)
    assert material.emission_sides == "front"


def test_cornell_camera_looks_through_the_open_front() -> None:
    scene = load(SCENES / "cornell.toml")
    (camera,) = scene.observers
    hits = RayCaster.of(scene).closest(camera.position[None], camera.direction[None])
    # Straight ahead, 273 mm above the floor, is the tall block. Its front runs in plan from (265, 296) to
    # (423, 247) mm, so at x = 278 mm it stands at z = 296 - 49 (278 - 265) / 158 = 291.97 mm.
    np.testing.assert_allclose(hits.points, [[0.278, -0.29197, 0.273]], atol=1e-5)


def write_hall(folder: Path) -> None:
    subprocess.run([sys.executable, SCENES / "make_hall.py", folder], check=True)


def test_hall_is_large_closed_and_the_same_every_time(tmp_path: Path) -> None:
    write_hall(tmp_path / "Bücher ei")
    write_hall(tmp_path / "again")
    files = sorted((tmp_path / "again").iterdir())
    assert [path.name for path in files] == ["hall.mtl", "hall.obj", "hall.toml"]
    for path in files:
        assert path.read_bytes() == (tmp_path / "Bücher ei" / path.name).read_bytes()
    scene = load(tmp_path / "Bücher ei" / "hall.toml")
    assert len(scene.triangles) == triangles_in_readme("hall") >= 200_000
    assert len(lone_edges(scene)) == 0
    # 60 panels of 1.2 x 0.6 m that shine downwards.
    assert lamp_area(scene) == pytest.approx(60 * 1.2 * 0.6, rel=1e-12)
    np.testing.assert_allclose(lamp_normals(scene)[:, 2], -1.0, rtol=1e-12)


def test_glossy_planes_have_the_stated_direct_light_under_the_downlight() -> None:
    world = build_world(load(SCENES / "sobolev_phong.toml"), 1)
    under = with_surface(space_receivers(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])))
    under = with_clear_share(world, under, seed=(0, 3))
    light, _ = direct_light(world, under, samples=Stretch.of(6), seed=(0, 1))
    assert light[0, ILLUMINANCE, 0] == pytest.approx(552.954, abs=1e-3)
