"""Made-up photometric files as text, written line by line as a laboratory would, not by the program's writers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

Intensity = Callable[[float, float], float]


def lambertian(c: float, gamma: float) -> float:
    """Cosine law downwards; π lm for 1 cd at nadir."""
    return max(0.0, math.cos(math.radians(gamma)))


def uplight(c: float, gamma: float) -> float:
    return max(0.0, -math.cos(math.radians(gamma))) + 0.05 * (gamma > 90)


def spot(c: float, gamma: float) -> float:
    """A beam of 2 degrees (full width at half maximum)."""
    return math.exp(-math.log(2.0) * gamma**2)


def batwing(c: float, gamma: float) -> float:
    """Symmetric about both planes, wide across, narrow along."""
    across = math.cos(math.radians(c)) ** 2
    fall = max(0.0, math.cos(math.radians(gamma)))
    return (0.4 + 1.4 * math.sin(math.radians(gamma)) ** 2 * across) * fall


def wallwasher(c: float, gamma: float) -> float:
    """Symmetric about C0-C180 only: leans towards C0."""
    lean = math.sin(math.radians(gamma)) * math.cos(math.radians(c))
    return (1.0 + 0.8 * lean) * max(0.0, math.cos(math.radians(gamma)))


def sideways(c: float, gamma: float) -> float:
    """Symmetric about C90-C270 only."""
    return wallwasher(c - 90.0, gamma)


def skew(c: float, gamma: float) -> float:
    """Not symmetric at all."""
    turn = math.radians(c - 35.0)
    return (
        1.0
        + 0.5 * math.sin(math.radians(gamma)) * math.cos(turn)
        + 0.2 * math.sin(2 * turn) * math.sin(math.radians(gamma)) ** 2
    ) * max(0.0, math.cos(math.radians(gamma)))


#: Planes that EULUMDAT gives by symmetry indicator, for steps of 15 degrees.
LDT_PLANES = {
    0: np.arange(0, 360, 15),
    1: np.array([0]),
    2: np.arange(0, 181, 15),
    3: np.concatenate([np.arange(270, 360, 15), np.arange(0, 91, 15)]),
    4: np.arange(0, 91, 15),
}
GAMMA = np.arange(0.0, 181.0, 5.0)


def ldt(
    intensity: Intensity = lambertian,
    *,
    symmetry: int = 4,
    gamma: Sequence[float] | np.ndarray = GAMMA,
    sizes: Sequence[float] = (620, 320, 80, 600, 300, 0, 0, 0, 0),
    lamps: Sequence[Sequence[object]] = ((1, "LED", 3000, "840", "1B", 25),),
    ratio: float = 100.0,
    factor: float = 1.0,
    per_klm: float = 1000.0 / math.pi,
) -> str:
    """An EULUMDAT file; intensities are ``per_klm`` times ``intensity(c, gamma)`` in cd/klm."""
    head = [
        "lelight tests",
        "1" if symmetry == 1 else "3",
        symmetry,
        24,
        15,
        len(gamma),
        5,
        "report 7",
        "panel",
    ]
    head += ["P-600", "panel.ldt", "2020 / lab", *sizes, 100, ratio, factor, 0, len(lamps)]
    for lamp in lamps:
        head += list(lamp)
    head += [0] * 10
    body = [*range(0, 360, 15), *(f"{g:g}" for g in gamma)]
    body += [f"{per_klm * intensity(float(c), float(g)):.9g}" for c in LDT_PLANES[symmetry] for g in gamma]
    return "\r\n".join(map(str, head + body)) + "\r\n"


def ies(
    intensity: Intensity = lambertian,
    *,
    horizontal: Sequence[float] = (0.0,),
    gamma: Sequence[float] | np.ndarray = GAMMA,
    first: str = "IESNA:LM-63-2002",
    tilt: str = "TILT=NONE",
    lamps: float = 1,
    lumens: float = -1,
    multiplier: float = 1.0,
    kind: int = 1,
    unit: int = 2,
    sizes: Sequence[float] = (0.3, 0.6, 0.0),
    ballast: str = "1 1 25",
    scale: float = 3000.0 / math.pi,
) -> str:
    """An LM-63 file; intensities are ``scale`` times ``intensity(horizontal, gamma)`` in cd."""
    lines = [first] if first else []
    lines += ["[TEST] report 7", "[TESTLAB] lab", "[ISSUEDATE] 2020", "[MANUFAC] lelight tests"]
    lines += ["[LUMCAT] P-600", "[LUMINAIRE] panel", tilt]
    lines.append(
        f"{lamps:g} {lumens:g} {multiplier:g} {len(gamma)} {len(horizontal)} {kind} {unit} "
        + " ".join(f"{s:g}" for s in sizes)
    )
    lines += [ballast, " ".join(f"{g:g}" for g in gamma), " ".join(f"{h:g}" for h in horizontal)]
    lines += [" ".join(f"{scale * intensity(float(h), float(g)):.9g}" for g in gamma) for h in horizontal]
    return "\n".join(lines) + "\n"


#: Files that stand for the habits of the trade, to mutate.
CORPUS_LDT = (
    ldt(lambertian, symmetry=1, gamma=np.arange(0, 91, 15)),
    ldt(batwing, symmetry=4, gamma=np.arange(0, 181, 30)),
    ldt(wallwasher, symmetry=2, gamma=np.arange(0, 91, 30)).replace(".", ","),
    ldt(
        sideways,
        symmetry=3,
        gamma=np.arange(0, 91, 30),
        lamps=((2, "T16", 5200, "830", "1B", 62), (-1, "LED", 900, "", "", 9)),
    ),
    ldt(skew, symmetry=0, gamma=np.arange(0, 91, 45), sizes=(100, 0, 50, 90, 0, 20, 20, 20, 20)),
)
CORPUS_IES = (
    ies(lambertian, gamma=np.arange(0, 91, 15)),
    ies(batwing, horizontal=(0, 45, 90), gamma=np.arange(0, 181, 45), unit=1, sizes=(-1, -1, 0)),
    ies(skew, horizontal=range(0, 361, 60), gamma=np.arange(0, 91, 45), lamps=2, lumens=1000),
    ies(lambertian, first="", tilt="TILT=INCLUDE\n1\n3\n0 45 90\n1 0.95 0.9", gamma=np.arange(0, 91, 30)),
    ies(lambertian, horizontal=(-90, -45, 0, 45, 90), gamma=(-90, -45, 0, 45, 90), kind=2, first="IESNA91"),
)
