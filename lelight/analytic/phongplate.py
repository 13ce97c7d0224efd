"""A glossy plate under one lamp: what it sends to points of space, and its radiance in several directions.

The plate z = 0 has the modified Phong lobe ks (n + 2)/(2 pi) cosⁿ alpha, alpha from the mirror direction. Under a
point lamp the light at a point is an integral over the plate; under a luminous square the radiance of a point of
the plate is an integral over the square. Both are taken by Gauss-Legendre's rule.
"""

from __future__ import annotations

import math

import numpy as np

from lelight.analytic.case import Case, Readings, at_probes
from lelight.analytic.solids import (
    Solid,
    gauss_rectangle,
    glossy,
    lamp,
    matt,
    parallelogram,
    probe,
    scene,
)
from lelight.calculation import Calculation
from lelight.channels import luminance_weighted
from lelight.scene import FloatArray

DIFFUSE, SPECULAR = 0.2, 0.6
#: Edge of the plate in m; it lies around the origin.
SIDE = 3.0
POSITION, INTENSITY = np.array([-0.7, 0.1, 1.2]), 1000.0
#: Points over the plate that face it, not higher than the lamp.
RECEIVERS = {
    "in the lamp's image": (0.7, 0.0, 1.2),
    "beside the image": (0.7, 0.5, 1.2),
    "low over the plate": (0.3, -0.2, 0.25),
    "above the lamp's side": (-0.5, 0.4, 0.9),
}
#: The luminous square: corner, edges (front down) and luminance in cd/m².
PANEL = ((-0.9, -0.2, 1.2), (0.0, 0.4, 0.0), (0.4, 0.0, 0.0))
LUMINANCE = 5000.0
#: Directions in which the plate is looked at from its middle node: degrees from the normal, azimuth.
DIRECTIONS = ((0.0, 0.0), (22.0, 0.0), (30.0, 0.0), (30.0, 15.0), (45.0, 0.0), (60.0, 180.0))
#: Independent draws of a radiance, more for lobes sharper than exponent 1000, in groups that give its error.
DRAWS, DRAWS_OF_SHARP_LOBES, GROUPS = 2048, 8192, 16


def lobe(
    incoming: FloatArray, outgoing: FloatArray, *, exponent: float, diffuse: float = DIFFUSE
) -> FloatArray:
    """Reflectance function (...,) in 1/sr of the plate, for unit directions (..., 3) away from it."""
    mirrored = incoming * np.array([-1.0, -1.0, 1.0])
    cosine = np.maximum(np.sum(mirrored * outgoing, axis=-1), 0.0)
    return np.asarray(diffuse / math.pi + SPECULAR * (exponent + 2.0) / (2.0 * math.pi) * cosine**exponent)


def plate(exponent: float) -> Solid:
    """Make the plate, facing up."""
    material = glossy("plate", diffuse=DIFFUSE, specular=SPECULAR, exponent=exponent)
    return parallelogram((-SIDE / 2, -SIDE / 2, 0), (SIDE, 0, 0), (0, SIDE, 0), material)


def reflected_illuminance(points: FloatArray, *, exponent: float, count: int = 250) -> FloatArray:
    """Exact illuminance (k,) in lx that points (k, 3), facing down, get from the plate under the point lamp."""
    corner, edge = (-SIDE / 2, -SIDE / 2, 0.0), SIDE
    at, weights = gauss_rectangle(count, corner, (edge, 0, 0), (0, edge, 0))
    to_lamp, distance = _unit(POSITION - at)
    arriving = INTENSITY * to_lamp[:, 2] / distance**2
    found = []
    for point in points:
        out, far = _unit(point - at)
        sent = arriving * lobe(to_lamp, out, exponent=exponent)
        found.append(SIDE**2 * float(weights @ (sent * out[:, 2] ** 2 / far**2)))
    return np.array(found)


def panel_radiance(
    point: FloatArray, directions: FloatArray, *, exponent: float, count: int = 200
) -> FloatArray:
    """Exact radiance (k,) in cd/m² that a plate point (3,) sends to directions (k, 3) under the panel."""
    at, weights = gauss_rectangle(count, *PANEL)
    area = float(np.linalg.norm(np.cross(PANEL[1], PANEL[2])))
    to_panel, distance = _unit(at - point)
    arriving = LUMINANCE * area * weights * to_panel[:, 2] ** 2 / distance**2
    return np.array([float(arriving @ lobe(to_panel, out, exponent=exponent)) for out in directions])


def _unit(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    length = np.linalg.norm(vectors, axis=-1)
    return vectors / length[..., None], length


def illuminance_case(exponent: float, *, target: float, looseness: float = 1.0) -> Case:
    """Points over the plate, under the point lamp; ``looseness`` multiplies 1 % and its standard error."""
    points = np.array(list(RECEIVERS.values()))
    made = scene(
        f"glossy plate, exponent {exponent:g}",
        plate(exponent),
        # A black plate round the points of the image: its nodes want the same light as they do.
        parallelogram((0.4, -0.3, 1.2), (0, 1, 0), (0.6, 0, 0), matt("screen", 0.0)),
        luminaires=[lamp(POSITION, INTENSITY)],
        planes=[probe(label, point, (0, 0, -1)) for label, point in RECEIVERS.items()],
    )
    return Case(
        name=f"plate-{exponent:g}-illuminance",
        group="Phong plate",
        title=f"exponent {exponent:g}: illuminance from the plate under a point lamp",
        basis="quadrature over the plate",
        scene=made,
        edge=2.0,
        target=target,
        tolerance=0.01 * looseness,
        precision=0.003 * looseness,
        read=at_probes(list(RECEIVERS), reflected_illuminance(points, exponent=exponent)),
    )


def radiance_case(exponent: float) -> Case:
    """Radiance of the plate's middle under the luminous square."""
    panel = parallelogram(*PANEL, matt("panel", 0.0, luminance=LUMINANCE))
    return Case(
        name=f"plate-{exponent:g}-radiance",
        group="Phong plate",
        title=f"exponent {exponent:g}: radiance of the plate under a luminous square",
        basis="quadrature over the square",
        scene=scene(f"glossy plate, exponent {exponent:g}", plate(exponent), panel),
        edge=0.75,
        # The plate's own light is direct and exact; what it sends to the panel's nodes is of no interest.
        target=0.5,
        tolerance=0.01,
        precision=0.003,
        read=lambda run: _read_radiance(run, exponent),
        quantity="luminance",
        unit="cd/m²",
    )


def _read_radiance(run: Calculation, exponent: float) -> Readings:
    """Look at the node nearest to the middle, again and again: each look draws numbers of its own."""
    mesh = run.field.mesh
    node = int(np.argmin(np.linalg.norm(mesh.positions, axis=1) + 10.0 * (mesh.normals[:, 2] < 0.5)))
    point, directions = mesh.positions[node], _directions()
    looks = np.repeat(directions, DRAWS if exponent <= 1000.0 else DRAWS_OF_SHARP_LOBES, axis=0)
    seen = luminance_weighted(run.field.radiance(np.broadcast_to(point, looks.shape), looks))
    by_group = seen.reshape(len(directions), GROUPS, -1).mean(axis=2)
    # The diffuse part is known as well as the node's illuminance; both errors are independent.
    diffuse_error = DIFFUSE / math.pi * float(run.field.std_error[node])
    std_error = np.hypot(by_group.std(axis=1, ddof=1) / math.sqrt(GROUPS), diffuse_error)
    exact = panel_radiance(point, directions, exponent=exponent)
    return Readings(
        labels=tuple(f"{theta:g}° from the normal, azimuth {phi:g}°" for theta, phi in DIRECTIONS),
        reference=exact,
        allowance=np.zeros(len(exact)),
        found=by_group.mean(axis=1),
        std_error=std_error,
        freedom=min(GROUPS, run.replicates.count) - 1.0,
        tested=len(exact),
        slack=np.ones(len(exact)),
    )


def _directions() -> FloatArray:
    theta, phi = np.radians(np.array(DIRECTIONS)).T
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
