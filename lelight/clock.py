"""Wall time of a run, split into stages."""

from __future__ import annotations

from time import perf_counter


class Clock:
    """Runs from when it is made.

    Attributes
    ----------
    seconds : by stage, in the order in which they ended
    """

    def __init__(self) -> None:
        self.started = self.last = perf_counter()
        self.seconds: dict[str, float] = {}

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return perf_counter() - self.started

    def lap(self, stage: str) -> None:
        """End a stage that began where the last one ended."""
        now = perf_counter()
        self.seconds[stage] = now - self.last
        self.last = now
