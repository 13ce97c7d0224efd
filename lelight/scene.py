"""The scene as the calculation sees it: frozen values in SI units, z up.

Colours are kept as three linear Rec. 709 components; the plan decides how many channels are carried.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from lelight.luminaires import Luminaire

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

#: Luminance weights of linear Rec. 709 primaries with a D65 white (ITU-R BT.709-6, item 3.2).
LUMINANCE_WEIGHTS: FloatArray = np.array([0.2126, 0.7152, 0.0722])

EmissionSides = Literal["front", "both"]


@dataclass(frozen=True)
class Spectrum:
    """A spectral distribution, linear between its samples and zero beyond them.

    Attributes
    ----------
    name : file or CIE name it comes from
    wavelengths : (k,) float, nm, ascending
    amounts : (k,) float; reflectance, or power in any unit
    """

    name: str
    wavelengths: FloatArray
    amounts: FloatArray

    def at(self, wavelengths: FloatArray) -> FloatArray:
        """Amounts (n,) at wavelengths (n,) in nm."""
        return np.asarray(np.interp(wavelengths, self.wavelengths, self.amounts, left=0.0, right=0.0))


@dataclass(frozen=True)
class Threshold:
    """What makes a pixel part of a glare source: an absolute luminance, or a multiple of a mean.

    Attributes
    ----------
    luminance : float, cd/m², with ``absolute``; a factor with the others
    """

    luminance: float
    kind: Literal["absolute", "task", "picture"] = "absolute"


@dataclass(frozen=True)
class Outdoor:
    """What an outdoor scene declares for its glare rating.

    Attributes
    ----------
    plane : name of the measuring plane on the ground
    reflectance : float, of the ground
    """

    plane: str
    reflectance: float


@dataclass(frozen=True)
class Material:
    """Reflection and emission of a surface.

    Attributes
    ----------
    diffuse : (3,) float, albedo of the Lambertian lobe
    specular : (3,) float, ks of the modified Phong lobe ``ks (n + 2) / (2 pi) cos^n(alpha)``
    exponent : float, n of that lobe
    luminance : (3,) float, emitted luminance in cd/m², the same in every direction
    emission_sides : which sides emit; the front is where the face's vertices run anticlockwise
    origin : where the values come from, for the material table (``office.mtl:12, office.toml "floor*"``)
    reflectance_spectrum : of the Lambertian lobe; wins over ``diffuse`` where bands are carried
    emission_spectrum : of the emitted light, relative; None where no spectrum is known
    """

    name: str
    diffuse: FloatArray
    specular: FloatArray = field(default_factory=lambda: np.zeros(3))
    exponent: float = 1.0
    luminance: FloatArray = field(default_factory=lambda: np.zeros(3))
    emission_sides: EmissionSides = "front"
    origin: str = "default"
    reflectance_spectrum: Spectrum | None = None
    emission_spectrum: Spectrum | None = None

    @property
    def emits(self) -> bool:
        """True where any channel has a positive luminance."""
        return bool(np.any(self.luminance > 0))

    @property
    def glossy(self) -> bool:
        """True where the Phong lobe reflects anything."""
        return bool(np.any(self.specular > 0))


@dataclass(frozen=True)
class PointLuminaire:
    """An isotropic point source of given intensity.

    Attributes
    ----------
    position : (3,) float, m
    intensity : (3,) float, cd for each colour component, dimming and maintenance already applied
    maintenance : float, the maintenance factor that is in the intensity
    spectrum : of its light, relative; None where no spectrum is known
    """

    name: str
    position: FloatArray
    intensity: FloatArray
    maintenance: float = 1.0
    spectrum: Spectrum | None = None


@dataclass(frozen=True)
class Observer:
    """An eye: ``position`` (3,) m and unit ``direction`` (3,) of its line of sight.

    Attributes
    ----------
    task : (3,) float, m, what it works on; None where that is the line of sight
    threshold : float, cd/m², above which a pixel of its picture is a glare source; None for the usual
    """

    name: str
    position: FloatArray
    direction: FloatArray
    task: FloatArray | None = None
    threshold: Threshold | None = None


@dataclass(frozen=True)
class MeasuringPlane:
    """A rectangle on which illuminance is asked for; its normal is ``u x v``.

    Attributes
    ----------
    origin, u, v : (3,) float, m; one corner and the two edge vectors
    target : requirements by name: ``mean_illuminance`` (lx), ``uniformity``, ``ugr`` and others
    wall_band : float, m, that was taken off the rectangle at each side
    surrounding, background : float, m, widths of the bands around it that are rated, 0 for none
    """

    name: str
    origin: FloatArray
    u: FloatArray
    v: FloatArray
    target: dict[str, float] = field(default_factory=dict)
    wall_band: float = 0.0
    surrounding: float = 0.0
    background: float = 0.0

    @property
    def normal(self) -> FloatArray:
        """(3,) float, unit length."""
        cross = np.cross(self.u, self.v)
        return np.asarray(cross / np.linalg.norm(cross))


@dataclass(frozen=True)
class Scene:
    """Surfaces, light sources, eyes and planes.

    Attributes
    ----------
    vertices : (n_v, 3) float, m, z up
    triangles : (n_t, 3) int into vertices; the front sees them anticlockwise
    triangle_materials : (n_t,) int into materials
    materials : only those that a face uses
    settings : the ``[calc]`` table of the scene file
    up : axis of the input file that became z, ``"y"`` or ``"z"``
    unit : length unit of the input file
    files : SHA-256 by file name, of everything that was read
    warnings : what reading had to say
    outdoor : what an outdoor scene declares for CIE 112, None indoors
    """

    name: str
    vertices: FloatArray
    triangles: IntArray
    triangle_materials: IntArray
    materials: tuple[Material, ...]
    luminaires: tuple[Luminaire, ...] = ()
    observers: tuple[Observer, ...] = ()
    planes: tuple[MeasuringPlane, ...] = ()
    settings: dict[str, Any] = field(default_factory=dict)
    unit: str = "m"
    up: str = "z"
    path: Path | None = None
    files: dict[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    outdoor: Outdoor | None = None

    @property
    def corners(self) -> FloatArray:
        """(n_t, 3, 3) float, m: triangle, corner, coordinate."""
        return np.asarray(self.vertices[self.triangles])

    @property
    def emitting(self) -> BoolArray:
        """(n_t,) bool: triangles whose material emits."""
        emits = np.array([material.emits for material in self.materials], dtype=np.bool_)
        return np.asarray(emits[self.triangle_materials])

    @property
    def lamp_positions(self) -> FloatArray:
        """(n, 3) float, m: where the luminaires are."""
        return np.array([lamp.position for lamp in self.luminaires]).reshape(-1, 3)

    @property
    def diagonal(self) -> float:
        """Length in m of the diagonal of the bounding box of all that is used."""
        used = np.zeros(len(self.vertices), dtype=np.bool_)
        used[self.triangles] = True
        return float(np.linalg.norm(np.ptp(self.vertices[used], axis=0)))


def triangle_normals(corners: FloatArray) -> FloatArray:
    """Find the unit normals of triangles, zero where a triangle has no area.

    Parameters
    ----------
    corners : (n, 3, 3) float

    Returns
    -------
    (n, 3) float
    """
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    return np.asarray(np.divide(cross, length, out=np.zeros_like(cross), where=length > 0))


def triangle_areas(corners: FloatArray) -> FloatArray:
    """Areas (n,) in m² of triangles (n, 3, 3)."""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(0.5 * np.linalg.norm(cross, axis=1))
