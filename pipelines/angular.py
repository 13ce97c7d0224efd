"""What ``run.json`` says of angular distributions: how they are kept, to what degree, and what that leaves out."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lelight.calculation import Calculation
from lelight.channels import luminance_weighted
from lelight.field import RadianceField
from lelight.harmonics.spectrum import energy_by_degree


def angular_record(run: Calculation) -> dict[str, Any]:
    """Tell the method and, for each material whose nodes keep directions, degree, truncation error and energies.

    Luminances are means over area, those by direction root mean squares; energies are shares of each degree in the
    integral of the square of the stored radiance.
    """
    settings = run.settings
    grid = {"directions": settings.directions, "extension": settings.extension}
    return {
        "method": settings.method,
        **(grid if settings.method == "grid" else {}),
        "materials": _rows(run.field),
    }


def _rows(field: RadianceField) -> list[dict[str, Any]]:
    mesh, values = field.mesh, field.values
    shown = (values.sh_degree > 0) & ~mesh.hidden
    rows = []
    for material in np.unique(mesh.materials[shown]):
        own = np.flatnonzero(shown & (mesh.materials == material))
        degree, areas = int(values.sh_degree[own[0]]), mesh.areas[own]
        radiance = luminance_weighted(values.radiance_sh[own, : (degree + 1) ** 2])
        energy = np.average(energy_by_degree(radiance[..., None])[..., 0], axis=0, weights=areas)
        truncation = np.average(values.truncation[own] ** 2, weights=areas)
        mean = np.average(radiance[:, 0], weights=areas) / math.sqrt(4.0 * math.pi)
        rows.append(
            {
                "name": field.scene.materials[material].name,
                "degree": degree,
                "mean_luminance_cd_m2": float(mean),
                "truncation_cd_m2": math.sqrt(truncation),
                "energy_share_by_degree": [float(e) for e in energy / max(energy.sum(), 1e-300)],
            }
        )
    return rows
