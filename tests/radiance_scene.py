"""A grey scene in Radiance: illuminance of places by ``rtrace -I``, with the programs of the wheel ``pyradiance``.

Radiance has no Phong lobe: Ward's stands for it, of the same reflectance and about the same width. Its ``light`` does
not reflect, and shines from the front only.
"""

from __future__ import annotations

import importlib.metadata
import subprocess
from pathlib import Path

import numpy as np
from radianceprograms import environment, program

from lelight.scene import FloatArray, Material, Scene

#: How far places are off their surface, in m.
LIFT = 1e-4


def version() -> str:
    """The wheel's version."""
    return f"pyradiance {importlib.metadata.version('pyradiance')}"


def radiance_scene(scene: Scene, folder: Path) -> Path:
    """Write the scene and its octree into a folder; radiance there is luminance here."""
    lines = [_material(f"m{number}", material) for number, material in enumerate(scene.materials)]
    for number, (corners, material) in enumerate(zip(scene.corners, scene.triangle_materials, strict=True)):
        numbers = " ".join(f"{value:.9g}" for value in corners.ravel())
        lines.append(f"m{material} polygon t{number}\n0\n0\n9 {numbers}\n")
    (folder / "scene.rad").write_text("\n".join(lines), encoding="ascii")
    octree = folder / "scene.oct"
    with octree.open("wb") as out:
        subprocess.run([program("oconv"), "scene.rad"], cwd=folder, stdout=out, check=True)
    return octree


def _material(name: str, material: Material) -> str:
    if material.emits:
        return f"void light {name}\n0\n0\n3" + 3 * f" {float(material.luminance[0]):.9g}" + "\n"
    kd, ks = float(material.diffuse[0]), float(material.specular[0])
    roughness = (2.0 / (float(material.exponent) + 2.0)) ** 0.5 if ks > 0.0 else 0.0
    return (
        f"void plastic {name}\n0\n0\n5"
        + 3 * f" {kd / max(1.0 - ks, 1e-9):.9g}"
        + f" {ks:.9g} {roughness:.9g}\n"
    )


def illuminance_by_radiance(
    octree: Path, points: FloatArray, normals: FloatArray, options: str, *, threads: int = 2
) -> FloatArray:
    """Illuminance (k,) in lx at places (k, 3) by ``rtrace -I`` with options."""
    rows = np.concatenate([points + LIFT * normals, normals], axis=1)
    sent = "\n".join(" ".join(f"{value:.9g}" for value in row) for row in rows)
    done = subprocess.run(
        [program("rtrace"), "-I", "-h", "-n", str(threads), *options.split(), octree.name],
        cwd=octree.parent,
        input=sent,
        capture_output=True,
        text=True,
        check=True,
        env=environment(),
    )
    return np.array([float(line.split()[0]) for line in done.stdout.splitlines() if line.strip()])
