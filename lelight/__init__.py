"""lelight: the light in a scene by local estimation of the Monte Carlo method, and how sure it is.

The route through the code, each stop one module:

scene (`scene`, read by `reading`) → plan (`plan`) → node mesh (`mesh.patches`, `mesh.remesh`, `mesh.nodes`) →
light chains (`tracing.chains`, `estimate.defect`) → local estimation at the nodes (`estimate.local`, with
`estimate.nearfield` and `estimate.direct`; `estimate.batch` puts them together) → radiance field (`field`).
`calculation.calculate` walks it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lelight.calculation import calc as calc
    from lelight.field import RadianceField as RadianceField
    from lelight.reading.loading import load as load

__version__ = "0.1.0"

_HOMES = {
    "load": "lelight.reading.loading",
    "calc": "lelight.calculation",
    "RadianceField": "lelight.field",
    "Settings": "lelight.settings",
    "LelightError": "lelight.errors",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for, so that ``import lelight`` costs nothing."""
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'lelight' has no attribute {name!r}")
