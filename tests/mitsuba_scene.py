"""A scene in Mitsuba 3: illuminance of places and radiance along rays, by path tracing with next-event estimation.

Mitsuba has no normalised Phong lobe, so one is written here, with the model of lelight's materials:
kd/pi + ks (n + 2)/(2 pi) cos^n about the mirror direction. Needs the wheel ``mitsuba`` and LLVM's library.
"""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

from lelight.scene import FloatArray, Scene  # noqa: E402

#: How far places are off their surface, in m.
LIFT = 1e-4


class Phong(mi.BSDF):
    """Lambertian plus normalised Phong lobe, one-sided; both drawn by their share of the reflectance."""

    def __init__(self, props: mi.Properties) -> None:
        mi.BSDF.__init__(self, props)
        self.kd, self.ks, self.n = (mi.Float(props[name]) for name in ("kd", "ks", "n"))
        self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide]
        self.m_flags = self.m_components[0]

    def _mirror(self, wi: mi.Vector3f) -> mi.Vector3f:
        return mi.Vector3f(-wi.x, -wi.y, wi.z)

    def _share(self) -> mi.Float:
        return self.kd / dr.maximum(self.kd + self.ks, 1e-9)

    def eval(self, ctx, si, wo, active=True):
        """Reflect: kernel times cosine."""
        alpha = dr.maximum(dr.dot(self._mirror(si.wi), wo), 0.0)
        lobe = self.ks * (self.n + 2.0) * dr.inv_two_pi * dr.power(alpha, self.n)
        value = (self.kd * dr.inv_pi + lobe) * wo.z
        return mi.Color3f(dr.select((si.wi.z > 0) & (wo.z > 0) & active, value, 0.0))

    def pdf(self, ctx, si, wo, active=True):
        """Density in solid angle with which `sample` draws ``wo``."""
        alpha = dr.maximum(dr.dot(self._mirror(si.wi), wo), 0.0)
        share = self._share()
        value = share * dr.inv_pi * wo.z
        value += (1.0 - share) * (self.n + 1.0) * dr.inv_two_pi * dr.power(alpha, self.n)
        return dr.select((si.wi.z > 0) & (wo.z > 0) & active, value, 0.0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        """Draw a direction by one of the two lobes."""
        diffuse = mi.warp.square_to_cosine_hemisphere(sample2)
        cos_alpha = dr.power(1.0 - sample2.x, 1.0 / (self.n + 1.0))
        sin_alpha = dr.sqrt(dr.maximum(1.0 - cos_alpha * cos_alpha, 0.0))
        turn = 2.0 * dr.pi * sample2.y
        local = mi.Vector3f(sin_alpha * dr.cos(turn), sin_alpha * dr.sin(turn), cos_alpha)
        glossy = mi.Frame3f(self._mirror(si.wi)).to_world(local)
        wo = dr.select(sample1 < self._share(), diffuse, glossy)
        drawn = mi.BSDFSample3f()
        drawn.wo, drawn.eta = wo, 1.0
        drawn.sampled_type, drawn.sampled_component = mi.UInt32(+self.m_flags), 0
        drawn.pdf = self.pdf(ctx, si, wo, active)
        good = active & (drawn.pdf > 0)
        return drawn, dr.select(good, self.eval(ctx, si, wo, active) / drawn.pdf, 0.0)

    def eval_pdf(self, ctx, si, wo, active=True):
        """Both at once."""
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    def to_string(self):
        """Name itself."""
        return "Phong"


mi.register_bsdf("lelight_phong", Phong)


def mitsuba_scene(scene: Scene) -> mi.Scene:
    """Build a grey scene of triangles in Mitsuba; radiance there is luminance here."""
    parts: dict[str, object] = {"type": "scene"}
    for number, material in enumerate(scene.materials):
        own = np.flatnonzero(scene.triangle_materials == number)
        if not len(own):
            continue
        props = {
            "type": "lelight_phong",
            "kd": float(material.diffuse[0]),
            "ks": float(material.specular[0]),
            "n": float(material.exponent),
        }
        bsdf = mi.load_dict({"type": "twosided", "bsdf": props})
        properties = mi.Properties()
        properties["mesh_bsdf"] = bsdf
        if material.emits:
            properties["emitter"] = mi.load_dict(
                {"type": "area", "radiance": {"type": "rgb", "value": [float(material.luminance[0])] * 3}}
            )
        corners = scene.corners[own].reshape(-1, 3)
        mesh = mi.Mesh(f"part{number}", len(corners), len(own), props=properties)
        values = mi.traverse(mesh)
        values["vertex_positions"] = corners.astype(np.float32).ravel()
        values["faces"] = np.arange(len(corners), dtype=np.uint32)
        values.update()
        parts[f"part{number}"] = mesh
    return mi.load_dict(parts)


def illuminance_by_mitsuba(
    scene: mi.Scene, points: FloatArray, normals: FloatArray, *, paths: int, seed: int
) -> FloatArray:
    """One estimate (k,) in lx: a lamp point and a path of any length for each of so many samples a place."""
    count = len(points)
    sampler = mi.load_dict({"type": "independent", "sample_count": 1})
    sampler.seed(seed, count * paths)
    index = dr.arange(mi.UInt32, count * paths) // paths
    place = dr.gather(mi.Point3f, mi.Point3f((points + LIFT * normals).T), index)
    normal = dr.gather(mi.Vector3f, mi.Vector3f(normals.T), index)
    at = dr.zeros(mi.SurfaceInteraction3f)
    at.p, at.n = place, mi.Normal3f(normal)
    lamp, weight = scene.sample_emitter_direction(at, sampler.next_2d(), True)
    direct = weight.x * dr.maximum(dr.dot(lamp.d, normal), 0.0)
    local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
    ray = mi.RayDifferential3f(mi.Ray3f(place, mi.Frame3f(normal).to_world(local)))
    integrator = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 5})
    light, _, _ = integrator.sample(scene, sampler, ray)
    # Lamps that the path meets at once were drawn already; hiding them would hide what they reflect, too.
    met = scene.ray_intersect(ray)
    each = direct + dr.pi * (light.x - met.emitter(scene).eval(met).x)
    return np.asarray(each).reshape(count, paths).mean(axis=1)


def radiance_by_mitsuba(
    scene: mi.Scene, origins: FloatArray, directions: FloatArray, *, paths: int, seed: int
) -> FloatArray:
    """One estimate (k,) in cd/m² of what places (k, 3) see along unit directions (k, 3)."""
    count = len(origins)
    sampler = mi.load_dict({"type": "independent", "sample_count": 1})
    sampler.seed(seed, count * paths)
    index = dr.arange(mi.UInt32, count * paths) // paths
    place = dr.gather(mi.Point3f, mi.Point3f(origins.T), index)
    along = dr.gather(mi.Vector3f, mi.Vector3f(directions.T), index)
    integrator = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 5})
    light, _, _ = integrator.sample(scene, sampler, mi.RayDifferential3f(mi.Ray3f(place, along)))
    return np.asarray(light.x).reshape(count, paths).mean(axis=1)
