"""Which degree of spherical harmonics a lobe asks for."""

from __future__ import annotations

from typing import Literal

from lelight.harmonics.zonal import degree_for
from lelight.scene import Material

#: How lobes are kept where somebody takes the choice from their exponent: all at nodes, or none.
Mirrors = Literal["stored", "reflected"]

#: Lobes sharper than this are not stored at nodes; the view ray is reflected when a picture is made.
LARGEST_STORED_EXPONENT = 256.0
#: Lobes blunter than this end in a kink that harmonics follow slowly; they get the degree of this exponent.
BLUNT_EXPONENT = 16.0
#: One beam is stored to a thousandth of its lobe's peak, exponents from 2 on, where this is measured (7.2e-4 at the
#: worst from 4 on; 9.1e-4 at 2); the ripple of what is left out stays above -1e-3 with it.
EPS = 1e-3
#: The largest degree that is stored, whatever is asked for.
LARGEST_DEGREE = 128


def stored_degree(material: Material, *, mirrors: Mirrors | None = None) -> int:
    """Degree of harmonics at nodes of a material: 0 where it is Lambertian or too sharp to store.

    Parameters
    ----------
    mirrors : store sharp lobes too, to the largest degree at most, or none at all
    """
    if not material.glossy or mirrors == "reflected":
        return 0
    return lobe_degree(material.exponent, sharp=mirrors == "stored")


def lobe_degree(exponent: float, *, sharp: bool = False) -> int:
    """Degree of harmonics that a lobe asks for: 0 where it is too sharp to store, unless sharp ones are stored too."""
    if exponent > LARGEST_STORED_EXPONENT and not sharp:
        return 0
    return min(degree_for(max(exponent, BLUNT_EXPONENT), eps=EPS), LARGEST_DEGREE)
