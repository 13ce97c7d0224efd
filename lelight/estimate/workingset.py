"""What a block of receivers takes of memory while it is worked on, and how many receivers fit at once.

Receivers do not depend on each other, so a block may be worked on in pieces of any size: its bits stay the same.
"""

from __future__ import annotations

from lelight.estimate.lighttree import TREE_FROM, room_for
from lelight.estimate.local import VERTEX_CHUNK
from lelight.estimate.thinning import vertices_asked
from lelight.receivers import Receivers

#: Samples that a receiver takes at once; a batch's sums depend on it.
SAMPLES_AT_ONCE = 512
#: Bytes of a sample of the near field and of direct light, without channels and for each of them; of a pair of
#: receiver and chain vertex; and of a light that arrives where angular distributions are kept. Measured.
NEAR_SAMPLE, NEAR_SAMPLE_CHANNEL = 360, 90
DIRECT_SAMPLE, DIRECT_SAMPLE_CHANNEL = 120, 20
PAIR, ARRIVAL, ARRIVAL_CHANNEL = 120, 150, 40
#: Fewest receivers at once: with less, calls cost more than what they do.
FEWEST = 16


def bytes_a_receiver(log2_direct: int, log2_near: int, *, vertices: int, channels: int, kept: int) -> float:
    """Bytes that one receiver of a block takes while it is worked on.

    Parameters
    ----------
    log2_direct, log2_near : samples of the receiver that takes most, as powers of two
    vertices : of all chains
    kept : numbers kept of the angular distribution, 0 for none
    """
    near, direct = 2.0 ** max(log2_near, 0), 2.0 ** max(log2_direct, 0)
    working = max(
        min(near, SAMPLES_AT_ONCE) * (NEAR_SAMPLE + NEAR_SAMPLE_CHANNEL * channels),
        min(direct, SAMPLES_AT_ONCE) * (DIRECT_SAMPLE + DIRECT_SAMPLE_CHANNEL * channels),
        _pairs_at_once(vertices) * PAIR,
    )
    if kept:
        working += (vertices + near) * (ARRIVAL + ARRIVAL_CHANNEL * channels) + 2 * 8 * kept * channels
    return working


def _pairs_at_once(vertices: int) -> int:
    """Count the pairs of a receiver that are worked on together."""
    if vertices < TREE_FROM:
        return min(vertices, VERTEX_CHUNK)
    return room_for(vertices_asked(vertices, by_tree=True))


def receivers_at_once(
    receivers: Receivers,
    room: float,
    *,
    log2_direct: int,
    log2_near: int,
    vertices: int,
    channels: int,
    kept: int,
) -> int:
    """How many receivers of a block may be worked on together in ``room`` bytes.

    Parameters
    ----------
    log2_direct, log2_near : samples of a receiver without doublings of its own, as powers of two
    """
    own = bytes_a_receiver(
        log2_direct + int(receivers.direct_doublings.max(initial=0)),
        log2_near + int(receivers.near_doublings.max(initial=0)),
        vertices=vertices,
        channels=channels,
        kept=kept,
    )
    return max(FEWEST, int(min(room / own, len(receivers))))
