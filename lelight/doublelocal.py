"""Double local estimation: the radiance that view rays bring, traced anew (equations (12), (13) and (16) of the paper).

A view ray fixes a point on a surface; the vertices of chains light it, and it reflects toward the eye by its own
kernel. Emitters are seen exactly, their images in lobes are drawn at each point, sharp lobes send the ray on to further
points. Chains, near field and direct light are those of `lelight.estimate`.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from lelight.estimate.base import BRIGHTEST_SPOT, SPOT, BaseField
from lelight.estimate.batch import estimate_batch
from lelight.estimate.blocks import Effort
from lelight.estimate.defect import with_starts
from lelight.estimate.direct import with_rough_clear_share
from lelight.estimate.pathstate import Paths
from lelight.estimate.towardeye import TowardEye
from lelight.estimate.variants import Variant
from lelight.field import RadianceField
from lelight.mesh.locate import Locator
from lelight.receivers import ILLUMINANCE, Receivers, joined, space_receivers, with_surface
from lelight.scene import FloatArray
from lelight.tracing.chains import hash_of
from lelight.viewrays import ViewRays

#: Lobes sharper than this send the view ray on; blunter ones are lit by the chains.
SHARPEST_LIT = 256.0
#: Mirrors behind mirrors that are followed; what is beyond is lost.
DEEPEST_MIRROR = 16
#: Draws for images of emitters in a lobe that chains light, as power of two.
LOG2_IMAGES = 4
#: Shadow rays that tell beforehand how much of the emitters a point sees, as power of two.
LOG2_CLEAR = 3
#: Rays estimated at once, which bounds memory, and by one thread; neither changes results.
RAYS_AT_ONCE, CHUNK = 1 << 16, 1 << 12
#: Replicates of pictures are apart from those of runs, on whose field the chains may stand.
FIRST_REPLICATE = 1 << 24
#: Parts of a seed.
VIEW, CLEAR = 31, 32


@dataclass(frozen=True)
class Unit:
    """A step of the estimate: the first points of a replicate's sequences.

    Attributes
    ----------
    effort : how many
    """

    replicate: int
    effort: Effort


@dataclass(frozen=True)
class DoubleLocal:
    """Estimates what rays see, unit by unit.

    Attributes
    ----------
    view : follows the rays
    base : field whose lack the chains carry; None where they carry all light from the emitters
    variant : how indirect light is put together
    seed : int
    executor : threads
    """

    view: ViewRays
    base: BaseField | None
    variant: Variant
    seed: int
    executor: Executor

    def radiance(
        self, origins: FloatArray, directions: FloatArray, unit: Unit, *, first: int = 0
    ) -> FloatArray:
        """One unbiased estimate (k, C) in cd/m² of what places (k, 3), m, see along unit directions (k, 3).

        Parameters
        ----------
        first : int, number of the first ray, on which with the others' the random numbers depend
        """
        parts = [np.zeros((0, self.view.world.channels))]
        for begin in range(0, len(origins), RAYS_AT_ONCE):
            own = slice(begin, begin + RAYS_AT_ONCE)
            parts.append(self._radiance(origins[own], directions[own], unit, first + begin))
        return np.concatenate(parts)

    def _radiance(self, origins: FloatArray, directions: FloatArray, unit: Unit, first: int) -> FloatArray:
        draw = int(hash_of((self.seed, VIEW, unit.replicate))) >> 8
        chunks = [slice(begin, begin + CHUNK) for begin in range(0, len(origins), CHUNK)]
        numbers = first + np.arange(len(origins))
        looked = list(
            self.executor.map(
                lambda own: self.view.look(
                    origins[own],
                    directions[own],
                    draw + numbers[own],
                    log2_images=LOG2_IMAGES,
                    log2_mirrored=0,
                ),
                chunks,
            )
        )
        places = [surface_points(self.view, seen.surfaces) for seen in looked]
        receivers = joined(places)
        start = first * (self.view.deepest + 1)
        receivers = replace(receivers, identity=start + receivers.identity)
        outgoing = np.concatenate([seen.surfaces.outgoing for seen in looked])
        reflected = self._reflected(receivers, outgoing, unit)
        ends = np.cumsum([len(each) for each in places])
        shares = np.split(reflected, ends[:-1])
        return np.concatenate(
            [seen.with_reflected(share) for seen, share in zip(looked, shares, strict=True)]
        )

    def _reflected(self, receivers: Receivers, outgoing: FloatArray, unit: Unit) -> FloatArray:
        """Radiance (s, C) that points reflect toward directions (s, 3), but for the images of emitters."""
        world = self.view.world
        if not len(receivers):
            return np.zeros((0, world.channels))
        detail = TowardEye(outgoing, int(receivers.identity[0]), world.reflectances)
        batch = estimate_batch(
            world,
            self._with_clear_share(receivers),
            effort=unit.effort,
            seed=(self.seed, FIRST_REPLICATE + unit.replicate),
            base=self.base,
            detail=detail,
            executor=self.executor,
            variant=self.variant,
        )
        kept = np.zeros((len(receivers), 1, world.channels))
        kept[receivers.degrees > 0] = batch.angular
        return detail.coefficients(
            kept,
            receivers=receivers,
            illuminance=batch.direct[:, ILLUMINANCE] + batch.indirect[:, ILLUMINANCE],
            reflectances=world.reflectances,
        )[:, 0]

    def _with_clear_share(self, receivers: Receivers) -> Receivers:
        parts = self.executor.map(
            lambda own: (
                with_rough_clear_share(
                    self.view.world, own, log2_samples=LOG2_CLEAR, seed=(self.seed, CLEAR)
                ).clear_share
            ),
            receivers.chunks(CHUNK),
        )
        return replace(receivers, clear_share=np.concatenate(list(parts)))


def surface_points(view: ViewRays, surfaces: Paths) -> Receivers:
    """Receivers at surfaces that rays have met; those whose lobe chains light ask for arrivals one by one."""
    glossy = view.world.reflectances.specular_share > 0
    return replace(
        with_surface(space_receivers(surfaces.points, surfaces.normals)),
        materials=surfaces.materials,
        degrees=(glossy[surfaces.materials] & ~view.on_mirrors(surfaces)).astype(np.int64),
    )


def traced_view(field: RadianceField, *, sharpest: float = SHARPEST_LIT) -> ViewRays:
    """Look into the scene of a field; lobes of a greater exponent than ``sharpest`` send rays on."""
    sharp = np.array([m.glossy and m.exponent > sharpest for m in field.scene.materials])
    mirrors = np.repeat(sharp[field.world.materials][:, None], 2, axis=1)
    return ViewRays.of(field.scene, field.world, mirrors=mirrors, deepest=DEEPEST_MIRROR)


def stored_base(field: RadianceField, *, seed: int, executor: Executor) -> BaseField:
    """Take the illuminance of a stored field for the base of chains, and measure what it lacks.

    Whatever the field is, the estimate on it is unbiased. Spots brighter than rays can find stay with the chains.
    """
    mesh, illuminance = field.mesh, field.values.illuminance
    seen = ~mesh.hidden
    most = BRIGHTEST_SPOT * np.average(illuminance[seen], axis=0, weights=mesh.areas[seen])
    lit = np.zeros((int(field.labels.max(initial=-1)) + 1, 2), dtype=np.bool_)
    lit[mesh.patches[seen], np.where(mesh.sides[seen] > 0, 0, 1)] = True
    base = BaseField(
        labels=field.labels,
        locator=Locator(mesh),
        illuminance=np.minimum(illuminance, most),
        lit=lit,
        diffuse=field.world.reflectances.diffuse,
        materials=field.world.materials,
        spots=bool(np.any(illuminance > SPOT * most)),
    )
    return with_starts(field.world, base, seed=seed, executor=executor)
