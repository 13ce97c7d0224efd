"""``field.vtp``: everything that is known at the nodes, and its way back."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lelight.channels import channel_suffixes, luminance_weighted
from lelight.errors import OutputError
from lelight.mesh.nodes import NodeMesh
from lelight.results import NodeValues
from lelight.scene import FloatArray, IntArray
from lelight.writing.polydata import PolyData, write_polydata
from lelight.writing.vtpreading import read_polydata

#: More channels than any run carries.
MOST_CHANNELS = 1000

SH_CONVENTION = (
    "real orthonormal, no Condon-Shortley phase, index l*l + l + m, "
    "local frame x = frame_x, z = normal, y = z cross x"
)

UNITS = {
    "length": "m",
    "illuminance": "lx",
    "luminance": "cd/m2",
    "exitance": "lm/m2",
    "radiance_sh": "cd/m2",
}


def write_field(
    path: Path,
    mesh: NodeMesh,
    values: NodeValues,
    *,
    exitance: FloatArray,
    luminance: FloatArray,
    material_names: Sequence[str],
    header: Mapping[str, Any],
    weights: FloatArray | None = None,
) -> None:
    """Write ``field.vtp``: everything that is known at the nodes.

    Quantities are luminance-weighted; with more than one channel each channel stands beside them under the
    endings of `channel_suffixes`, so that `read_field` gives back what went in.

    Parameters
    ----------
    exitance : (n, C) float, lm/m²
    luminance : (n, C) float, cd/m², along the normal
    header : what the file says about the run (version, seed, up axis, input hashes), as JSON can hold it
    weights : (C,) float, luminance weights of channels that are neither grey nor Rec. 709
    """
    channels = values.illuminance.shape[-1]
    told = {"channels": channels, "units": UNITS, "sh_convention": SH_CONVENTION, **header}
    coefficients = _stored_harmonics(values)
    names = tuple(f"Y_{degree}_{order}" for degree, order in _harmonics(coefficients.shape[1]))
    harmonics = _by_channel("radiance_sh", coefficients)
    write_polydata(
        path,
        PolyData(
            points=mesh.positions,
            polygons=mesh.triangles,
            point_arrays={
                **_photometric_arrays(values, exitance, luminance, weights),
                **harmonics,
                **_node_arrays(mesh, values.sh_degree),
                **_truncation(values),
            },
            cell_arrays={
                "material_id": mesh.triangle_materials.astype(np.int32),
                "patch_id": mesh.triangle_patches.astype(np.int32),
                "side": mesh.triangle_sides.astype(np.int8),
            },
            component_names=dict.fromkeys(harmonics, names),
            texts={"lelight": (json.dumps(told),), "material_names": tuple(material_names)},
        ),
    )


def read_field(path: Path) -> tuple[NodeMesh, NodeValues, dict[str, Any]]:
    """Read back what `write_field` wrote; the header also has ``material_names``.

    A node that no triangle uses has no surface to stand for and comes back as hidden.

    Raises
    ------
    OutputError
        where the file is missing, cut off, damaged or not a field of lelight
    """
    content = read_polydata(path)
    try:
        header = json.loads(content.texts["lelight"][0])
        header["material_names"] = list(content.texts["material_names"])
        _require_shapes(content, header["channels"])
        return _node_mesh(content), _node_values(content, header["channels"]), header
    except KeyError as missing:
        raise OutputError(
            f"{path}: not a field of lelight: {missing} is missing: give field.vtp of a finished run"
        ) from missing
    except (ValueError, TypeError, AttributeError, IndexError, RecursionError) as error:
        told = " ".join(str(error).split())[:150]
        raise OutputError(f"{path}: damaged ({told}): write it again with lelight calc") from error


def _require_shapes(content: PolyData, channels: Any) -> None:
    """Check that arrays have the components that they should, and finite numbers.

    Raises
    ------
    KeyError, ValueError
        where one is missing, or not as it should be
    """
    if not isinstance(channels, int) or isinstance(channels, bool) or not 1 <= channels <= MOST_CHANNELS:
        raise ValueError("its channels are no number of them")
    arrays, count = content.point_arrays, len(content.points)
    if content.polygons.shape[1:] != (3,) and len(content.polygons):
        raise ValueError("its polygons are no triangles")
    singles = ("illuminance_lx", "direct_illuminance_lx", "scalar_illuminance_lx")
    expected: dict[str, tuple[int, ...]] = dict.fromkeys(
        ("area_m2", "hidden", "sh_degree", "illuminance_std_error_lx"), (count,)
    )
    expected |= dict.fromkeys(("corner_m", "normal", "frame_x"), (count, 3))
    for suffix in channel_suffixes(channels):
        expected |= {name + suffix: (count,) for name in singles}
        expected |= {"light_vector_lx" + suffix: (count, 3)}
        harmonics = arrays["radiance_sh" + suffix].size // max(count, 1)
        if math.isqrt(harmonics) ** 2 != harmonics:
            raise ValueError("'radiance_sh' has no square number of components")
        expected["radiance_sh" + suffix] = (count,) if harmonics == 1 else (count, harmonics)
    for name, shape in expected.items():
        if count and arrays[name].shape != shape:
            raise ValueError(f"{name!r} has the shape {arrays[name].shape}, not {shape}")
        if name != "illuminance_std_error_lx" and not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name!r} has numbers that are not finite")
    stored = math.isqrt(arrays["radiance_sh" + channel_suffixes(channels)[0]].size // max(count, 1)) - 1
    degrees = arrays["sh_degree"]
    if count and not (degrees.min() >= 0 and degrees.max() <= max(stored, 0)):
        raise ValueError("'sh_degree' is beyond what is stored")
    if not np.isfinite(content.points).all():
        raise ValueError("its points are not finite")


def _photometric_arrays(
    values: NodeValues, exitance: FloatArray, luminance: FloatArray, weights: FloatArray | None
) -> dict[str, NDArray[Any]]:
    quantities = {
        "illuminance_lx": values.illuminance,
        "direct_illuminance_lx": values.direct,
        "scalar_illuminance_lx": values.scalar_illuminance,
        "light_vector_lx": values.light_vector,
        "luminance_cd_m2": luminance,
        "exitance_lm_m2": exitance,
    }
    arrays = {name: luminance_weighted(quantity, weights=weights) for name, quantity in quantities.items()}
    for name, quantity in quantities.items():
        arrays.update(_by_channel(name, quantity))
    return {**arrays, "illuminance_std_error_lx": values.std_error}


def _node_arrays(mesh: NodeMesh, sh_degree: IntArray) -> dict[str, NDArray[Any]]:
    return {
        "sh_degree": sh_degree.astype(np.int32),
        "frame_x": mesh.frames_x,
        "normal": mesh.normals,
        "hidden": mesh.hidden.astype(np.uint8),
        "corner_m": mesh.vertices,
        "area_m2": mesh.areas,
    }


def _truncation(values: NodeValues) -> dict[str, NDArray[Any]]:
    if not values.sh_degree.any():
        return {}
    return {"radiance_truncation_cd_m2": values.truncation.astype(np.float32)}


def _by_channel(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    return {
        name + suffix: values[..., channel]
        for channel, suffix in enumerate(channel_suffixes(values.shape[-1]))
    }


def _stored_harmonics(values: NodeValues) -> NDArray[np.float32]:
    """Cut coefficients to the largest degree that a node uses."""
    used = (int(values.sh_degree.max(initial=0)) + 1) ** 2
    return np.asarray(values.radiance_sh[:, :used], dtype=np.float32)


def _harmonics(count: int) -> list[tuple[int, int]]:
    degrees = [int(np.sqrt(index)) for index in range(count)]
    return [(degree, index - degree * degree - degree) for index, degree in enumerate(degrees)]


def _node_mesh(content: PolyData) -> NodeMesh:
    arrays, triangles = content.point_arrays, content.polygons
    surfaceless = np.ones(len(content.points), dtype=bool)
    surfaceless[triangles.ravel()] = False
    return NodeMesh(
        vertices=arrays["corner_m"],
        positions=content.points,
        normals=arrays["normal"],
        frames_x=arrays["frame_x"],
        areas=arrays["area_m2"],
        materials=_at_corners(content, "material_id"),
        patches=_at_corners(content, "patch_id"),
        sides=_at_corners(content, "side"),
        hidden=(arrays["hidden"] != 0) | surfaceless,
        triangles=triangles,
    )


def _at_corners(content: PolyData, name: str) -> IntArray:
    """Carry what the triangles share with their nodes back to the nodes."""
    node_values = np.zeros(len(content.points), dtype=np.int64)
    node_values[content.polygons] = content.cell_arrays[name][:, None]
    return node_values


def _node_values(content: PolyData, channels: int) -> NodeValues:
    arrays = content.point_arrays

    def stacked(name: str) -> NDArray[Any]:
        return np.stack([arrays[name + suffix] for suffix in channel_suffixes(channels)], axis=-1)

    return NodeValues(
        illuminance=stacked("illuminance_lx"),
        std_error=arrays["illuminance_std_error_lx"],
        direct=stacked("direct_illuminance_lx"),
        scalar_illuminance=stacked("scalar_illuminance_lx"),
        light_vector=stacked("light_vector_lx"),
        sh_degree=arrays["sh_degree"].astype(np.int64),
        radiance_sh=stacked("radiance_sh").reshape(len(content.points), -1, channels),
        truncation=_truncation_of(content),
    )


def _truncation_of(content: PolyData) -> NDArray[np.float32]:
    """Read truncation errors (n,), which are left out where nothing is glossy."""
    found = content.point_arrays.get("radiance_truncation_cd_m2")
    if found is None:
        return np.zeros(len(content.points), dtype=np.float32)
    if found.shape != (len(content.points),) or not np.isfinite(found).all():
        raise ValueError("'radiance_truncation_cd_m2' is no finite number a node")
    return found.astype(np.float32)
