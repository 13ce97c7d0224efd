"""What a scene requires, decided before anything is traced, each decision with its reason."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lelight.errors import SceneError
from lelight.harmonics.zonal import beam_error, degree_for
from lelight.luminaires import PhotometricLuminaire
from lelight.scene import IntArray, Material, Scene
from lelight.spectral.bands import BANDS, is_spectral_scene

Method = Literal["sh", "grid", "sampled"]

#: Lobes sharper than this are not stored at nodes; the view ray is reflected when a picture is made.
LARGEST_STORED_EXPONENT = 256.0
#: Lobes blunter than this end in a kink that harmonics follow slowly; they get the degree of this exponent.
BLUNT_EXPONENT = 16.0
#: Colour components that differ by less than this share are the same grey.
GREY_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Decision:
    """One thing that is modelled, or left out, and why."""

    name: str
    value: str
    reason: str


@dataclass(frozen=True)
class Plan:
    """What will be computed.

    Attributes
    ----------
    channels : int, C
    method : how glossy nodes keep angular detail
    degrees : (n_materials,) int; degree of the harmonics that the material's nodes keep of arriving light, 0 for none
    decisions : in the order in which they were taken
    """

    channels: int
    method: Method
    degrees: IntArray
    decisions: tuple[Decision, ...]

    @property
    def degree(self) -> int:
        """The largest degree of any node."""
        return int(self.degrees.max(initial=0))


def make_plan(scene: Scene, *, method: Method = "sh", relightable: float | None = None) -> Plan:
    """Decide channels, angular detail, emitters and observers' needs from the scene alone.

    Parameters
    ----------
    relightable : exponent up to which all nodes keep what lobes need, whatever their own material
    """
    channels, colour = _channels(scene)
    degrees = np.array([stored_degree(material) for material in scene.materials], dtype=np.int64)
    decisions = [colour, *_angular(scene, degrees, method)]
    if relightable is not None:
        if method != "sh":
            raise SceneError(f"--relightable needs --method sh: {method} keeps what surfaces reflect")
        degrees = np.maximum(degrees, lobe_degree(relightable))
        decisions.append(_relighting(relightable))
    return Plan(channels, method, degrees, (*decisions, _emission(scene), _left_out()))


def stored_degree(material: Material) -> int:
    """Degree of harmonics at nodes of a material: 0 where it is Lambertian or too sharp to store."""
    return lobe_degree(material.exponent) if material.glossy else 0


def lobe_degree(exponent: float) -> int:
    """Degree of harmonics that a lobe is stored to: 0 where it is too sharp to store."""
    if exponent > LARGEST_STORED_EXPONENT:
        return 0
    return degree_for(max(exponent, BLUNT_EXPONENT))


def _relighting(exponent: float) -> Decision:
    return Decision(
        "light for relighting",
        f"harmonics of degree {lobe_degree(exponent)} at all nodes",
        f"any material may be given lobes of exponents up to {exponent:g} afterwards",
    )


def _channels(scene: Scene) -> tuple[int, Decision]:
    if is_spectral_scene(scene):
        return BANDS, Decision("channels", f"{BANDS} (bands of 10 nm)", "spectra are given")
    coloured = [m.name for m in scene.materials if not _grey(m)]
    coloured += [
        lamp.name for lamp in scene.luminaires if np.ptp(lamp.intensity) > _tolerance(lamp.intensity)
    ]
    if not coloured:
        return 1, Decision("channels", "1 (grey)", "all reflectances and emissions have equal components")
    named = ", ".join(coloured[:3]) + (" and others" if len(coloured) > 3 else "")
    return 3, Decision("channels", "3 (linear Rec. 709)", f"coloured: {named}")


def _grey(material: Material) -> bool:
    colours = (material.diffuse, material.specular, material.luminance)
    return all(np.ptp(colour) <= _tolerance(colour) for colour in colours)


def _tolerance(colour: np.ndarray[tuple[int], np.dtype[np.float64]]) -> float:
    return GREY_TOLERANCE * float(np.max(np.abs(colour)))


def _angular(scene: Scene, degrees: IntArray, method: Method) -> list[Decision]:
    glossy = [(m, int(d)) for m, d in zip(scene.materials, degrees, strict=True) if m.glossy]
    if not glossy:
        return [Decision("angular detail", "none", "every surface is Lambertian: one number a node is all")]
    return [_lobe_decision(material, degree, method) for material, degree in glossy]


def _lobe_decision(material: Material, degree: int, method: Method) -> Decision:
    name = f"gloss of {material.name}"
    if degree == 0:
        reason = f"exponent {material.exponent:g} is above {LARGEST_STORED_EXPONENT:g}"
        return Decision(name, "view rays are reflected when a direction is evaluated", reason)
    share = beam_error(material.exponent, degree)
    reason = f"exponent {material.exponent:g}: one beam is right to {share:.2%} of its peak"
    return Decision(name, f"harmonics of degree {degree} by method {method}", reason)


def _emission(scene: Scene) -> Decision:
    areas = sum(m.emits for m in scene.materials)
    tables = sum(isinstance(lamp, PhotometricLuminaire) for lamp in scene.luminaires)
    points = len(scene.luminaires) - tables
    return Decision(
        "emitters",
        f"{areas} luminous materials, {points} point luminaires"
        + (f", {tables} by photometric files" if tables else ""),
        "drawn by what they can give at each place; kept out of the harmonics",
    )


def _left_out() -> Decision:
    return Decision(
        "transmission, volumes, polarisation", "left out", "no material of this scene file can ask for them"
    )
