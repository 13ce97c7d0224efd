"""All cases with a known answer, in the order of the table."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from lelight.analytic import (
    areasource,
    cube,
    fluxbalance,
    furnace,
    phongplate,
    pointsource,
    rectangles,
    reflector,
    sobolev,
    sphere,
)
from lelight.analytic.case import Case
from lelight.scene import FloatArray

#: A family of cases; ``full`` adds the long ones and asks for half the error.
Family = Callable[[bool], Iterator[Case]]


def cases(*, full: bool = False) -> list[Case]:
    """Build every case; ``full`` adds the long ones and asks for half the error."""
    return [case for family in FAMILIES for case in family(full)]


def _finer(full: bool) -> float:
    return 0.5 if full else 1.0


def _spheres(full: bool) -> Iterator[Case]:
    for reflectance in (0.5, 0.9, 0.98, *((0.99,) if full else ())):
        yield sphere.case(reflectance, target=0.007 * _finer(full))


def _furnaces(full: bool) -> Iterator[Case]:
    for reflectance in (0.6, *((0.9,) if full else ())):
        yield furnace.nodes_case(reflectance, target=0.01 * _finer(full))
        yield furnace.corners_case(reflectance, target=0.004)


def _sobolev(full: bool) -> Iterator[Case]:
    target = 0.006 * _finer(full)
    yield sobolev.finite_case("sobolev-discs-0.5", source_height=1.0, reflectances=(0.5, 0.5), target=target)
    yield sobolev.finite_case("sobolev-discs-0.8", source_height=1.0, reflectances=(0.8, 0.8), target=target)
    yield sobolev.finite_case(
        "sobolev-offset", source_height=0.5, reflectances=(0.5, 0.8), target=0.75 * target
    )
    yield _planes(0.5, radius=20.0, radii=sobolev.RADII[:3], target=0.03)
    if full:
        yield _planes(0.5, radius=40.0, radii=sobolev.RADII, target=0.01)
        yield _planes(0.8, radius=40.0, radii=sobolev.RADII, target=0.01)
        yield sobolev.finite_case(
            "sobolev-discs-0.95", source_height=1.0, reflectances=(0.95, 0.95), target=target
        )


def _planes(rho: float, *, radius: float, radii: FloatArray, target: float) -> Case:
    return sobolev.plane_case(
        f"sobolev-planes-{rho:g}-{radius:g}",
        source_height=1.0,
        reflectances=(rho, rho),
        radius=radius,
        radii=radii,
        target=target,
    )


def _cie171(full: bool) -> Iterator[Case]:
    yield pointsource.isotropic_case()
    yield pointsource.diffuse_case()
    yield areasource.case()
    yield fluxbalance.case()
    for side in (0.5, 4.0, 500.0):
        yield reflector.horizontal_case(side)
    yield reflector.reflecting_case()
    yield reflector.screen_case()
    short = (0.5, 0.9)
    for reflectance in (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95) if full else short:
        # Light that goes round often is noisier as a whole than node by node.
        often = 0.7 if reflectance >= 0.8 else 1.0
        yield cube.case(reflectance, target=0.01 * often * _finer(full))


def _form_factors(_full: bool) -> Iterator[Case]:
    yield rectangles.parallel_case()
    yield rectangles.perpendicular_case()


def _plates(full: bool) -> Iterator[Case]:
    yield phongplate.illuminance_case(1.0, target=0.002)
    yield phongplate.illuminance_case(16.0, target=0.002)
    if full:
        # A sharper lobe costs a point of space as many more rays as it is narrower.
        yield phongplate.illuminance_case(128.0, target=0.002, looseness=3.0)
    for exponent in (1.0, 16.0, 128.0, 1000.0, *((1e4,) if full else ())):
        yield phongplate.radiance_case(exponent)


FAMILIES: tuple[Family, ...] = (_spheres, _furnaces, _sobolev, _cie171, _form_factors, _plates)
