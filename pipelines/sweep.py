"""What a sweep turns: one knob at a time around the middle of the dial, most telling first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lelight.dial import edge_scale
from lelight.mesh.remesh import default_edge
from lelight.plan import make_plan
from lelight.scene import Scene
from lelight.settings import PRESETS

#: Targets at the default edge; edges, as multiples of the default, at the middle target.
TARGETS = (0.05, 0.1, 0.025, 0.2)
EDGES = (1.6, 2.5, 0.7)
MIDDLE = 0.05
#: Degrees beside the plan's own, as shares of it.
DEGREES = (0.5, 1.5)
#: What a long run is made with, beside its time.
REFERENCE = {"target": 0.002, "preset": "fine"}


@dataclass(frozen=True)
class Variation:
    """One run of a sweep.

    Attributes
    ----------
    stem : of its folder
    scale : of its edge against the default
    settings : that differ from the default; ``target`` is always there
    """

    knob: str
    value: str
    stem: str
    settings: dict[str, Any]
    scale: float = 1.0


def variations(scene: Scene) -> list[Variation]:
    """List the runs of a sweep for a scene, in the order in which a budget is spent on them."""
    edge = default_edge(scene)
    found = [
        Variation("chains", f"target {t:.1%}", f"target-{t:g}", {"target": t, "edge": edge}) for t in TARGETS
    ]
    found += [
        Variation("mesh", f"edge x {s:g}", f"edge-{s:g}", {"target": MIDDLE, "edge": s * edge}, s)
        for s in EDGES
    ]
    found += [
        Variation(
            "preset",
            name,
            f"preset-{name}",
            {"target": values.target, "preset": name},
            edge_scale(values.target),
        )
        for name, values in PRESETS.items()
    ]
    degree = make_plan(scene).degree
    if degree:
        middle = {"target": MIDDLE, "edge": edge}
        found.append(Variation("method", "grid", "method-grid", middle | {"method": "grid"}))
        found += [
            Variation("degree", f"{each}", f"degree-{each}", middle | {"degree": each, "angular": "seen"})
            for each in (round(s * degree) for s in DEGREES)
        ]
    return sorted(found, key=lambda each: (each.value == "fine", each.knob == "degree"))
