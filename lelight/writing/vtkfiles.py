"""Results as VTK files: the node field, planes, luminaires, observers, and the index of all."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from lelight.channels import luminance_weighted
from lelight.luminaires import Luminaire, PhotometricLuminaire
from lelight.results import PlaneValues
from lelight.scene import FloatArray, IntArray, Observer
from lelight.writing.fieldfile import read_field, write_field
from lelight.writing.files import write_text
from lelight.writing.layout import opening_outline
from lelight.writing.polydata import PolyData, write_polydata

__all__ = ["read_field", "write_field", "write_index", "write_luminaires", "write_observers", "write_plane"]


def write_plane(path: Path, values: PlaneValues) -> None:
    """Write a plane's grid: quadrangles between its points as ``.vtp``, the points as ``.csv`` beside it."""
    quadrangles = _quadrangles(*values.shape)
    arrays = {
        "illuminance_lx": values.illuminance,
        "illuminance_std_error_lx": values.std_error,
        "cylindrical_illuminance_lx": values.cylindrical,
    }
    content = PolyData(
        points=values.points,
        # A grid of a single row or column spans no area: show its points.
        markers=_markers(0 if len(quadrangles) else len(values.points)),
        polygons=quadrangles,
        point_arrays=arrays,
        texts={"name": (values.plane.name,)},
    )
    write_polydata(path, content)
    write_text(path.with_suffix(".csv"), _table(values.points, arrays))


def write_luminaires(path: Path, luminaires: Sequence[Luminaire], *, length: float = 0.4) -> None:
    """Write luminaires as points with ``intensity_cd`` (the largest) and ``name``.

    Photometric ones also have the outline of their opening, an arrow of ``length`` in m to C0 and one along
    γ = 0; ``part`` tells them apart: 0 place, 1 C0, 2 γ = 0, 3 opening.
    """
    count = len(luminaires)
    places = np.array([lamp.position for lamp in luminaires], dtype=float).reshape(-1, 3)
    marks = [
        (number, *mark) for number, lamp in enumerate(luminaires) for mark in _luminaire_marks(lamp, length)
    ]
    segments = [np.stack([points[:-1], points[1:]], axis=1).reshape(-1, 3) for _, _, points in marks]
    owners = np.repeat([number for number, _, _ in marks], [len(ends) // 2 for ends in segments]).astype(int)
    parts = np.repeat([part for _, part, _ in marks], [len(ends) // 2 for ends in segments])
    owner = np.concatenate([np.arange(count), np.repeat(owners, 2)]).astype(int)
    intensities = np.array([luminance_weighted(lamp.intensity) for lamp in luminaires], dtype=float)
    write_polydata(
        path,
        PolyData(
            points=np.concatenate([places, *segments]),
            markers=_markers(count),
            lines=count + np.arange(2 * len(owners)).reshape(-1, 2),
            point_arrays={"intensity_cd": intensities[owner]},
            cell_arrays={"part": np.concatenate([np.zeros(count), parts]).astype(np.int32)},
            cell_texts={"name": tuple(luminaires[number].name for number in [*range(count), *owners])},
        ),
    )


def _luminaire_marks(lamp: Luminaire, length: float) -> list[tuple[int, FloatArray]]:
    """Lines (n, 3) of a photometric luminaire by part."""
    if not isinstance(lamp, PhotometricLuminaire):
        return []
    outline = opening_outline(lamp)
    return [
        (1, _shaft(lamp.position, lamp.axes[0], lamp.axes[1], length)),
        (2, _shaft(lamp.position, lamp.aim, lamp.axes[0], length)),
        (3, np.concatenate([outline, outline[:1]])),
    ]


def _shaft(start: FloatArray, along: FloatArray, aside: FloatArray, length: float) -> FloatArray:
    """Arrow (5, 3) in m as one line: tail, tip, barb, tip, barb."""
    tip = start + length * along
    barb = tip - 0.2 * length * along
    return np.array([start, tip, barb + 0.1 * length * aside, tip, barb - 0.1 * length * aside])


def write_observers(path: Path, observers: Sequence[Observer], *, length: float = 0.5) -> None:
    """Write observers as arrows of ``length`` in m along their lines of sight, with ``name``."""
    arrows = [_arrow(observer, length) for observer in observers]
    count = len(arrows)
    write_polydata(
        path,
        PolyData(
            points=np.array(arrows, dtype=float).reshape(-1, 3),
            # From the eye to the tip, then to either barb and back over the tip.
            lines=4 * np.arange(count)[:, None] + np.array([0, 1, 2, 1, 3]),
            cell_arrays={"observer_id": np.arange(count, dtype=np.int32)},
            cell_texts={"name": tuple(observer.name for observer in observers)},
        ),
    )


def write_index(path: Path, blocks: Mapping[str, Mapping[str, Path]]) -> None:
    """Write ``scene.vtm``: groups of named files, referred to by their path from the index's folder.

    Parameters
    ----------
    blocks : files by name by group, as in ``{"planes": {"work plane": out / "planes" / "work plane.vtp"}}``
    """
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<VTKFile type="vtkMultiBlockDataSet" version="1.0">']
    lines += [" <vtkMultiBlockDataSet>"]
    for group, (group_name, files) in enumerate(blocks.items()):
        lines += [f'  <Block index="{group}" name={quoteattr(group_name)}>']
        for item, (name, file) in enumerate(files.items()):
            reference = quoteattr(Path(os.path.relpath(file, path.parent)).as_posix())
            lines += [f'   <DataSet index="{item}" name={quoteattr(name)} file={reference}/>']
        lines += ["  </Block>"]
    lines += [" </vtkMultiBlockDataSet>", "</VTKFile>", ""]
    write_text(path, "\n".join(lines))


def _quadrangles(rows: int, columns: int) -> IntArray:
    point = np.arange(rows * columns).reshape(rows, columns)
    corners = [point[:-1, :-1], point[:-1, 1:], point[1:, 1:], point[1:, :-1]]
    return np.stack(corners, axis=-1).reshape(-1, 4)


def _markers(count: int) -> IntArray:
    return np.arange(count)[:, None]


def _table(points: FloatArray, arrays: Mapping[str, FloatArray]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["x_m", "y_m", "z_m", *arrays])
    for row in np.column_stack([points, *arrays.values()]):
        writer.writerow([f"{number:.10g}" for number in row])
    return stream.getvalue()


def _arrow(observer: Observer, length: float) -> FloatArray:
    """Eye, tip and two barbs (4, 3) in m."""
    along = np.asarray(observer.direction, dtype=float) / np.linalg.norm(observer.direction)
    aside = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    tip = observer.position + length * along
    barb = tip - 0.2 * length * along
    return np.array([observer.position, tip, barb + 0.1 * length * aside, barb - 0.1 * length * aside])
