"""The keeper of a run's work: remembers what pieces of it found, and gives that back to a run that goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, wait
from time import perf_counter
from typing import TypeVar

from lelight.checkpoint.folder import CheckpointFolder
from lelight.checkpoint.records import Form, Record
from lelight.checkpoint.stop import Stop
from lelight.clock import Clock
from lelight.errors import OutputError

Item = TypeVar("Item")
Found = TypeVar("Found")

#: Seconds between two writings; half of what may be lost, so that a piece under way fits in.
INTERVAL = 5.0
#: The same as share of the time that a run has taken, and as multiple of what the last writing took.
SHARE_OF_RUN, TIMES_LAST_WRITING = 0.02, 4.0
#: Bytes of what has not been written, beyond which it is written at once.
MOST_PENDING = 1 << 27
#: Seconds between two looks at whether to stop.
ATTENTION = 0.1


class Keeper:
    """Has pieces of work done and keeps what they find; without a folder it only has them done.

    Attributes
    ----------
    stop : whether the run shall stop
    clock : of the run, going on where an earlier part of it ended
    """

    def __init__(self, folder: CheckpointFolder | None = None, *, stop: Stop | None = None) -> None:
        self.stop = stop or Stop()
        self.clock = Clock(folder.elapsed, folder.seconds) if folder else Clock()
        self._folder = folder
        self._pending: dict[str, Callable[[], Record]] = {}
        self._superseded: list[str] = []
        self._bytes: dict[str, int] = {}
        self._written = perf_counter()
        self._writing = 0.0

    def map(
        self,
        executor: Executor,
        name: str,
        function: Callable[[Item], Found],
        items: Iterable[Item],
        form: Form[Found],
    ) -> Iterator[Found]:
        """Let threads work on items, in order, but for those that an earlier part of the run has done.

        Parameters
        ----------
        name : of the work, the same for no other
        """
        listed = list(items)
        keys = [f"{name}/{number}" for number in range(len(listed))]
        under_way = {
            key: executor.submit(function, item)
            for key, item in zip(keys, listed, strict=True)
            if not self._has(key)
        }
        try:
            for key in keys:
                if key in under_way:
                    found = self.awaited(under_way.pop(key))
                    self._keep(key, found, form)
                else:
                    found = self._kept(key, form)
                yield found
        finally:
            for future in under_way.values():
                future.cancel()

    def once(self, name: str, make: Callable[[], Found], form: Form[Found]) -> Found:
        """Do a piece of work, unless an earlier part of the run has done it; pieces of its own are then forgotten."""
        if self._has(name):
            return self._kept(name, form)
        found = make()
        self._keep(name, found, form, supersedes=f"{name}/")
        return found

    def state(self, name: str, form: Form[Found]) -> Found | None:
        """Give back the state that `put` has kept under a name; None where there is none."""
        return self._kept(name, form) if self._has(name) else None

    def put(self, name: str, state: Callable[[], Record], *, supersedes: str) -> None:
        """Keep a state instead of the one before and of work that went into it, whose keys begin as told.

        Parameters
        ----------
        state : asked for when it is written, which happens within the calls of this class only
        """
        if self._folder is not None:
            self._pending = {k: v for k, v in self._pending.items() if not k.startswith(supersedes)}
            self._bytes = {k: v for k, v in self._bytes.items() if not k.startswith(supersedes)}
            self._pending[name] = state
            self._superseded.append(supersedes)
            self._write_when_due()

    def awaited(self, future: Future[Found]) -> Found:
        """Wait for a piece of work, and look now and then whether to stop."""
        while not future.done():
            self.stop.check()
            wait([future], timeout=ATTENTION)
        self.stop.check()
        return future.result()

    def flush(self) -> None:
        """Write what has not been written."""
        if self._folder is None or not self._pending:
            return
        begun = perf_counter()
        records = {key: record() for key, record in self._pending.items()}
        try:
            self._folder.write(records, elapsed=self.clock.elapsed, seconds=self.clock.seconds)
        except OutputError as error:
            intact = f"; {self._remark(self._folder)}" if self._folder.holds_anything else ""
            raise OutputError(f"{error}{intact}") from error
        for prefix in self._superseded:
            self._folder.drop(prefix)
        self._pending, self._superseded, self._bytes = {}, [], {}
        self.stop.remark = self._remark(self._folder)
        self._written = perf_counter()
        self._writing = self._written - begun

    @staticmethod
    def _remark(folder: CheckpointFolder) -> str:
        return f"what was done is kept in {folder.path}, --resume goes on"

    def _keep(self, key: str, found: Found, form: Form[Found], *, supersedes: str | None = None) -> None:
        if self._folder is None:
            return
        record = form.pack(found)
        self._bytes[key] = sum(array.nbytes for array in record.arrays.values())
        if supersedes is not None:
            self.put(key, lambda: record, supersedes=supersedes)
        else:
            self._pending[key] = lambda: record
            self._write_when_due()

    def _write_when_due(self) -> None:
        interval = max(INTERVAL, SHARE_OF_RUN * self.clock.elapsed, TIMES_LAST_WRITING * self._writing)
        if perf_counter() - self._written >= interval or sum(self._bytes.values()) > MOST_PENDING:
            self.flush()

    def _has(self, key: str) -> bool:
        return self._folder is not None and key in self._folder

    def _kept(self, key: str, form: Form[Found]) -> Found:
        if self._folder is None:
            raise KeyError(key)
        return self._folder.unpacked(key, form)
