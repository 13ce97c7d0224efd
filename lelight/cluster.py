"""Other processes and machines: blocks of receivers spread over the workers of Dask distributed.

Workers get what all batches stand on once, chain vertices once a batch, and send back what they found; everything else
stays in the process that was started. A block does the same arithmetic wherever it is done, so the bits stay those of
one machine, as long as the processors understand the same instructions. What a lost worker had is done again by
another, or here where none is left.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from lelight.errors import ClusterError
from lelight.estimate.blocks import Batch, BlockWork, Site
from lelight.scene import IntArray
from lelight.tracing.chains import ChainVertices
from lelight.versions import versions

#: Seconds to wait for a scheduler, and for its first worker.
PATIENCE = 30.0
#: Bytes that a worker keeps from array to array.
KEPT_MEMORY = str(1 << 30)
#: Bytes of chain vertices that are sent with every block rather than once to every worker.
FEW_BYTES = 1 << 18
#: Workers of the machine itself, ``local:4``.
LOCAL = re.compile(r"local:([1-9][0-9]{0,3})")


@contextmanager
def cluster_executor(address: str, threads: int) -> Iterator[Executor]:
    """Open an executor that spreads blocks over a cluster, and leave it at the end.

    Parameters
    ----------
    address : of a Dask scheduler, such as ``tcp://host:8786`` or ``tls://host:8786``; ``local:4`` starts four here
    threads : of this process, for all that is not spread

    Raises
    ------
    ClusterError
        where Dask is not installed, no worker answers, or one runs other versions
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise ClusterError("--cluster needs Dask: pip install 'lelight[cluster]'") from error
    local = LOCAL.fullmatch(address)
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        own = _local_cluster(LocalCluster, int(local[1])) if local else None
        client = Client(own or address, timeout=PATIENCE, set_as_default=False)
        client.wait_for_workers(1, timeout=PATIENCE)
    except (OSError, ValueError, RuntimeError) as error:
        told = " ".join(str(error).split()) or type(error).__name__
        raise ClusterError(f"--cluster {address}: no worker answers ({told})") from error
    _require_same_versions(address, client)
    executor = ClusterExecutor(client, threads)
    try:
        yield executor
    finally:
        executor.shutdown(wait=False, cancel_futures=True)
        client.close(timeout=PATIENCE)
        if own is not None:
            own.close(timeout=PATIENCE)


def _local_cluster(make: Callable[..., Any], workers: int) -> Any:
    """Start workers of a thread each.

    Dask has its workers give memory back as soon as it is free, and looks 100 times a second at what they do; a block
    takes and frees large arrays all the time, so that with both it takes a fifth longer.
    """
    import dask

    environment = "distributed.nanny.pre-spawn-environ"
    chosen = {
        f"{environment}.{name}": KEPT_MEMORY for name in ("MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_")
    }
    with dask.config.set({**chosen, "distributed.worker.profile.enabled": False}):
        return make(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        )


def _require_same_versions(address: str, client: Any) -> None:
    """Refuse workers that would compute something else."""
    own = versions()
    for worker, theirs in client.run(versions).items():
        for name, version in own.items():
            if theirs.get(name) != version:
                raise ClusterError(
                    f"--cluster {address}: worker {worker} has {name} {theirs.get(name)}, here it is {version}"
                )


class ClusterExecutor(Executor):
    """Sends `BlockWork` to a cluster and has threads of this process do the rest."""

    def __init__(self, client: Any, threads: int) -> None:
        self._client = client
        self._threads = ThreadPoolExecutor(max_workers=threads)
        self._sites: dict[tuple[int, ...], tuple[Site, Any]] = {}
        self._vertices: tuple[ChainVertices | None, Any] = (None, None)
        self._open = True

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Have a function called; see `concurrent.futures.Executor`."""
        if not isinstance(fn, BlockWork):
            return self._threads.submit(fn, *args, **kwargs)
        remote = self._client.submit(
            estimate_block,
            self._site_at_workers(fn.site),
            self._vertices_at_workers(fn.vertices),
            fn.seed,
            fn.doubling,
            fn.room,
            *args,
            pure=False,
        )
        found: Future[Any] = Future()
        remote.add_done_callback(lambda done: self._arrived(done, found, fn, args))
        found.add_done_callback(lambda own: remote.cancel() if own.cancelled() else None)
        return found

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Do nothing any more; see `concurrent.futures.Executor`."""
        self._open = False
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        self._sites, self._vertices = {}, (None, None)

    def _arrived(self, remote: Any, found: Future[Any], work: BlockWork, args: tuple[Any, ...]) -> None:
        """Hand on what a worker found; a block that was lost with its worker's data, or failed, is done here."""
        if found.cancelled() or not self._open:
            return
        if remote.status == "finished":
            found.set_result(remote.result())
        else:
            self._threads.submit(_do_here, found, work, args)

    def _site_at_workers(self, site: Site) -> Any:
        """Send what batches stand on to all workers, unless they have it."""
        key = tuple(id(part) for part in vars(site).values())
        if key not in self._sites:
            self._sites = {key: (site, self._client.scatter(site, broadcast=True, hash=False))}
        return self._sites[key][1]

    def _vertices_at_workers(self, vertices: ChainVertices) -> Any:
        """Send the vertices of a batch's chains to all workers, instead of those of the batch before.

        Few go along with every block, which saves waiting for all workers to have them.
        """
        if sum(column.nbytes for column in vars(vertices).values()) <= FEW_BYTES:
            return vertices
        if self._vertices[0] is not vertices:
            self._vertices = (vertices, self._client.scatter(vertices, broadcast=True, hash=False))
        return self._vertices[1]


def estimate_block(
    site: Site, vertices: ChainVertices, seed: tuple[int, int], doubling: int, room: float, block: IntArray
) -> Batch:
    """Do a block at a worker."""
    return BlockWork(site, vertices, seed, doubling, room)(block)


def _do_here(found: Future[Any], work: BlockWork, args: tuple[Any, ...]) -> None:
    try:
        found.set_result(work(*args))
    except BaseException as error:
        found.set_exception(error)
