"""What decisions of the plan cost: factors on the time of a run, and bytes for each node.

The factors were measured by ``tests/bench_plan.py`` on a diffuse room: processor seconds less those of starting and
writing, everything else being the same. They are rough: a scene with many occluders spends more of its time on rays,
which cost the same whatever they carry.
"""

from __future__ import annotations

from dataclasses import dataclass

from lelight.spectral.bands import BANDS

#: Time of a run with so many channels over that with one.
TIME_OF_CHANNELS = {1: 1.0, 3: 1.15, BANDS: 3.1}
#: Share of the time of a grey run that one coefficient of the harmonics adds where all nodes keep it, and how much
#: more of that each further channel adds.
TIME_OF_COEFFICIENT, FURTHER_CHANNEL = 0.0022, 0.35
#: Time of a run that follows direct light only, over one that follows all.
TIME_OF_DIRECT = 0.1
#: Arrays of moments and of coefficients that are held for each node at the height of a run, and bytes of a number.
ARRAYS, MOMENTS, NUMBER = 4, 12, 8


@dataclass(frozen=True)
class Cost:
    """Estimated cost of one decision.

    Attributes
    ----------
    time : float, factor on the time of a run, 1 for the least that could be decided
    memory : float, bytes a node
    otherwise : what the other choices would cost, in words
    """

    time: float
    memory: float
    otherwise: str

    def __str__(self) -> str:
        """Say it in a few words."""
        parts = [f"time x {self.time:.2g}"] if self.time != 1.0 else []
        parts += [f"{self.memory:.0f} bytes a node"] if self.memory else []
        return "; ".join([*parts, *([self.otherwise] if self.otherwise else [])])


#: Cost of a decision that takes no work.
NOTHING = Cost(1.0, 0.0, "nothing")


def no_cost(text: str) -> Cost:
    """Cost that does not depend on the choice, or is next to nothing, in words."""
    return Cost(1.0, 0.0, text)


def channels_cost(channels: int) -> Cost:
    """Cost of carrying so many channels."""
    others = [
        f"{name} x {TIME_OF_CHANNELS[count]:.2g}, {ARRAYS * MOMENTS * NUMBER * count} bytes"
        for name, count in (("grey", 1), ("RGB", 3), ("bands", BANDS))
        if count != channels
    ]
    return Cost(TIME_OF_CHANNELS[channels], ARRAYS * MOMENTS * NUMBER * channels, "; ".join(others))


def degree_cost(degree: int, channels: int) -> Cost:
    """Cost of harmonics of a degree, if all nodes kept them; of none at all, what degree 11 would cost."""
    if degree == 0:
        other = degree_cost(11, channels)
        return Cost(1.0, 0.0, f"degree 11 at all nodes x {other.time:.2g}, {other.memory:.0f} bytes")
    coefficients = (degree + 1) ** 2
    added = TIME_OF_COEFFICIENT * coefficients * (1.0 + FURTHER_CHANNEL * (channels - 1))
    time = 1.0 + added / TIME_OF_CHANNELS[channels]
    return Cost(time, ARRAYS * NUMBER * coefficients * channels, "if all nodes kept it")


def reflected_cost() -> Cost:
    """Cost of lobes that are evaluated when a direction is asked for."""
    return Cost(1.0, 0.0, "nothing at nodes; in pictures one more ray for each that meets it")


def indirect_cost(*, on: bool) -> Cost:
    """Cost of following light beyond the first surface."""
    if on:
        return Cost(1.0, 0.0, f"direct light alone x {TIME_OF_DIRECT:.2g}")
    return Cost(TIME_OF_DIRECT, 0.0, "all light x 1")
