"""Sobolev's problem: a point source between two parallel diffuse planes, h = 2 m apart.

Lower plane z = 0, upper plane z = h, isotropic source of 1 cd at height z1 over the lower. Either plane lights
the other through the kernel K(r) = h² / (pi (h² + r²)²): E1 = E01 + rho2 K * E2, E2 = E02 + rho1 K * E1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import j0, k1

from lelight.analytic.case import Case, at_probes
from lelight.analytic.solids import disc, lamp, matt, probe, scene
from lelight.scene import FloatArray

HEIGHT = 2.0
#: m from the foot of the source.
RADII = np.array([0.0, 1.0, 2.0, 5.0])


def direct(height: float, radii: FloatArray) -> FloatArray:
    """Illuminance (n,) in lx at distances (n,) from the foot of 1 cd at ``height`` m."""
    return np.asarray(height / (radii**2 + height**2) ** 1.5)


def infinite_planes(
    radii: FloatArray, *, source_height: float, reflectances: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Exact illuminance (n,) in lx at radii (n,) on the lower and the upper of two infinite planes.

    In Hankel space the convolutions are products: K has the transform k h K1(k h) (K1: modified Bessel function of
    the second kind), direct light 2 pi exp(-k z). The direct term stays in closed form; the rest is
    integrated over k by Gauss-Legendre panels that shrink towards k = 0, where the transform has a term k² ln k,
    and are at most a quarter period of J0(k r) wide.
    """
    z = (source_height, HEIGHT - source_height)
    lower = [_reflected(float(r), z[0], z[1], reflectances) for r in radii]
    upper = [_reflected(float(r), z[1], z[0], reflectances[::-1]) for r in radii]
    return direct(z[0], radii) + lower, direct(z[1], radii) + upper


def _reflected(radius: float, own: float, other: float, reflectances: tuple[float, float]) -> float:
    """Reflected light on the plane that lies ``own`` m from the source."""
    k, weight = _hankel_rule(radius)
    swap = k * HEIGHT * k1(k * HEIGHT)
    mine, theirs = reflectances
    series = theirs * swap * (np.exp(-k * other) + mine * swap * np.exp(-k * own))
    return float(np.sum(weight * k * j0(k * radius) * series / (1.0 - mine * theirs * swap**2)))


def _hankel_rule(radius: float) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights on 0 < k < 25, where the integrand has fallen to exp(-50)."""
    step = min(0.25, math.pi / (2.0 * max(radius, 1.0)))
    edges = np.concatenate([step * 2.0 ** -np.arange(40.0, 0.0, -1.0), np.arange(step, 25.0, step)])
    x, w = np.polynomial.legendre.leggauss(12)
    half = 0.5 * np.diff(edges)[:, None]
    nodes = edges[:-1, None] + half * (x + 1.0)
    return nodes.ravel(), np.broadcast_to(half * w, nodes.shape).ravel()


def discs(
    radii: FloatArray,
    *,
    source_height: float,
    reflectances: tuple[float, float],
    radius: float,
    nodes_per_metre: int = 20,
) -> tuple[FloatArray, FloatArray]:
    """Exact illuminance (n,) in lx at radii (n,) on two coaxial discs of radius ``radius`` m.

    Nyström's method: the two integral equations at the nodes of Gauss-Legendre's rule in r, the kernel integrated
    over the azimuth in closed form, 2 h² a (a² - b²)^(-3/2), a = h² + r² + s², b = 2 r s.
    """
    count = math.ceil(nodes_per_metre * radius)
    x, w = np.polynomial.legendre.leggauss(count)
    s, w = radius * (x + 1.0) / 2.0, w * radius / 2.0
    heights = (source_height, HEIGHT - source_height)
    swap = _ring_kernel(s[:, None], s) * (w * s)
    lower, upper = reflectances
    system = np.block([[np.eye(count), -upper * swap], [-lower * swap, np.eye(count)]])
    solved = np.linalg.solve(system, np.concatenate([direct(z, s) for z in heights])).reshape(2, count)
    onto = _ring_kernel(radii[:, None], s) * (w * s)
    return (
        direct(heights[0], radii) + upper * onto @ solved[1],
        direct(heights[1], radii) + lower * onto @ solved[0],
    )


def _ring_kernel(r: FloatArray, s: FloatArray) -> FloatArray:
    """Illuminance at r for each lm/m² of a ring at s of the other disc, per m of s, without its factor s."""
    a, b = HEIGHT**2 + r**2 + s**2, 2.0 * r * s
    return np.asarray(2.0 * HEIGHT**2 * a / (a * a - b * b) ** 1.5)


def finite_case(
    name: str, *, source_height: float, reflectances: tuple[float, float], target: float, radius: float = 10.0
) -> Case:
    """Two discs, exactly."""
    exact = np.array(discs(RADII, source_height=source_height, reflectances=reflectances, radius=radius))
    return _case(
        name,
        f"discs of R = {radius:g} m, source at {source_height:g} m",
        "integral equations on the discs, solved by Nyström's method",
        _Problem(source_height, reflectances, radius),
        radii=RADII,
        exact=exact,
        allowance=np.zeros_like(exact),
        target=target,
    )


def plane_case(
    name: str,
    *,
    source_height: float,
    reflectances: tuple[float, float],
    radius: float,
    radii: FloatArray,
    target: float,
) -> Case:
    """Two discs so large that they stand for infinite planes; what they lack is allowed for."""
    exact = np.array(infinite_planes(radii, source_height=source_height, reflectances=reflectances))
    cut = discs(radii, source_height=source_height, reflectances=reflectances, radius=radius)
    return _case(
        name,
        f"infinite planes, source at {source_height:g} m (traced: R = {radius:g} m)",
        "closed form in Hankel space; what planes beyond R would add is allowed for",
        _Problem(source_height, reflectances, radius),
        radii=radii,
        exact=exact,
        allowance=np.abs(exact - np.array(cut)),
        target=target,
    )


@dataclass(frozen=True)
class _Problem:
    source_height: float
    reflectances: tuple[float, float]
    radius: float

    @property
    def symmetric(self) -> bool:
        """Whether both planes have the same light."""
        return self.source_height == 0.5 * HEIGHT and self.reflectances[0] == self.reflectances[1]


def _case(
    name: str,
    what: str,
    basis: str,
    problem: _Problem,
    *,
    radii: FloatArray,
    exact: FloatArray,
    allowance: FloatArray,
    target: float,
) -> Case:
    """Points at ``radii`` on the lower disc, and on the upper where the two differ; exact values (2, n)."""
    sides = ((0.0, 1.0, "lower"), (HEIGHT, -1.0, "upper"))[: 1 if problem.symmetric else 2]
    places = [(f"{side}, r = {r:g} m", (r, 0.0, z), (0, 0, up)) for z, up, side in sides for r in radii]
    rho = " and ".join(f"{each:g}" for each in dict.fromkeys(problem.reflectances))
    made = scene(
        name,
        disc(problem.radius, 0.0, matt("lower", problem.reflectances[0])),
        disc(problem.radius, HEIGHT, matt("upper", problem.reflectances[1])),
        luminaires=[lamp((0, 0, problem.source_height), 1.0)],
        planes=[probe(*place) for place in places],
    )
    shown = slice(0, len(sides))
    return Case(
        name=name,
        group="Sobolev's problem",
        title=f"reflectance {rho}; {what}",
        basis=basis,
        scene=made,
        edge=0.5 * problem.radius,
        target=target,
        tolerance=0.01,
        precision=0.003,
        read=at_probes(
            [label for label, _, _ in places], exact[shown].ravel(), allowance=allowance[shown].ravel()
        ),
        # Light falls off within metres of the source: chains from it need no mesh that follows.
        estimator="emitters",
    )
