"""VTK poly data as NumPy arrays: the only place that knows how VTK stores points, cells and arrays."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkObject, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkCommonMisc import vtkErrorCode
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from lelight.scene import FloatArray, IntArray
from lelight.writing.files import whole

Arrays = Mapping[str, NDArray[Any]]


def _no_cells() -> IntArray:
    return np.zeros((0, 1), dtype=np.int64)


@dataclass(frozen=True)
class PolyData:
    """Points, cells of one kind each, and named arrays on them.

    Attributes
    ----------
    points : (n, 3) float, m
    markers : (k, 1) int into points, cells that are a single point
    lines : (k, p) int into points, polylines
    polygons : (k, p) int into points, anticlockwise seen from their front
    point_arrays : (n,) or (n, components) by name; ParaView colours by the first
    cell_arrays : likewise, markers first, then lines, then polygons
    component_names : names of an array's components by the array's name
    texts : strings that belong to the whole file, by name
    cell_texts : a string for each cell, by name
    """

    points: FloatArray
    markers: IntArray = field(default_factory=_no_cells)
    lines: IntArray = field(default_factory=_no_cells)
    polygons: IntArray = field(default_factory=_no_cells)
    point_arrays: Arrays = field(default_factory=dict)
    cell_arrays: Arrays = field(default_factory=dict)
    component_names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    cell_texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def write_polydata(path: Path, content: PolyData) -> None:
    """Write a ``.vtp``: XML with compressed binary arrays appended, whole or not at all."""
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(to_vtk(content))
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    with whole(path) as beside, _quiet_vtk():
        writer.SetFileName(str(beside))
        if not writer.Write():
            raise _system_error(writer.GetErrorCode())


@contextmanager
def _quiet_vtk() -> Iterator[None]:
    """Keep VTK from writing its own messages to stderr; error codes are read instead."""
    shown = vtkObject.GetGlobalWarningDisplay()
    vtkObject.GlobalWarningDisplayOff()
    try:
        yield
    finally:
        vtkObject.SetGlobalWarningDisplay(shown)


def _system_error(code: int) -> OSError:
    """Turn VTK's error code, the system's errno where it is one, into the exception it should have been."""
    if code in errno.errorcode:
        return OSError(code, os.strerror(code))
    return OSError(errno.EIO, str(vtkErrorCode.GetStringFromErrorCode(code)))


def to_vtk(content: PolyData) -> Any:
    """Make VTK's poly data of it."""
    points = vtkPoints()
    points.SetData(_vtk_array("points", content.points, ()))
    polydata = vtkPolyData()
    polydata.SetPoints(points)
    polydata.SetVerts(_vtk_cells(content.markers))
    polydata.SetLines(_vtk_cells(content.lines))
    polydata.SetPolys(_vtk_cells(content.polygons))
    for name, values in content.point_arrays.items():
        polydata.GetPointData().AddArray(_vtk_array(name, values, content.component_names.get(name, ())))
    for name, values in content.cell_arrays.items():
        polydata.GetCellData().AddArray(_vtk_array(name, values, content.component_names.get(name, ())))
    for name, texts in content.texts.items():
        polydata.GetFieldData().AddArray(_vtk_strings(name, texts))
    for name, texts in content.cell_texts.items():
        polydata.GetCellData().AddArray(_vtk_strings(name, texts))
    polydata.GetPointData().SetActiveScalars(next(iter(content.point_arrays), ""))
    return polydata


def _vtk_cells(corners: IntArray) -> Any:
    count, size = corners.shape
    offsets = np.arange(count + 1, dtype=np.int64) * size
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(corners, dtype=np.int64).ravel(), deep=True),
    )
    return cells


def _vtk_array(name: str, values: NDArray[Any], component_names: tuple[str, ...]) -> Any:
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    for component, component_name in enumerate(component_names):
        array.SetComponentName(component, component_name)
    return array


def _vtk_strings(name: str, texts: tuple[str, ...]) -> Any:
    array = vtkStringArray()
    array.SetName(name)
    for text in texts:
        array.InsertNextValue(text)
    return array
