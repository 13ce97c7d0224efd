"""Scenes on disk with photometric luminaires, for the tests of their light."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lelight.estimate.direct import direct_light, with_clear_share
from lelight.reading.loading import load
from lelight.receivers import ILLUMINANCE, space_receivers, with_surface
from lelight.scene import FloatArray, Scene
from lelight.tracing.sobol import Stretch
from lelight.tracing.world import World, build_world

#: The room of CIE 171:2006, 4 x 4 x 3 m, fronts inwards.
ROOM_OBJ = """v 0 0 0
v 4 0 0
v 4 4 0
v 0 4 0
v 0 0 3
v 4 0 3
v 4 4 3
v 0 4 3
usemtl floor
f 1 2 3 4
usemtl ceiling
f 8 7 6 5
usemtl wall
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
"""
BLACK = '[materials]\n"*" = { reflectance = 0.0 }\n'


def scene_of(folder: Path, toml: str, *, obj: str = ROOM_OBJ, **files: str) -> Scene:
    """Write a room, its scene file and photometric files (``lamp_ldt`` becomes ``lamp.ldt``), and read it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "room.obj").write_text(obj)
    (folder / "room.toml").write_text(toml)
    for name, text in files.items():
        (folder / name.replace("_", ".")).write_text(text)
    return load(folder / "room.toml")


def luminaire(file: str, position: tuple[float, float, float], **keys: object) -> str:
    """A luminaire's table."""
    lines = ["[[luminaires]]", 'name = "L"', f'photometry = "{file}"', f"position = {list(position)}"]
    return "\n".join([*lines, *(f"{key} = {toml_of(found)}" for key, found in keys.items())]) + "\n"


def toml_of(found: object) -> str:
    return f'"{found}"' if isinstance(found, str) else str(found)


def direct(
    scene: Scene, points: FloatArray, normals: FloatArray, *, log2_samples: int = 6, seed: int = 1
) -> FloatArray:
    """Direct illuminance (k,) in lx at points (k, 3) on surfaces with normals (k, 3)."""
    return direct_in(build_world(scene, 1), points, normals, log2_samples=log2_samples, seed=seed)


def direct_in(
    world: World, points: FloatArray, normals: FloatArray, *, log2_samples: int = 6, seed: int = 1
) -> FloatArray:
    points = np.asarray(points, dtype=float)
    normals = np.broadcast_to(np.asarray(normals, dtype=float), points.shape)
    receivers = with_surface(space_receivers(points, np.ascontiguousarray(normals)))
    receivers = with_clear_share(world, receivers, seed=(seed, 0))
    moments, _ = direct_light(world, receivers, samples=Stretch.of(log2_samples), seed=(seed, 1))
    return np.asarray(moments[:, ILLUMINANCE, 0])
