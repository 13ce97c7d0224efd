"""Turns: which points of their sequences receivers take together, when some sample more often than others."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lelight.estimate.workingset import SAMPLES_AT_ONCE
from lelight.scene import IntArray
from lelight.tracing.sobol import Stretch


@dataclass(frozen=True)
class Turn:
    """Points of a sequence that some receivers take.

    Attributes
    ----------
    samples : the points
    own : (k,) int, the receivers
    share : float, of all points that these receivers take in a batch
    """

    samples: Stretch
    own: IntArray
    share: float = 1.0

    @classmethod
    def of_all(cls, samples: Stretch, receivers: int) -> Turn:
        """Have so many receivers take the same points, all of them at once."""
        return cls(samples, np.arange(receivers))

    def __len__(self) -> int:
        """Count the samples of all receivers."""
        return len(self.own) * self.samples.count


def turns(log2_samples: IntArray, doubling: int) -> Iterator[tuple[Turn, ...]]:
    """Take turns by how often receivers (r,) sample; those that come together may be worked on together.

    Parameters
    ----------
    log2_samples : (r,) int, points that a receiver's sequence starts with, as power of two; at least one is taken
    doubling : 0 for those, k for the points that double the sequences for the k-th time
    """
    together: dict[int, list[Turn]] = defaultdict(list)
    counts = np.maximum(log2_samples, 0)
    for log2_count in np.unique(counts):
        stretch = Stretch.of(int(log2_count), doubling)
        own = np.flatnonzero(counts == log2_count)
        for number, part in enumerate(stretch.parts(SAMPLES_AT_ONCE)):
            together[number].append(Turn(part, own, part.count / stretch.count))
    yield from (tuple(each) for each in together.values())
