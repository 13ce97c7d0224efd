"""``replicates.npz``: what every replicate found, so that two runs can be compared replicate by replicate."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lelight.errors import OutputError
from lelight.estimate.blocks import Effort
from lelight.estimate.replicates import Replicates
from lelight.estimate.samplingplan import SamplingPlan, StartingCells
from lelight.receivers import ILLUMINANCE
from lelight.results import ObserverValues, PlaneValues
from lelight.scene import FloatArray


@dataclass(frozen=True)
class KeptReplicates:
    """Illuminance in lx by each of R replicates; float32 in the file, seven digits.

    Attributes
    ----------
    nodes : (R, n) float, at the nodes of ``field.vtp``
    planes : (R, k) float by name, at the points of the grids
    eyes, eyes_indirect : (R,) float by name, on the plane across the line of sight: all light, and without direct
    sampling : how the run sampled
    """

    nodes: FloatArray
    planes: dict[str, FloatArray]
    eyes: dict[str, FloatArray]
    eyes_indirect: dict[str, FloatArray]
    sampling: SamplingPlan


def write_replicates(
    path: Path,
    replicates: Replicates,
    planes: Sequence[PlaneValues],
    observers: Sequence[ObserverValues],
    sampling: SamplingPlan,
) -> None:
    """Write every replicate's illuminances and how they came about; numbers and names only, no pickles."""
    effort = sampling.effort
    none: NDArray[Any] = np.zeros((replicates.count, 0))
    indirect = [each.indirect_replicates for each in observers]
    total = [_at_eye(each) for each in observers]
    content: dict[str, NDArray[Any]] = {
        "nodes_lx": replicates.at_nodes.astype(np.float32),
        "plane_names": np.array([each.plane.name for each in planes], dtype=np.str_),
        "plane_points": np.array([len(each.points) for each in planes], dtype=np.int64),
        "planes_lx": np.concatenate([none, *(each.replicates for each in planes)], axis=1).astype(np.float32),
        "observer_names": np.array([each.observer.name for each in observers], dtype=np.str_),
        "observers_lx": np.stack(total, axis=1).astype(np.float32) if total else none,
        "observers_indirect_lx": np.stack(indirect, axis=1).astype(np.float32) if indirect else none,
        "log2_samples": np.array([effort.log2_chains, effort.log2_direct, effort.log2_near]),
        "bound": np.array(effort.bound),
        "path_bound": np.array(effort.path_bound),
        "doublings": np.array(sampling.doublings),
        "direct_doublings": sampling.direct_doublings.astype(np.int8),
        "near_doublings": sampling.near_doublings.astype(np.int8),
        "edge_m": np.array(sampling.edge),
    }
    if sampling.starts is not None:
        content |= {f"starts_{name}": column for name, column in vars(sampling.starts).items()}
    with path.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **content)


def _at_eye(values: ObserverValues) -> FloatArray:
    """Illuminance (R,) of an eye in all."""
    if values.moment_replicates is None:
        return values.direct + values.indirect_replicates
    return np.asarray(values.moment_replicates[:, ILLUMINANCE])


def read_replicates(path: Path) -> KeptReplicates:
    """Read back what `write_replicates` wrote.

    Raises
    ------
    OutputError
        where the file is missing, damaged or not of lelight
    """
    remedy = "run `lelight calc` again"
    try:
        with path.open("rb") as whole_file, np.load(whole_file, allow_pickle=False) as file:
            content = {name: file[name] for name in file.files}
        return _kept(content)
    except FileNotFoundError as error:
        raise OutputError(f"{path}: no such file, replicates were not kept; {remedy}") from error
    except KeyError as missing:
        raise OutputError(f"{path}: not replicates of lelight: {missing} is missing; {remedy}") from missing
    except OSError as error:
        raise OutputError(f"{path}: {error.strerror or error}; {remedy}") from error
    except (ValueError, TypeError, IndexError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise OutputError(f"{path}: damaged ({error}); {remedy}") from error


def _kept(content: dict[str, NDArray[Any]]) -> KeptReplicates:
    nodes = content["nodes_lx"].astype(np.float64)
    chains, direct, near = (int(each) for each in content["log2_samples"])
    ends = np.cumsum(content["plane_points"])[:-1]
    planes = np.split(content["planes_lx"].astype(np.float64), ends, axis=1)
    eyes = [str(name) for name in content["observer_names"]]
    return KeptReplicates(
        nodes=nodes,
        planes=dict(zip(map(str, content["plane_names"]), planes, strict=False)),
        eyes=dict(zip(eyes, content["observers_lx"].astype(np.float64).T, strict=True)),
        eyes_indirect=dict(zip(eyes, content["observers_indirect_lx"].astype(np.float64).T, strict=True)),
        sampling=SamplingPlan(
            effort=Effort(chains, direct, near, float(content["bound"]), float(content["path_bound"])),
            replicates=len(nodes),
            doublings=int(content["doublings"]),
            direct_doublings=content["direct_doublings"].astype(np.int64),
            near_doublings=content["near_doublings"].astype(np.int64),
            edge=float(content["edge_m"]),
            starts=_starts(content),
        ),
    )


def _starts(content: dict[str, NDArray[Any]]) -> StartingCells | None:
    if "starts_probability" not in content:
        return None
    columns = (content[f"starts_{name}"] for name in ("triangle", "side", "segments", "probability"))
    return StartingCells(*columns)
