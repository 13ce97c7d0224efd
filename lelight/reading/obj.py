"""Wavefront OBJ files: geometry, material names and nothing else, with a line number in every complaint.

Format: Wavefront Technologies, "Advanced Visualizer manual, appendix B1: Object files", version 3.0. Texture
coordinates, normals, groups and smoothing carry no light and are passed over; free-form surfaces are named
in a warning.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from lelight.errors import InputError
from lelight.reading.inputfile import decoded, quoted
from lelight.reading.materialfiles import material_libraries
from lelight.reading.polygons import ear_clipping, fan, fan_fails, fan_polygons
from lelight.reading.wavefront import keyword_and_rest, numbers, texture_free, wavefront_lines
from lelight.scene import FloatArray, IntArray

#: Material of faces that stand before any ``usemtl``.
NAMELESS = "default"

#: Coordinates beyond this are not a room in any unit, and their products would overflow.
LARGEST_COORDINATE = 1e12

#: Corners of a concave polygon; the work of cutting it grows with their square.
LARGEST_CONCAVE = 10_000

#: Statements that say nothing about where a surface is or what it is made of.
PASSED_OVER = frozenset(
    b"vt vn vp l p g o s mg cstype deg bmat step curv curv2 parm trim hole scrv sp end con "
    b"bevel c_interp d_interp lod shadow_obj trace_obj ctech stech usemap maplib".split()
)


@dataclass(frozen=True)
class ObjGeometry:
    """Triangles of an OBJ file, in its own unit and axes.

    Attributes
    ----------
    vertices : (n, 3) float
    triangles : (m, 3) int into vertices, wound as the polygons they come from
    triangle_materials : (m,) int into material_names
    material_libraries : the MTL files named by ``mtllib``, in order, all of them present
    """

    vertices: FloatArray
    triangles: IntArray
    triangle_materials: IntArray
    material_names: tuple[str, ...]
    material_libraries: tuple[Path, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass
class _Statements:
    """What the lines said, so far; arrays because Python's lists take five times the memory."""

    path: Path
    coordinates: array[float] = field(default_factory=lambda: array("d"))
    vertex_lines: array[int] = field(default_factory=lambda: array("q"))
    corners: array[int] = field(default_factory=lambda: array("q"))
    counts: array[int] = field(default_factory=lambda: array("q"))
    face_lines: array[int] = field(default_factory=lambda: array("q"))
    vertices_before: array[int] = field(default_factory=lambda: array("q"))
    face_materials: array[int] = field(default_factory=lambda: array("q"))
    materials: dict[str, int] = field(default_factory=dict)
    material: str = NAMELESS
    libraries: dict[Path, None] = field(default_factory=dict)
    unknown: dict[bytes, int] = field(default_factory=dict)


def read_obj(path: Path) -> ObjGeometry:
    """Read the triangles of an OBJ file and the material each is made of.

    Raises
    ------
    InputError
        with the line, what was found and what is allowed
    """
    statements = _Statements(path)
    for number, line in wavefront_lines(path):
        keyword, rest = keyword_and_rest(line)
        read = _READERS.get(keyword)
        if read is not None:
            try:
                read(statements, rest, number)
            except ValueError as error:
                raise InputError.at(path, number, f"{decoded(keyword)}: {error}") from None
        elif keyword not in PASSED_OVER:
            _remember_unknown(statements.unknown, keyword, number)
    return _geometry(statements)


def _read_vertex(statements: _Statements, rest: bytes, number: int) -> None:
    coordinates = numbers(rest)
    if len(coordinates) not in {3, 4, 6}:
        raise ValueError(
            f"found {len(coordinates)} numbers; allowed are 3, or 4 with a weight, or 6 with a colour"
        )
    statements.coordinates.extend(coordinates[:3])
    statements.vertex_lines.append(number)


def _read_face(statements: _Statements, rest: bytes, number: int) -> None:
    corners = texture_free(rest)
    if len(corners) < 3:
        raise ValueError(f"found {len(corners)} corners; allowed are 3 or more")
    try:
        statements.corners.extend(corners)
    except OverflowError:
        raise ValueError(f"found {quoted(rest)}; allowed are vertex numbers of the file") from None
    statements.counts.append(len(corners))
    statements.face_lines.append(number)
    statements.vertices_before.append(len(statements.vertex_lines))
    statements.face_materials.append(
        statements.materials.setdefault(statements.material, len(statements.materials))
    )


def _read_material(statements: _Statements, rest: bytes, _number: int) -> None:
    statements.material = decoded(rest) or NAMELESS


def _read_libraries(statements: _Statements, rest: bytes, number: int) -> None:
    statements.libraries.update(dict.fromkeys(material_libraries(statements.path, rest, line=number)))


_READERS: dict[bytes, Callable[[_Statements, bytes, int], None]] = {
    b"v": _read_vertex,
    b"f": _read_face,
    b"usemtl": _read_material,
    b"mtllib": _read_libraries,
}


def _remember_unknown(unknown: dict[bytes, int], keyword: bytes, number: int) -> None:
    """Keep the first few; a binary file has thousands."""
    if len(unknown) < 5:
        unknown.setdefault(keyword, number)


def _geometry(statements: _Statements) -> ObjGeometry:
    if not statements.counts:
        raise InputError.at(statements.path, None, "has no faces (no line begins with f); nothing can be lit")
    vertices = _vertices(statements)
    corners = _resolved_corners(statements)
    triangles, polygons, crossing = _triangles(statements, vertices, corners)
    return ObjGeometry(
        vertices=vertices,
        triangles=triangles,
        triangle_materials=_integers(statements.face_materials)[polygons],
        material_names=tuple(statements.materials),
        material_libraries=tuple(statements.libraries),
        warnings=(*_unknown_warnings(statements), *crossing),
    )


def _integers(numbers_read: array[int]) -> IntArray:
    return np.frombuffer(numbers_read, dtype=np.int64)


def _vertices(statements: _Statements) -> FloatArray:
    vertices = np.array(statements.coordinates, dtype=np.float64).reshape(-1, 3)
    usable = (np.abs(vertices) <= LARGEST_COORDINATE).all(axis=1)
    if not usable.all():
        wrong = int(np.argmin(usable))
        raise InputError.at(
            statements.path,
            statements.vertex_lines[wrong],
            f"v: found {vertices[wrong].tolist()}; allowed are finite numbers up to {LARGEST_COORDINATE:g}",
        )
    return vertices


def _resolved_corners(statements: _Statements) -> IntArray:
    """Vertex of every corner, from 0; negative numbers count back from the face's own line."""
    written = _integers(statements.corners)
    before = np.repeat(_integers(statements.vertices_before), _integers(statements.counts))
    n_vertices = len(statements.vertex_lines)
    resolved = np.where(written > 0, written - 1, before + written)
    wrong = (written == 0) | (resolved < 0) | (resolved >= n_vertices)
    if wrong.any():
        first = int(np.argmax(wrong))
        face = int(np.searchsorted(np.cumsum(_integers(statements.counts)), first, side="right"))
        allowed = (
            f"allowed are 1 to {n_vertices}, or -1 to -{before[first]}, in a file of {n_vertices} vertices"
        )
        message = f"f: found vertex number {written[first]}; {allowed}"
        raise InputError.at(statements.path, statements.face_lines[face], message)
    return resolved


def _triangles(
    statements: _Statements, vertices: FloatArray, corners: IntArray
) -> tuple[IntArray, IntArray, tuple[str, ...]]:
    """Triangles (m, 3), the polygon (m,) of each, and warnings about outlines that cross themselves."""
    counts = _integers(statements.counts)
    fails = counts > 3
    fails[fails] = fan_fails(counts[fails], vertices[corners[np.repeat(fails, counts)]])
    polygons = fan_polygons(counts)
    kept = ~fails[polygons]
    triangles, owners = [corners[fan(counts)[kept]]], [polygons[kept]]
    ends, crossing = np.cumsum(counts), []
    for polygon in np.flatnonzero(fails):
        outline = corners[ends[polygon] - counts[polygon] : ends[polygon]]
        line = statements.face_lines[polygon]
        cut = _cut_concave(statements.path, line, vertices[outline])
        if cut is None:
            crossing.append(line)
            cut = fan(np.array([len(outline)]))
        triangles.append(outline[cut])
        owners.append(np.full(len(cut), polygon))
    return _in_file_order(triangles, owners, _crossing_warnings(statements.path, crossing))


def _in_file_order(
    triangles: list[IntArray], owners: list[IntArray], warnings: tuple[str, ...]
) -> tuple[IntArray, IntArray, tuple[str, ...]]:
    polygons = np.concatenate(owners)
    order = np.argsort(polygons, kind="stable")
    return np.concatenate(triangles)[order], polygons[order], warnings


def _cut_concave(path: Path, line: int, outline: FloatArray) -> IntArray | None:
    if len(outline) > LARGEST_CONCAVE:
        message = (
            f"f: found a concave polygon of {len(outline)} corners; allowed are {LARGEST_CONCAVE}, split it"
        )
        raise InputError.at(path, line, message)
    return ear_clipping(outline)


def _crossing_warnings(path: Path, lines: list[int]) -> tuple[str, ...]:
    if not lines:
        return ()
    return (f"{path.name}:{lines[0]}: {len(lines)} polygons whose outline crosses itself, cut as a fan",)


def _unknown_warnings(statements: _Statements) -> tuple[str, ...]:
    if not statements.unknown:
        return ()
    keywords = ", ".join(quoted(keyword) for keyword in statements.unknown)
    line = next(iter(statements.unknown.values()))
    return (f"{statements.path.name}:{line}: statements that are not read: {keywords}",)
