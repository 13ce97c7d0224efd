"""Memory that a run may take, what it will take, and how much of that a block of receivers may.

Blocks are worked on in pieces of any size without a change of bits; what stays, nodes times their angular detail, does
not shrink, and a run in which that does not fit is refused before it begins.
"""

from __future__ import annotations

import os
from pathlib import Path

from lelight.errors import SceneError
from lelight.estimate.base import log2_rays_for
from lelight.estimate.guide import sides_for
from lelight.harmonics.indices import terms

#: Share of the free memory that a run takes at the most, where nothing was asked for.
SHARE_OF_FREE = 0.7
#: Bytes at rest: program, libraries and a scene of some thousand triangles.
AT_REST = 5.5e8
#: Bytes of a triangle of the scene.
OF_TRIANGLE = 1_000.0
#: Bytes of a node of the base field while that is solved, before the run is at its height; of each of its rays, which
#: are there twice while they are put together; of each cell of its guide.
OF_BASE_NODE, OF_BASE_RAY, OF_CELL = 850.0, 56.0, 13.0
#: Bytes of a receiver at the height of a run, and arrays of angular detail, of 8 bytes a number, that exist at once.
OF_RECEIVER, ANGULAR_ARRAYS = 1_250.0, 6.0
#: Bytes that a worker's block needs at least.
LEAST_ROOM = 2.0e7
#: Where Linux tells how much memory is free, and what a control group may take.
MEMINFO = Path("/proc/meminfo")
GROUP_LIMITS = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))


def free_memory() -> float:
    """Bytes that are free, or may be freed, and that this process may take."""
    return min(_free_of_machine(), *(_limit(path) for path in GROUP_LIMITS))


def _free_of_machine() -> float:
    try:
        lines = dict(line.split(":", 1) for line in MEMINFO.read_text().splitlines())
        return 1024.0 * float(lines["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))


def _limit(path: Path) -> float:
    """Bytes of a control group, without limit where there is none."""
    try:
        return float(path.read_text())
    except (OSError, ValueError):
        return float("inf")


def allowed_memory(asked: float | None) -> float:
    """Bytes that a run may take: what was asked for, or a share of what is free."""
    return asked if asked is not None else SHARE_OF_FREE * free_memory()


def memory_at_rest(
    receivers: float,
    detailed: float,
    *,
    degree: int,
    channels: int,
    triangles: float = 0,
    base_nodes: float = 0,
) -> float:
    """Bytes of a run without the blocks under way.

    Parameters
    ----------
    receivers, detailed : how many there are, and how many of them keep angular detail
    degree : of that detail
    triangles, base_nodes : of the scene; of the base field
    """
    detail = 8.0 * ANGULAR_ARRAYS * terms(degree) * channels
    at_height = OF_RECEIVER * receivers + detail * detailed
    return AT_REST + OF_TRIANGLE * triangles + max(at_height, _of_base(base_nodes))


def _of_base(nodes: float) -> float:
    """Bytes of a base field while it is solved: few nodes have more rays and finer guides each."""
    log2_rays = log2_rays_for(nodes)
    return nodes * (OF_BASE_NODE + OF_BASE_RAY * 2.0**log2_rays + OF_CELL * sides_for(log2_rays) ** 2)


def room_of_blocks(allowed: float, at_rest: float, workers: int) -> float:
    """Bytes that each block under way may take of what is left."""
    return max((allowed - at_rest) / workers, LEAST_ROOM)


def require_fitting(
    name: str,
    receivers: int,
    detailed: int,
    *,
    degree: int,
    channels: int,
    edge: float,
    allowed: float,
    triangles: int = 0,
    base_nodes: int = 0,
) -> float:
    """Bytes at rest of a run, if they fit into what is allowed.

    Parameters
    ----------
    name : of the scene
    edge : float, m, of its mesh

    Raises
    ------
    SceneError
        where they do not, with the numbers and with what would fit
    """
    needed = memory_at_rest(
        receivers, detailed, degree=degree, channels=channels, triangles=triangles, base_nodes=base_nodes
    )
    fixed = AT_REST + OF_TRIANGLE * triangles
    if needed + LEAST_ROOM <= allowed:
        return needed
    what = f"{receivers} places"
    if detailed:
        what += f", {detailed} of them with harmonics of degree {degree},"
    own = needed - fixed
    left = allowed - fixed - LEAST_ROOM
    text = f"{name}: {what} take {_told(needed + LEAST_ROOM)} of memory, {_told(allowed)} are allowed; "
    if left <= 0:
        raise SceneError(f"{text}at least {_told(fixed + LEAST_ROOM)} are needed: raise --memory")
    if _of_base(base_nodes) > left:
        # So many nodes of a base are what the scene's own triangles ask for, at any edge.
        raise SceneError(f"{text}raise --memory")
    # The places of a surface grow with the inverse square of the edge.
    raise SceneError(f"{text}--edge {edge * (own / left) ** 0.5:.2g} would fit, or raise --memory")


def _told(size: float) -> str:
    return f"{size / 1e9:.2g} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"
