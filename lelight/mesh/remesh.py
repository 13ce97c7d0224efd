"""Remeshing: from the triangles of a model to a mesh that can carry light, a patch at a time.

Rectangles get a grid. Everything else is cut by longest-edge bisection, which is exact; where the model's
needles leave that misshapen or wasteful, pymeshlab remeshes the patch, and its mesh is taken only if it still
covers the patch; of a bent patch of very many triangles one of shorter edges may. This module is pymeshlab's only
user.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np

from lelight.mesh.bisection import bisect
from lelight.mesh.nearest import nearest_points
from lelight.mesh.nodes import SurfaceMesh
from lelight.mesh.outlines import convex_quads
from lelight.mesh.pieces import Piece, joined, select, triangle_quality, vertex_normals
from lelight.mesh.quads import grid_quads
from lelight.mesh.torn import TornMesh, tear
from lelight.scene import BoolArray, FloatArray, IntArray, Scene, triangle_areas

#: How far the area and the extent of a remeshed patch may be off, relative.
FAITHFUL = 1e-4

#: Nodes that an ordinary room is given by default, before borders and furniture add theirs.
DEFAULT_NODES = 4000

#: Ridges sharper than this (degrees) are kept: cutting across one of 1° costs 4e-5 of the area at most.
RIDGE_DEGREES = 1.0

#: Settings of pymeshlab's ``meshing_isotropic_explicit_remeshing``.
REMESHING: dict[str, Any] = {
    "iterations": 10,
    "adaptive": False,
    "selectedonly": False,
    "featuredeg": RIDGE_DEGREES,
    "checksurfdist": False,
    "splitflag": True,
    "collapseflag": True,
    "swapflag": True,
    "smoothflag": True,
    "reprojectflag": True,
}

#: A patch whose mean triangle quality is below this is worth remeshing (a right isosceles triangle has 0.87).
POOR_QUALITY = 0.6

#: So is one with this many times the triangles that equilateral ones of the wanted edge would need.
WASTEFUL = 2.0

#: A bent patch that loses too much is remeshed again at this share of the edge that would just do, and at half at most.
SHORTER, AT_MOST = 0.9, 0.5


def default_edge(scene: Scene) -> float:
    """Choose an edge length in m by the size of the scene: ``sqrt(area / 4000)``.

    That is about 12 cm in an office of 4 m by 3 m and gives ordinary rooms 3 000 to 8 000 nodes. It is held
    between 1/500 and 1/10 of the scene's diagonal, so that neither a wire nor a crammed hall gets an absurd
    one.
    """
    edge = np.sqrt(triangle_areas(scene.corners).sum() / DEFAULT_NODES)
    return float(np.clip(edge, scene.diagonal / 500, scene.diagonal / 10))


def remesh(scene: Scene, labels: IntArray, *, edge: float) -> SurfaceMesh:
    """Remesh the surface patch by patch to triangles of about the wanted edge length.

    Every patch keeps its area and its extent to 1e-4 or better; no vertex belongs to two patches. The same
    input gives the same mesh to the last bit.

    Parameters
    ----------
    labels : (n_t,) int, patch of each triangle of the scene, as by `lelight.mesh.patches.patches`
    edge : float, m

    Raises
    ------
    ValueError
        where ``edge`` is not a positive length
    """
    if not (np.isfinite(edge) and edge > 0):
        raise ValueError(f"edge: {edge!r} is not a positive length")
    torn = tear(scene, labels)
    gridded, gridded_patches = _gridded(torn, edge)
    cut = _bisected(torn, np.isin(torn.triangle_patches, gridded_patches, invert=True), edge)
    remade = [piece for patch in _worth_remeshing(torn, cut, edge) if (piece := _remade(torn, patch, edge))]
    taken = np.array([piece.triangle_patches[0] for piece in remade], dtype=np.int64)
    kept = select(cut, np.isin(cut.triangle_patches, taken, invert=True))
    return _surface(torn, joined([gridded, kept, *remade]), _patch_materials(scene, labels))


def _gridded(torn: TornMesh, edge: float) -> tuple[Piece, IntArray]:
    """Grids over all patches that are convex quadrilaterals, and which these are."""
    quads = convex_quads(torn)
    vertices, triangles, vertex_quads, triangle_quads = grid_quads(quads.corners, edge=edge)
    return Piece(
        vertices, triangles, quads.patches[vertex_quads], quads.patches[triangle_quads]
    ), quads.patches


def _bisected(torn: TornMesh, chosen: BoolArray, edge: float) -> Piece:
    """Bisect the chosen triangles (m,) of all patches at once."""
    own = torn.triangle_patches[chosen]
    vertices, triangles, parents = bisect(torn.vertices, torn.triangles[chosen], edge=edge)
    patches = np.zeros(len(vertices), dtype=np.int64)
    patches[triangles] = own[parents][:, None]
    return select(Piece(vertices, triangles, patches, own[parents]), np.ones(len(triangles), dtype=bool))


def _worth_remeshing(torn: TornMesh, cut: Piece, edge: float) -> IntArray:
    """Patches larger than an edge whose bisected triangles are badly shaped or far too many."""
    quality = triangle_quality(cut.vertices[cut.triangles])
    count = np.bincount(cut.triangle_patches, minlength=torn.patch_count)
    mean_quality = np.bincount(cut.triangle_patches, quality, torn.patch_count) / np.maximum(count, 1)
    poor = (mean_quality < POOR_QUALITY) | _wasteful(count, torn.areas, edge)
    return np.flatnonzero(poor & (count > 1) & (torn.diagonals > edge))


def _wasteful(count: IntArray | int, area: FloatArray | float, edge: float) -> BoolArray:
    """Tell whether patches of so many triangles and such areas in m² could do with far fewer of the edge."""
    wanted = np.asarray(area) / (np.sqrt(3) / 4 * edge**2)
    return np.asarray(count > WASTEFUL * (wanted + 1))


def _remade(torn: TornMesh, patch: int, edge: float) -> Piece | None:
    """Remesh one patch with pymeshlab, then with its border kept; None where neither covers the patch.

    Triangles with their corners on a bent patch lose area as the square of their edge: where a shorter one still
    spares many of the patch's own triangles, that is tried before the border is kept.
    """
    vertices, triangles = torn.piece(patch)
    origin = vertices.mean(axis=0)
    attempts = [(_isotropic_inside, edge), (_isotropic, edge)]
    while attempts:
        remesher, length = attempts.pop()
        points, faces = remesher(vertices - origin, triangles, length)
        if len(faces) == 0:
            continue
        points = _projected(points, vertices - origin, triangles, torn.flat[patch], torn.plane_normals[patch])
        loss = _loss(points, faces, vertices - origin, triangles)
        if loss <= FAITHFUL:
            same = [np.full(count, patch, dtype=np.int64) for count in (len(points), len(faces))]
            return select(Piece(points + origin, faces, *same), np.ones(len(faces), dtype=bool))
        shorter = length * min(SHORTER * (FAITHFUL / loss) ** 0.5, AT_MOST)
        if (
            remesher is _isotropic
            and not torn.flat[patch]
            and _wasteful(len(triangles), torn.areas[patch], shorter)
        ):
            attempts.append((_isotropic, shorter))
    return None


def _isotropic(vertices: FloatArray, triangles: IntArray, edge: float) -> tuple[FloatArray, IntArray]:
    """Remesh by splitting, collapsing, swapping and smoothing everywhere."""
    return _run_pymeshlab(vertices, triangles, edge, [{}])


def _isotropic_inside(vertices: FloatArray, triangles: IntArray, edge: float) -> tuple[FloatArray, IntArray]:
    """Remesh without losing a border vertex: collapse nothing, then collapse away from the border only."""
    return _run_pymeshlab(vertices, triangles, edge, [{"collapseflag": False}, {"selectedonly": True}])


@lru_cache(maxsize=1)
def remesher_missing() -> str | None:
    """Say in one line why patches are only bisected here, if pymeshlab cannot be loaded (it links OpenGL)."""
    try:
        import_module("pymeshlab")
    except ImportError as error:
        return (
            f"pymeshlab does not load ({error}); patches are bisected instead: install Debian package libgl1"
        )
    return None


def _run_pymeshlab(
    vertices: FloatArray, triangles: IntArray, edge: float, passes: Sequence[dict[str, bool]]
) -> tuple[FloatArray, IntArray]:
    """Run passes of isotropic remeshing (Botsch & Kobbelt, SGP 2004); an empty mesh where it fails.

    Every flag is named in every call: pymeshlab remembers those of the call before.
    """
    if remesher_missing() is not None:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    import pymeshlab  # takes 0.2 s, and many runs need none of it

    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(vertices, triangles))
    try:
        for changes in passes:
            if changes.get("selectedonly"):
                _select_inside(meshes)
            length = pymeshlab.PureValue(edge)
            meshes.meshing_isotropic_explicit_remeshing(targetlen=length, **{**REMESHING, **changes})
    except pymeshlab.PyMeshLabException:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)


def _select_inside(meshes: Any) -> None:
    meshes.compute_selection_from_mesh_border()
    meshes.apply_selection_inverse(invfaces=True, invverts=False)


def _projected(
    points: FloatArray, vertices: FloatArray, triangles: IntArray, flat: bool, normal: FloatArray
) -> FloatArray:
    """Put points back on the patch: along the normal of a flat one, to the nearest point of a curved one."""
    if flat:
        return np.asarray(points - np.outer((points - vertices[0]) @ normal, normal))
    same = [np.zeros(count, dtype=np.int64) for count in (len(points), len(triangles))]
    return nearest_points(points, same[0], vertices[triangles], same[1])[0]


def _loss(points: FloatArray, faces: IntArray, vertices: FloatArray, triangles: IntArray) -> float:
    """Measure how far a mesh is from covering what the triangles cover: by extent, area and vector area, relative.

    The vector area of a surface is fixed by its border, so together with the area it betrays folds.
    """
    extents = [np.stack([part.min(axis=0), part.max(axis=0)]) for part in (points[faces.ravel()], vertices)]
    diagonal = float(np.linalg.norm(extents[1][1] - extents[1][0]))
    sides = [_vector_areas(points[faces]), _vector_areas(vertices[triangles])]
    areas = [float(np.linalg.norm(part, axis=1).sum()) for part in sides]
    drift = float(np.linalg.norm(sides[0].sum(axis=0) - sides[1].sum(axis=0)))
    off = max(abs(areas[0] - areas[1]), drift) / areas[1]
    return max(float(np.abs(extents[0] - extents[1]).max()) / diagonal, off)


def _vector_areas(corners: FloatArray) -> FloatArray:
    return np.asarray(0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def _surface(torn: TornMesh, whole: Piece, patch_materials: IntArray) -> SurfaceMesh:
    """Add normals: the plane's on flat patches, the mean of the triangles around on curved ones."""
    normals = torn.plane_normals[whole.vertex_patches]
    curved = ~torn.flat[whole.vertex_patches]
    bent = whole.triangles[~torn.flat[whole.triangle_patches]]
    normals[curved] = vertex_normals(whole.vertices, bent)[curved]
    return SurfaceMesh(
        vertices=whole.vertices,
        triangles=whole.triangles,
        triangle_patches=whole.triangle_patches,
        normals=normals,
        vertex_patches=whole.vertex_patches,
        patch_materials=patch_materials,
    )


def _patch_materials(scene: Scene, labels: IntArray) -> IntArray:
    """Material (n_patches,) of each patch: that of its triangles."""
    materials = np.zeros(int(labels.max(initial=-1)) + 1, dtype=np.int64)
    materials[labels] = scene.triangle_materials
    return materials
