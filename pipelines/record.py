"""``run.json``: what was done, how long it took, how sure it is, and what replicates cannot see."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import numpy as np

import lelight
from lelight.calculation import Calculation
from lelight.checkpoint.identity import Identity, fingerprint
from lelight.course import Standing
from lelight.harmonics.zonal import beam_error
from lelight.luminaires import Luminaire
from lelight.photometry.zones import luminous_flux
from lelight.pipelines.angular import angular_record
from lelight.pipelines.datasheets import data_sheets
from lelight.plan import Decision
from lelight.preparation import chosen_variant
from lelight.reading.lint import material_rows
from lelight.scene import PointLuminaire
from lelight.versions import package_versions

#: Stages of the estimate that the clock tells apart; files name them together.
ESTIMATE_STAGES = ("base", "effort", "estimate")


def run_record(
    run: Calculation, *, scene_file: str, seconds: dict[str, float], warnings: list[str], identity: Identity
) -> dict[str, Any]:
    """Gather the record of a run, ready for JSON.

    Parameters
    ----------
    scene_file : what was computed, as path from the result folder
    seconds : of the stages outside the calculation: ``read`` and ``write``
    identity : what the result depends on
    """
    totals = run.replicates
    return {
        "lelight": lelight.__version__,
        "fingerprint": fingerprint(identity),
        "scene": run.scene.name,
        "scene_file": scene_file,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "plan": [_decision(d) for d in run.plan.decisions],
        "settings": run.settings.as_table()
        | {"edge": round(run.edge, 6), "target": run.settings.target_error},
        "effort": {
            name: found for name, found in vars(run.effort).items() if not isinstance(found, np.ndarray)
        },
        "seed": run.settings.seed,
        "seconds": _seconds(run, seconds),
        "rays": totals.rays,
        "chains": totals.count * 2 ** (run.effort.log2_chains + totals.doublings),
        "vertices": totals.vertices,
        "replicates": totals.count,
        "doublings": totals.doublings,
        "nodes": len(run.field.mesh),
        "hidden_nodes": int(np.count_nonzero(run.field.mesh.hidden)),
        "error": _error(run),
        "convergence": [_step(standing) for standing in run.convergence],
        "bias": bias_statements(run),
        "interpolation": vars(run.interpolation) if run.interpolation else None,
        "warnings": warnings,
        "unit": run.scene.unit,
        "up": run.scene.up,
        "materials": material_rows(run.scene),
        "angular": angular_record(run),
        "luminaires": [_luminaire(lamp) for lamp in run.scene.luminaires],
        "data_sheets": data_sheets(run.scene.luminaires),
        "files": run.scene.files,
        "versions": package_versions(),
    }


def _decision(decision: Decision) -> dict[str, str]:
    return {
        "decision": decision.name,
        "value": decision.value,
        "reason": decision.reason,
        "cost": str(decision.cost),
    }


def _seconds(run: Calculation, outside: dict[str, float]) -> dict[str, float]:
    inside = dict(run.seconds)
    estimate = sum(inside.pop(stage) for stage in ESTIMATE_STAGES)
    stages = {"read": outside["read"], **inside, "estimate": estimate}
    ordered = ("read", "remesh", "pilot", "estimate", "fit")
    return {stage: round(stages[stage], 3) for stage in ordered} | {
        "write": round(outside["write"], 3),
        "total": round(sum(stages.values()) + outside["write"], 3),
    }


def _error(run: Calculation) -> dict[str, Any]:
    return {
        "rms": _finite(run.error.rms),
        "p95": _finite(run.error.p95),
        "p99": _finite(run.error.p99),
        "target": run.settings.target_error,
        "met": run.target_met,
    }


def _finite(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None


def _step(standing: Standing) -> dict[str, Any]:
    return {
        "replicates": standing.replicates,
        "doublings": standing.doublings,
        "rays": standing.rays,
        "seconds": round(standing.seconds, 3),
        **(vars(standing.error) if standing.error else {"rms": None, "p95": None, "p99": None}),
    }


def _luminaire(lamp: Luminaire) -> dict[str, Any]:
    """Name and place; of a photometric one the file, its hash, and how it is turned and dimmed."""
    common = {
        "name": lamp.name,
        "position": lamp.position.tolist(),
        "intensity_cd": lamp.intensity.tolist(),
    }
    if isinstance(lamp, PointLuminaire):
        return common
    photometry = lamp.photometry
    return common | {
        "photometry": lamp.path,
        "sha256": photometry.sha256,
        "format": photometry.format,
        "luminaire": photometry.name,
        "flux_lm": lamp.factor * luminous_flux(photometry),
        "power_w": photometry.power,
        "factor": lamp.factor,
        "aim": lamp.aim.tolist(),
        "c0": lamp.axes[0].tolist(),
        "housing": lamp.housing or None,
        "opening": photometry.opening.shape,
        "opening_m": [photometry.opening.along_c0, photometry.opening.along_c90, photometry.opening.height],
    }


def bias_statements(run: Calculation) -> list[str]:
    """Say in words what the spread of replicates cannot show."""
    statements = [
        "Depth: chains and paths end by Russian roulette only; nothing is cut off.",
        mesh_statement(run),
        "Sign: an estimate of almost no light that came out below zero is written as zero.",
    ]
    if bias := chosen_variant(run.plan, run.settings).bias:
        statements.append(bias)
    lobes = list(zip(run.scene.materials, run.plan.lobes, strict=True))
    for material, degree in lobes:
        if degree and material.glossy:
            share = beam_error(material.exponent, int(degree))
            statements.append(
                f"Harmonics: gloss of {material.name} is stored to degree {degree}, "
                f"{share:.2%} of the peak of its lobe for light from one direction."
            )
    if any(not isinstance(lamp, PointLuminaire) for lamp in run.scene.luminaires):
        statements.append(
            "Luminaires: light of a photometric file is taken to leave its opening evenly; nearer than five sizes "
            "of it, and its closed form there by quadrature."
        )
    if any(material.glossy and degree == 0 for material, degree in lobes):
        statements.append("Mirrors: what a sharp lobe shows is interpolated at the surface it meets.")
    return statements


def mesh_statement(run: Calculation) -> str:
    """Say what linear interpolation between the nodes was found to be off by."""
    text = f"Mesh: between the nodes values are linear over edges of {run.edge:.3g} m"
    found = run.interpolation
    if found is None:
        return f"{text}."
    return (
        f"{text}; at {found.probes} points between them they are off by {found.rms:.2%} of the mean "
        f"(root mean square), {found.mean:+.2%} ± {found.mean_std_error:.2%} on average."
    )
