"""``lelight compare``: what differs between two result folders, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lelight.comparison import (
    FAMILY_LEVEL,
    Difference,
    freedom_of,
    of_estimates,
    paired,
    rating_replicates,
    sidak_level,
    unpaired,
)
from lelight.errors import OutputError
from lelight.mesh.nodes import NodeMesh
from lelight.metrics.table import rows
from lelight.pipelines.folder import REPLICATES
from lelight.pipelines.results import read_metrics, read_run
from lelight.scene import BoolArray, FloatArray
from lelight.writing.fieldfile import read_field
from lelight.writing.polydata import PolyData, write_polydata
from lelight.writing.replicatesfile import KeptReplicates, read_replicates

#: Nodes of two meshes are the same ones within this share of the scene's size: single precision of the file.
SAME_PLACE = 1e-6

#: Group, name and figure of a quantity.
Key = tuple[str, str, str]


@dataclass(frozen=True)
class ResultFolder:
    """What two folders are compared by.

    Attributes
    ----------
    figures : rows of ``metrics.json`` by group, name and figure
    intervals : half of the 95 % interval of the same, where there is one
    """

    path: Path
    seed: int
    mesh: NodeMesh
    material_names: list[str]
    figures: dict[Key, dict[str, Any]]
    intervals: dict[Key, float]
    kept: KeptReplicates


@dataclass(frozen=True)
class FigureDifference:
    """Difference of one figure; without an error of either the last four are None.

    Attributes
    ----------
    paired : whether the error is that of the pairs' differences
    half_width : of the 95 % interval of the difference
    """

    group: str
    name: str
    figure: str
    unit: str
    first: float
    second: float
    difference: float
    paired: bool
    std_error: float | None = None
    half_width: float | None = None
    p_value: float | None = None
    significant: bool | None = None


@dataclass(frozen=True)
class Comparison:
    """Everything that a comparison found.

    Attributes
    ----------
    pairs : int, replicates that were compared one by one; 0 where the seeds differ
    nodes : at the visible nodes, None where the meshes differ
    seen : (n,) bool, nodes that are visible in both
    file : VTK file of the differences at the nodes
    """

    pairs: int
    figures: tuple[FigureDifference, ...]
    nodes: Difference | None
    seen: BoolArray | None
    file: Path | None

    @property
    def level(self) -> float:
        """Level of each figure's test, by Šidák."""
        return sidak_level(sum(each.p_value is not None for each in self.figures))

    @property
    def significant_nodes(self) -> int:
        """Count nodes that differ, by Šidák over all visible ones."""
        return 0 if self.nodes is None else int(self.nodes.significant().sum())

    @property
    def differs(self) -> bool:
        """Whether anything differs: a figure or a node."""
        return bool(self.significant_nodes or any(each.significant for each in self.figures))


def run_compare(first: Path, second: Path, *, out: Path | None = None) -> Comparison:
    """Compare two result folders; differences are the second's values less the first's.

    Parameters
    ----------
    out : VTK file of the differences at the nodes, default ``difference.vtp`` in the second folder

    Raises
    ------
    OutputError
        where a folder is not whole, or holds no two replicates
    """
    a, b = _folder(first), _folder(second)
    pairs = min(len(a.kept.nodes), len(b.kept.nodes)) if a.seed == b.seed else 0
    nodes = seen = file = None
    if same_nodes(a.mesh, b.mesh):
        seen = ~(a.mesh.hidden | b.mesh.hidden)
        nodes = _difference(a.kept.nodes[:, seen], b.kept.nodes[:, seen], pairs)
        file = out or second / "difference.vtp"
        _write(file, a.mesh, nodes, seen)
    return Comparison(pairs, tuple(_judged(list(_differences(a, b, pairs)))), nodes, seen, file)


def same_nodes(first: NodeMesh, second: NodeMesh) -> bool:
    """Whether two meshes have the same nodes, so that they can be compared one by one."""
    if first.positions.shape != second.positions.shape or not np.array_equal(
        first.triangles, second.triangles
    ):
        return False
    size = float(np.ptp(first.positions, axis=0).max(initial=0.0))
    return bool(np.abs(first.positions - second.positions).max(initial=0.0) <= SAME_PLACE * size)


def _folder(path: Path) -> ResultFolder:
    metrics, run = read_metrics(path), read_run(path)
    mesh, _, header = read_field(path / "field.vtp")
    kept = read_replicates(path / REPLICATES)
    if kept.nodes.shape[1] != len(mesh):
        raise OutputError(f"{path / REPLICATES}: not of this field.vtp; run `lelight calc` again")
    if len(kept.nodes) < 2:
        raise OutputError(f"{path}: one replicate has no error; run `lelight calc` again with two or more")
    figures = {(row["group"], row["name"], row["figure"]): row for row in rows(metrics)}
    intervals = {}
    for group, name, figure in figures:
        entry = metrics[group][name][figure] if name else metrics[group][figure]
        if entry.get("interval"):
            intervals[group, name, figure] = 0.5 * (entry["interval"][1] - entry["interval"][0])
    return ResultFolder(
        path, int(run.get("seed", 0)), mesh, header["material_names"], figures, intervals, kept
    )


def _difference(first: FloatArray, second: FloatArray, pairs: int) -> Difference:
    """Compare replicates (R, k) and (S, k), the first so many as pairs."""
    return paired(first[:pairs], second[:pairs]) if pairs else unpaired(first, second)


def _differences(a: ResultFolder, b: ResultFolder, pairs: int) -> Iterator[FigureDifference]:
    """Every figure that both folders have: by replicates where they were kept, else by the errors stated."""
    one, two = _by_replicate(a), _by_replicate(b)
    for key in one.keys() & two.keys():
        found = _difference(one[key][:, None], two[key][:, None], pairs)
        yield _entry(key, _unit(a, key), found, is_paired=pairs > 0)
    for key in a.figures.keys() & b.figures.keys() - (one.keys() & two.keys()):
        values = a.figures[key]["value"], b.figures[key]["value"]
        errors = a.figures[key]["std_error"], b.figures[key]["std_error"]
        if None in values:
            continue
        if None in errors:
            group, name, figure = key
            yield FigureDifference(
                group, name, figure, _unit(a, key), values[0], values[1], values[1] - values[0], paired=False
            )
            continue
        freedom = [
            freedom_of(float(error), each.intervals.get(key, 0.0))
            for error, each in zip(errors, (a, b), strict=True)
        ]
        columns = (np.array([float(each)]) for each in (*values, *errors, *freedom))
        yield _entry(key, _unit(a, key), of_estimates(*columns), is_paired=False)


def _by_replicate(folder: ResultFolder) -> dict[Key, FloatArray]:
    """Replicates (R,) of figures that are means of what was kept; of ratings their pseudo-values."""
    kept, mesh = folder.kept, folder.mesh
    areas = mesh.visible_areas
    found: dict[Key, FloatArray] = {}
    for number, name in enumerate(folder.material_names):
        own = np.where(mesh.materials == number, areas, 0.0)
        if own.sum() > 0.0:
            found["materials", name, "mean_illuminance"] = kept.nodes @ own / own.sum()
    if areas.sum() > 0.0:
        found["room", "", "mean_node_illuminance"] = kept.nodes @ areas / areas.sum()
    for name, values in kept.planes.items():
        found["planes", name, "mean_illuminance"] = values.mean(axis=1)
    for name, values in kept.eyes.items():
        found["observers", name, "vertical_illuminance"] = values
        background = kept.eyes_indirect[name]
        rating = folder.figures.get(("observers", name, "ugr"), {}).get("value")
        if rating is not None and np.all(background > 0.0):
            found["observers", name, "ugr"] = rating_replicates(rating, background)
    return found


def _unit(folder: ResultFolder, key: Key) -> str:
    return str(folder.figures[key]["unit"]) if key in folder.figures else "lx"


def _entry(key: Key, unit: str, found: Difference, *, is_paired: bool) -> FigureDifference:
    group, name, figure = key
    return FigureDifference(
        group,
        name,
        figure,
        unit,
        first=float(found.first[0]),
        second=float(found.second[0]),
        difference=float(found.difference[0]),
        paired=is_paired,
        std_error=float(found.std_error[0]),
        half_width=float(found.half_width_95()[0]),
        p_value=float(found.p_values[0]),
    )


def _judged(figures: list[FigureDifference]) -> list[FigureDifference]:
    """Decide which differ, by Šidák over all that have an error; in the order of groups and names."""
    level = sidak_level(sum(each.p_value is not None for each in figures))
    order = {"room": 0, "materials": 1, "planes": 2, "observers": 3}
    figures = sorted(figures, key=lambda each: (order[each.group], each.name, not each.paired, each.figure))
    return [
        each if each.p_value is None else replace(each, significant=each.p_value < level) for each in figures
    ]


def _write(path: Path, mesh: NodeMesh, nodes: Difference, seen: BoolArray) -> None:
    """Write the differences at the nodes; hidden ones differ by nothing."""

    def everywhere(values: FloatArray) -> FloatArray:
        whole = np.zeros(len(mesh))
        whole[seen] = values
        return whole

    write_polydata(
        path,
        PolyData(
            points=mesh.positions,
            polygons=mesh.triangles,
            point_arrays={
                "difference_lx": everywhere(nodes.difference),
                "difference_std_error_lx": everywhere(nodes.std_error),
                "z": everywhere(nodes.z),
                "significant": everywhere(nodes.significant().astype(np.float64)).astype(np.uint8),
                "normal": mesh.normals,
                "hidden": (~seen).astype(np.uint8),
            },
            cell_arrays={"material_id": mesh.triangle_materials.astype(np.int32)},
        ),
    )


def as_table(comparison: Comparison) -> dict[str, Any]:
    """Plain mapping for JSON."""
    nodes = comparison.nodes
    return {
        "pairs": comparison.pairs,
        "family_level": FAMILY_LEVEL,
        "level": comparison.level,
        "differs": comparison.differs,
        "figures": [vars(each) for each in comparison.figures],
        "nodes": None
        if nodes is None
        else {
            "compared": len(nodes.difference),
            "significant": comparison.significant_nodes,
            "file": str(comparison.file),
        },
    }
