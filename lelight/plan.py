"""What a scene requires, decided before light is estimated: each decision with its reason and its cost.

Decisions are rules on what the scene contains and what of it light reaches. `Forced` overrides each of them, to
prove that what was left out would have changed nothing, or where somebody knows better.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lelight.errors import SceneError
from lelight.harmonics.zonal import beam_error
from lelight.luminaires import Luminaire, PhotometricLuminaire
from lelight.plancost import NOTHING, Cost, channels_cost, degree_cost, indirect_cost, no_cost, reflected_cost
from lelight.scene import BoolArray, FloatArray, IntArray, Material, Scene
from lelight.spectral.bands import BANDS, is_spectral_scene
from lelight.storeddegree import LARGEST_STORED_EXPONENT, Mirrors, lobe_degree, stored_degree

Method = Literal["sh", "grid", "sampled"]
Colour = Literal["grey", "rgb", "bands"]
Angular = Literal["seen", "all"]
Sides = Literal["lit", "both"]
Lamps = Literal["shining", "all"]

CHANNELS: dict[Colour, int] = {"grey": 1, "rgb": 3, "bands": BANDS}
WORDS = {1: "1 (grey)", 3: "3 (linear Rec. 709)", BANDS: f"{BANDS} (bands of 10 nm)"}
#: Colour components that differ by less than this share are the same grey.
GREY_TOLERANCE = 1e-6
#: Reason of a decision that nobody derived.
ASKED = "asked for in [calc]"


@dataclass(frozen=True)
class Forced:
    """Decisions that the user takes instead of the rules; None leaves them to the rules.

    Attributes
    ----------
    colour : channels that are carried
    degree : of the harmonics at every node that light reaches, 0 for none; at glossy ones with ``angular`` "seen"
    angular : which of the nodes that could keep angular detail do
    relightable : exponent up to which all nodes keep what lobes need, whatever their own material
    mirrors : whether sharp lobes are stored at nodes, or all lobes reflect the view ray
    sides : which sides of patches carry nodes
    indirect : whether reflected light is estimated
    residual : whether paths bring what the bounded kernel of the chains leaves out
    emitters : whether luminaires without flux stay
    pictures : whether observers take pictures and are rated
    """

    colour: Colour | None = None
    degree: int | None = None
    angular: Angular | None = None
    relightable: float | None = None
    mirrors: Mirrors | None = None
    sides: Sides | None = None
    indirect: bool | None = None
    residual: bool | None = None
    emitters: Lamps | None = None
    pictures: bool | None = None


@dataclass(frozen=True)
class Decision:
    """One thing that is modelled, or left out, why, and what that is estimated to cost."""

    name: str
    value: str
    reason: str
    cost: Cost = NOTHING


@dataclass(frozen=True)
class Plan:
    """What will be computed.

    Attributes
    ----------
    channels : int, C
    method : how glossy nodes keep angular detail
    degrees : (n_materials,) int; degree of the harmonics that the material's nodes keep of arriving light, 0 for none
    lobes : (n_materials,) int; degree to which the material's lobe reflects them, at most as much
    indirect, residual : whether light is reflected at all, and whether paths bring what chains leave out
    angular, sides : which nodes keep angular detail, which sides carry nodes
    decisions : in the order in which they were taken
    """

    channels: int
    method: Method
    degrees: IntArray
    lobes: IntArray
    indirect: bool
    residual: bool
    angular: Angular
    sides: Sides
    decisions: tuple[Decision, ...]

    @property
    def degree(self) -> int:
        """The largest degree of any node."""
        return int(self.degrees.max(initial=0))


def make_plan(
    scene: Scene, *, method: Method = "sh", forced: Forced | None = None, reached: BoolArray | None = None
) -> Plan:
    """Decide channels, angular detail, emitters and what is reflected.

    Parameters
    ----------
    reached : (n_materials,) bool, materials that light reaches; all of them where that is not known yet
    """
    forced = forced or Forced()
    reached = np.ones(len(scene.materials), dtype=np.bool_) if reached is None else reached
    channels, colour = _channels(scene, reached, forced)
    indirect, reflection = _indirect(scene, reached, forced)
    residual, near = _residual(indirect, forced)
    lobes = np.array(
        [
            _degree(material, forced) if lit and indirect else 0
            for material, lit in zip(scene.materials, reached, strict=True)
        ],
        dtype=np.int64,
    )
    degrees, relighting = _relightable(lobes, reached, method, forced)
    angular, kept = _kept(scene, degrees, forced)
    decisions = (
        colour,
        reflection,
        near,
        *_lobes(scene, reached, lobes, channels, method, forced),
        *relighting,
        *kept,
        _emission(scene),
        _outputs(scene, forced),
        _left_out(),
    )
    sides = forced.sides or "lit"
    return Plan(channels, method, degrees, lobes, indirect, residual, angular, sides, decisions)


def is_dark(lamp: Luminaire) -> bool:
    """Say whether a luminaire gives no light, as where it is dimmed to 0."""
    return not np.any(lamp.intensity > 0)


def _channels(scene: Scene, reached: BoolArray, forced: Forced) -> tuple[int, Decision]:
    """Carry what the emissions and the reflectances that light reaches differ in."""
    if forced.colour is not None:
        count = CHANNELS[forced.colour]
        return count, Decision("channels", WORDS[count], ASKED, channels_cost(count))
    if is_spectral_scene(scene):
        return BANDS, Decision("channels", WORDS[BANDS], "spectra are given", channels_cost(BANDS))
    pairs = list(zip(scene.materials, reached, strict=True))
    coloured = [m.name for m, lit in pairs if not _grey(m, reflecting=bool(lit))]
    coloured += [lamp.name for lamp in scene.luminaires if not _is_grey(lamp.intensity)]
    if coloured:
        return 3, Decision("channels", WORDS[3], f"coloured: {_listed(coloured)}", channels_cost(3))
    unseen = [m.name for m, lit in pairs if not lit and not _grey(m, reflecting=True)]
    reason = "all reflectances and emissions have equal components"
    if unseen:
        reason = f"all that light reaches has equal components; it does not reach {_listed(unseen)}"
    return 1, Decision("channels", WORDS[1], reason, channels_cost(1))


def _listed(names: list[str]) -> str:
    return ", ".join(names[:3]) + (" and others" if len(names) > 3 else "")


def _grey(material: Material, *, reflecting: bool) -> bool:
    colours = (material.diffuse, material.specular) if reflecting else ()
    return all(_is_grey(colour) for colour in (*colours, material.luminance))


def _is_grey(colour: FloatArray) -> bool:
    return bool(np.ptp(colour) <= GREY_TOLERANCE * float(np.max(np.abs(colour))))


def _indirect(scene: Scene, reached: BoolArray, forced: Forced) -> tuple[bool, Decision]:
    """Follow light beyond the first surface only where something reflects it."""
    name, on, off = "indirect light", "chains from what a first field lacks", "left out"
    if forced.indirect is not None:
        cost = indirect_cost(on=forced.indirect)
        return forced.indirect, Decision(name, on if forced.indirect else off, ASKED, cost)
    reflecting = [
        m.name
        for m, lit in zip(scene.materials, reached, strict=True)
        if lit and (np.any(m.diffuse > 0) or m.glossy)
    ]
    if not reflecting:
        reason = "nothing that light reaches reflects: direct light is all"
        return False, Decision(name, off, reason, indirect_cost(on=False))
    return True, Decision(name, on, f"reflecting: {_listed(reflecting)}", indirect_cost(on=True))


def _residual(indirect: bool, forced: Forced) -> tuple[bool, Decision]:
    name, on = "residual paths", "where the kernel exceeds its bound"
    if not indirect:
        return False, Decision(name, "left out", "no light is reflected", no_cost("one ray a sample"))
    if forced.residual is not None:
        value = on if forced.residual else "left out"
        return forced.residual, Decision(name, value, ASKED, no_cost("one ray a sample and few paths"))
    reason = "chains light nearer places with a bounded kernel, paths from the node bring the rest"
    return True, Decision(name, on, reason, no_cost("little: paths go on from near surfaces only"))


def _degree(material: Material, forced: Forced) -> int:
    if forced.degree is None:
        return stored_degree(material, mirrors=forced.mirrors)
    return forced.degree if material.glossy or forced.angular != "seen" else 0


def _lobes(
    scene: Scene, reached: BoolArray, degrees: IntArray, channels: int, method: Method, forced: Forced
) -> list[Decision]:
    """Tell degree by degree what angular detail is for."""
    told = [
        _lobe_decision(material, int(degree), bool(lit), channels, method, forced)
        for material, degree, lit in zip(scene.materials, degrees, reached, strict=True)
        if material.glossy or degree > 0
    ]
    if told:
        return told
    reason = "every surface is Lambertian: one number a node is all"
    return [Decision("angular detail", "none", reason, degree_cost(0, channels))]


def _lobe_decision(
    material: Material, degree: int, lit: bool, channels: int, method: Method, forced: Forced
) -> Decision:
    name = f"gloss of {material.name}"
    if degree:
        share = beam_error(material.exponent, degree)
        reason = f"exponent {material.exponent:g}: one beam is right to {share:.2%} of its peak"
        if forced.degree is not None or forced.mirrors == "stored":
            reason = ASKED
        value = f"harmonics of degree {degree} by method {method}"
        return Decision(name, value, reason, degree_cost(degree, channels))
    if not lit:
        return Decision(name, "left out", "light does not reach it", degree_cost(0, channels))
    reason = f"exponent {material.exponent:g} is above {LARGEST_STORED_EXPONENT:g}"
    if (
        forced.degree is not None
        or forced.mirrors is not None
        or material.exponent <= LARGEST_STORED_EXPONENT
    ):
        reason = ASKED
    value = "view rays are reflected when a direction is evaluated"
    return Decision(name, value, reason, reflected_cost())


def _relightable(
    lobes: IntArray, reached: BoolArray, method: Method, forced: Forced
) -> tuple[IntArray, list[Decision]]:
    """Keep more of the arriving light than the materials need, for others to come."""
    exponent = forced.relightable
    if exponent is None:
        return lobes, []
    if method != "sh":
        raise SceneError(f"--relightable needs --method sh: {method} keeps what surfaces reflect")
    degree = lobe_degree(exponent)
    value = f"harmonics of degree {degree} at all nodes"
    reason = f"any material may be given lobes of exponents up to {exponent:g} afterwards"
    return np.where(reached, np.maximum(lobes, degree), 0), [Decision("light for relighting", value, reason)]


def _kept(scene: Scene, degrees: IntArray, forced: Forced) -> tuple[Angular, list[Decision]]:
    """Keep angular detail where somebody may look at it; where nobody was named, everywhere."""
    if not degrees.any():
        return "all", []
    name = "nodes with angular detail"
    if forced.angular is not None:
        return forced.angular, [Decision(name, forced.angular, ASKED)]
    if forced.degree is not None:
        return "all", [Decision(name, "all", "their degree is asked for in [calc]")]
    if forced.relightable is not None:
        return "all", [Decision(name, "all", "any may be relit")]
    if not scene.observers:
        return "all", [Decision(name, "all", "no observer says from where it will be looked at")]
    return "seen", []


def _emission(scene: Scene) -> Decision:
    areas = sum(m.emits for m in scene.materials)
    tables = sum(isinstance(lamp, PhotometricLuminaire) for lamp in scene.luminaires)
    points = len(scene.luminaires) - tables
    return Decision(
        "emitters",
        f"{areas} luminous materials, {points} point luminaires"
        + (f", {tables} by photometric files" if tables else ""),
        "drawn by what they can give at each place; kept out of the harmonics",
        no_cost("the choice among them, in proportion to their number"),
    )


def _outputs(scene: Scene, forced: Forced) -> Decision:
    eyes, planes = len(scene.observers), len(scene.planes)
    pictures = forced.pictures is not False and eyes > 0
    value = f"nodes, {planes} planes, {eyes} eyes, {eyes if pictures else 0} pictures"
    reason = ASKED if forced.pictures is not None else "the scene file names them"
    return Decision("outputs", value, reason, no_cost("a picture as much as its pixels"))


def _left_out() -> Decision:
    reason = "no material of this scene file can ask for them"
    return Decision("transmission, volumes, polarisation", "left out", reason)
