"""A picture by double local estimation: there after the first chain, better with each, with its standard error.

While the first replicate is not whole the picture is that of its first chains, by powers of two, for which its
sequence is balanced. Then all replicates have equal weight: their mean is the picture, their spread its error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import count

import numpy as np

from lelight.camera import Camera, as_picture, stratified_offsets
from lelight.channels import luminance_weighted
from lelight.doublelocal import DoubleLocal, Unit, surface_points
from lelight.estimate.blocks import Effort
from lelight.estimate.effort import choose_effort
from lelight.estimate.pathstate import meet
from lelight.estimate.replicates import LEAST_REPLICATES, ErrorReached, error_reached
from lelight.estimate.variants import VARIANTS
from lelight.scene import FloatArray

#: View rays on which the effort is tried out.
TRIAL_RAYS = 2048
#: Replicates that an effort is shared out over.
REPLICATES = 16
#: A unit for which less than this share of its own time is left is not begun.
ROOM = 0.5


@dataclass(frozen=True)
class Exposure:
    """How a picture is taken.

    Attributes
    ----------
    width, height : int, pixels
    samples : int, rays a pixel; the same in all replicates
    """

    camera: Camera
    width: int
    height: int
    samples: int


@dataclass
class Sums:
    """What replicates have found so far at k pixels; grows by `add`.

    Attributes
    ----------
    mean, squares : (k,) float, mean luminance in cd/m², and sum of squared differences from it (Welford 1962)
    count : int, whole replicates
    preview : (k,) float, by a part of the first replicate; None as soon as that is whole
    chains : int, in all
    """

    mean: FloatArray
    squares: FloatArray
    count: int = 0
    preview: FloatArray | None = None
    chains: int = 0

    def add(self, luminance: FloatArray) -> None:
        """Add a whole replicate."""
        self.count += 1
        off = luminance - self.mean
        self.mean += off / self.count
        self.squares += off * (luminance - self.mean)
        self.preview = None

    @property
    def luminance(self) -> FloatArray:
        """(k,) float, cd/m²: the picture so far."""
        return self.mean if self.preview is None else self.preview

    @property
    def std_error(self) -> FloatArray | None:
        """(k,) float, cd/m²; None before there are two replicates."""
        if self.count < 2:
            return None
        return np.sqrt(self.squares / (self.count * (self.count - 1)))


@dataclass(frozen=True)
class Taken:
    """A picture as far as it has come.

    Attributes
    ----------
    luminance : (h, w) float, cd/m²; nan where no pixel is, and zero where the estimate is below
    std_error : (h, w) float, likewise; None before there are two replicates
    error : of the picture by solid angle, relative to luminance or 5 % of its mean; None likewise
    chains, replicates : int
    """

    luminance: FloatArray
    std_error: FloatArray | None
    error: ErrorReached | None
    chains: int
    replicates: int

    def meets(self, target: float) -> bool:
        """Tell whether the root mean square of the error is within a target, and known well enough."""
        enough = self.replicates >= LEAST_REPLICATES and self.error is not None
        return bool(enough and self.error is not None and self.error.rms <= target)


@dataclass
class Exposing:
    """Takes a picture unit by unit.

    Attributes
    ----------
    effort : of a whole replicate
    """

    estimate: DoubleLocal
    exposure: Exposure
    effort: Effort
    sums: Sums = field(init=False)

    def __post_init__(self) -> None:
        pixels = int(self.exposure.camera.mask(self.exposure.width, self.exposure.height).sum())
        self.sums = Sums(np.zeros(pixels), np.zeros(pixels))

    def run(self, *, target: float | None, time: float | None, clock: Callable[[], float]) -> Iterator[Taken]:
        """Yield the picture after every unit until the target or the time is reached; without either, for ever.

        Parameters
        ----------
        target : relative standard error of the picture, root mean square
        time : seconds
        clock : seconds since the command began
        """
        for unit in units(self.effort):
            began = clock()
            self._take(unit)
            taken = self.taken()
            yield taken
            if target is not None and taken.meets(target):
                return
            if time is not None and clock() + ROOM * (clock() - began) >= time:
                return

    def first_nodes(self, nodes: int) -> FloatArray:
        """Picture (h, w) in cd/m² by the first nodes of one chain from the emitters, and nothing else but direct light.

        It is the one with which `run` starts where chains carry all light.
        """
        only = replace(VARIANTS["clamped"], nodes=nodes)
        first = next(units(self.effort))
        return self._laid_out(self._luminance(replace(self.estimate, base=None, variant=only), first))

    def taken(self) -> Taken:
        """Lay the picture out as it is now."""
        sums, error = self.sums, None
        std_error = sums.std_error
        if std_error is not None:
            angles = self.exposure.camera.solid_angles(self.exposure.width, self.exposure.height)
            inside = self.exposure.camera.mask(self.exposure.width, self.exposure.height)
            error = error_reached(sums.luminance, std_error, areas=angles[inside])
        return Taken(
            self._laid_out(sums.luminance),
            None if std_error is None else self._laid_out(std_error),
            error,
            sums.chains,
            sums.count,
        )

    def _take(self, unit: Unit) -> None:
        found, sums = self._luminance(self.estimate, unit), self.sums
        chains = 2**unit.effort.log2_chains
        if unit.effort == self.effort:
            sums.add(found)
            sums.chains = sums.count * chains
        else:
            sums.preview, sums.chains = found, chains

    def _luminance(self, estimate: DoubleLocal, unit: Unit) -> FloatArray:
        """Luminance (k,) in cd/m² by one unit, the mean of the rays of each pixel."""
        exposure = self.exposure
        offsets = stratified_offsets(exposure.samples)
        total = np.zeros_like(self.sums.mean)
        for number, (x, y) in enumerate(offsets):
            origins, directions = exposure.camera.rays(
                exposure.width, exposure.height, offset=(float(x), float(y))
            )
            seen = estimate.radiance(origins, directions, unit, first=number * len(origins))
            total += luminance_weighted(seen)
        return total / len(offsets)

    def _laid_out(self, pixels: FloatArray) -> FloatArray:
        return as_picture(
            np.maximum(pixels, 0.0), self.exposure.camera.mask(self.exposure.width, self.exposure.height)
        )


def units(effort: Effort) -> Iterator[Unit]:
    """Yield units without end: first parts of the first replicate, from one chain on, then whole replicates."""
    for halvings in range(effort.log2_chains, 0, -1):
        part = replace(
            effort,
            log2_chains=effort.log2_chains - halvings,
            log2_direct=max(0, effort.log2_direct - halvings),
            log2_near=max(0, effort.log2_near - halvings),
        )
        yield Unit(0, part)
    yield from (Unit(replicate, effort) for replicate in count())


def picture_effort(
    estimate: DoubleLocal, exposure: Exposure, *, target: float, most_rays: float = np.inf
) -> Effort:
    """Find what a replicate of a picture should do, by trials on some of its rays.

    Parameters
    ----------
    most_rays : rays that a replicate may take at the most
    """
    world = estimate.view.world
    origins, directions = exposure.camera.rays(exposure.width, exposure.height)
    chosen = np.linspace(0, len(origins) - 1, min(TRIAL_RAYS, len(origins))).astype(np.int64)
    met, _ = meet(world, chosen, origins[chosen], directions[chosen], np.ones((len(chosen), world.channels)))
    receivers = surface_points(estimate.view, met)
    receivers = replace(receivers, degrees=np.zeros_like(receivers.degrees))
    share = len(receivers) / (len(origins) * exposure.samples)
    effort, _ = choose_effort(
        world,
        receivers,
        base=estimate.base,
        areas=np.ones(len(receivers)),
        target=target,
        most_rays=most_rays * share,
        batches=REPLICATES,
        seed=estimate.seed,
        executor=estimate.executor,
        variant=estimate.variant,
    )
    # The rays of a pixel share chains, but each draws direct light and near field of its own.
    shared = round(math.log2(exposure.samples))
    return replace(
        effort,
        log2_direct=max(0, effort.log2_direct - shared),
        log2_near=max(0, effort.log2_near - shared),
    )
