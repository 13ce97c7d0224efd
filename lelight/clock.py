"""Wall time of a run, split into stages; a run that goes on takes its earlier parts' time along."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter


class Clock:
    """Runs from when it is made.

    Attributes
    ----------
    seconds : by stage, in the order in which they ended
    """

    def __init__(self, elapsed: float = 0.0, seconds: Mapping[str, float] | None = None) -> None:
        """Start, or go on after ``elapsed`` seconds, of which ``seconds`` by stage."""
        self.seconds: dict[str, float] = dict(seconds or {})
        self.last = perf_counter()
        self.started = self.last - elapsed
        # What was spent on the stage under way, when an earlier part of the run ended.
        self._open = max(0.0, elapsed - sum(self.seconds.values()))

    @property
    def elapsed(self) -> float:
        """Seconds since the start, without those between the parts of a run."""
        return perf_counter() - self.started

    def lap(self, stage: str) -> None:
        """End a stage that began where the last one ended."""
        now = perf_counter()
        spent = now - self.last
        if stage not in self.seconds:
            spent += self._open
            self._open = 0.0
        self.seconds[stage] = self.seconds.get(stage, 0.0) + spent
        self.last = now
