"""The plainest path tracer there is, to hold lelight against: embree, NumPy, and of lelight the scene only.

Every direction is drawn by the cosine, half of them by the lobe where a material has a sharp one, every lamp
point by area, every path ends by roulette. It is slow and hard to get wrong, and shares no code with what it tests.
"""

from __future__ import annotations

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from lelight.scene import FloatArray, Scene

#: Rays start this far off their surface, in m, and shadow rays end as far off theirs.
LIFT = 2e-5
#: Exponents above this are sampled.
SHARP = 20.0


class PathTracer:
    """Unbiased estimates, one a path, of illuminance and radiance in a scene of a few metres."""

    def __init__(self, scene: Scene, *, seed: int) -> None:
        self.scene, self.rng = scene, np.random.default_rng(seed)
        self.corners = scene.corners
        cross = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        self.area = np.linalg.norm(cross, axis=1) / 2
        self.normals = cross / (2 * self.area[:, None])
        table = {
            k: np.array([getattr(m, k) for m in scene.materials])
            for k in ("diffuse", "specular", "luminance")
        }
        of = scene.triangle_materials
        self.kd, self.ks, self.emitted = table["diffuse"][of], table["specular"][of], table["luminance"][of]
        self.exponent = np.array([m.exponent for m in scene.materials])[of]
        assert not any(m.emits and m.emission_sides == "both" for m in scene.materials)
        self.lamps = np.flatnonzero(self.emitted.max(axis=1) > 0)
        self.embree = EmbreeScene(robust=True)
        TriangleMesh(self.embree, self.corners.astype(np.float32))

    def illuminance(self, points: FloatArray, normals: FloatArray, *, paths: int) -> FloatArray:
        """Estimates (k, paths, 3) in lx at surface points (k, 3) with normals (k, 3)."""
        points, normals = np.repeat(points, paths, axis=0), np.repeat(normals, paths, axis=0)
        lamps, toward = self._lamp_light(points, normals)
        direct = lamps * np.einsum("kx,kx->k", toward, normals)[:, None]
        gathered = np.pi * self._incoming(points, normals, self._cosine(normals), emission=False)
        return (direct + gathered).reshape(-1, paths, 3)

    def radiance(self, origins: FloatArray, directions: FloatArray, *, paths: int) -> FloatArray:
        """Estimates (k, paths, 3) in cd/m² of what free points (k, 3) see along unit directions (k, 3)."""
        origins, directions = np.repeat(origins, paths, axis=0), np.repeat(directions, paths, axis=0)
        return self._incoming(origins, np.zeros_like(origins), directions, emission=True).reshape(
            -1, paths, 3
        )

    def _incoming(
        self, points: FloatArray, normals: FloatArray, directions: FloatArray, *, emission: bool
    ) -> FloatArray:
        """Radiance that arrives at points against directions; of lamps themselves only where asked for."""
        light, weight = np.zeros_like(points), np.ones_like(points)
        path = np.arange(len(points))
        while len(path):
            triangle, distance = self._closest(points + LIFT * normals, directions)
            met = triangle >= 0
            path, weight, triangle = path[met], weight[met], triangle[met]
            points = (points + LIFT * normals + distance[:, None] * directions)[met]
            back = -directions[met]
            side = np.sign(np.einsum("kx,kx->k", back, self.normals[triangle]))
            normals = side[:, None] * self.normals[triangle]
            if emission:
                light[path] += weight * self.emitted[triangle] * (side > 0)[:, None]
                emission = False
            lamps, toward = self._lamp_light(points, normals)
            cosine = np.einsum("kx,kx->k", toward, normals)[:, None]
            light[path] += weight * lamps * cosine * self._brdf(triangle, normals, back, toward)
            directions, over_density = self._onward(triangle, normals, back)
            weight = weight * over_density[:, None] * self._brdf(triangle, normals, back, directions)
            survival = np.clip(weight.max(axis=1), 0.0, 0.95)
            alive = self.rng.random(len(path)) < survival
            path, points, normals, directions = path[alive], points[alive], normals[alive], directions[alive]
            weight = weight[alive] / survival[alive, None]
        return light

    def _onward(
        self, triangle: FloatArray, normals: FloatArray, back: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Directions (k, 3) to go on in, and cosine over density: half by the lobe where it is sharp."""
        directions = self._cosine(normals)
        n, sharp = self.exponent[triangle], (self.exponent > SHARP)[triangle]
        if not sharp.any():
            return directions, np.full(len(triangle), np.pi)
        mirror = 2 * np.einsum("kx,kx->k", back, normals)[:, None] * normals - back
        by_lobe = sharp & (self.rng.random(len(n)) < 0.5)
        across = self.rng.normal(size=normals.shape)
        across -= np.einsum("kx,kx->k", across, mirror)[:, None] * mirror
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        cos_alpha = self.rng.random(len(n)) ** (1 / (n + 1))
        lobe = cos_alpha[:, None] * mirror + np.sqrt(1 - cos_alpha**2)[:, None] * across
        directions = np.where(by_lobe[:, None], lobe, directions)
        cosine = np.maximum(np.einsum("kx,kx->k", directions, normals), 0.0)
        alpha = np.maximum(np.einsum("kx,kx->k", directions, mirror), 0.0)
        density = np.where(
            sharp, 0.5 * cosine / np.pi + 0.5 * (n + 1) / (2 * np.pi) * alpha**n, cosine / np.pi
        )
        return directions, np.divide(cosine, density, out=np.zeros(len(n)), where=density > 0)

    def _brdf(
        self, triangle: FloatArray, normals: FloatArray, back: FloatArray, toward: FloatArray
    ) -> FloatArray:
        """Diffuse and modified Phong reflection (Lafortune & Willems 1994), 1/sr."""
        mirror = 2 * np.einsum("kx,kx->k", back, normals)[:, None] * normals - back
        cosine = np.maximum(np.einsum("kx,kx->k", mirror, toward), 0.0)
        lobe = (self.exponent[triangle] + 2) / (2 * np.pi) * cosine ** self.exponent[triangle]
        return self.kd[triangle] / np.pi + self.ks[triangle] * lobe[:, None]

    def _lamp_light(self, points: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Radiance times solid angle (k, 3) of one lamp point each, drawn by area, and the unit way there."""
        share = self.area[self.lamps] / self.area[self.lamps].sum()
        lamp = self.rng.choice(self.lamps, size=len(points), p=share)
        weights = self.rng.dirichlet(np.ones(3), size=len(points))
        target = np.einsum("kc,kcx->kx", weights, self.corners[lamp]) + LIFT * self.normals[lamp]
        way = target - (points + LIFT * normals)
        distance = np.linalg.norm(way, axis=1)
        toward = way / distance[:, None]
        there = -np.einsum("kx,kx->k", toward, self.normals[lamp])
        here = np.einsum("kx,kx->k", toward, normals)
        hidden = self._closest(points + LIFT * normals, toward)[1] < distance * (1 - 1e-5)
        light = self.area[self.lamps].sum() * np.maximum(there, 0) / distance**2 * (here > 0) * ~hidden
        return self.emitted[lamp] * light[:, None], toward

    def _cosine(self, normals: FloatArray) -> FloatArray:
        """Directions by the cosine: the normal plus a point of the unit sphere."""
        sphere = self.rng.normal(size=normals.shape)
        way = normals + sphere / np.linalg.norm(sphere, axis=1, keepdims=True)
        return np.asarray(way / np.linalg.norm(way, axis=1, keepdims=True))

    def _closest(self, origins: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        found = self.embree.run(origins.astype(np.float32), directions.astype(np.float32), output=True)
        return found["primID"].astype(np.int64), found["tfar"].astype(np.float64)
