"""What keys of the result files are called in print, with the symbols and the sense of a requirement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Sense = Literal["at least", "at most"]


@dataclass(frozen=True)
class Term:
    """Printed name and symbol of a quantity, and which side of a target is the good one."""

    name: str
    symbol: str = ""
    sense: Sense = "at least"


#: Quantities in the order in which they are printed.
TERMS: dict[str, Term] = {
    "mean_illuminance": Term("Mean illuminance", "Em"),
    "minimum_illuminance": Term("Minimum illuminance", "Emin"),
    "min_illuminance": Term("Minimum illuminance", "Emin"),
    "maximum_illuminance": Term("Maximum illuminance", "Emax", "at most"),
    "max_illuminance": Term("Maximum illuminance", "Emax", "at most"),
    "uniformity": Term("Uniformity Emin / Em", "U0"),
    "diversity": Term("Diversity Emin / Emax", "Ud"),
    "mean_cylindrical_illuminance": Term("Mean cylindrical illuminance", "Ez"),
    "modelling": Term("Modelling index", "Ez / Em"),
    "cylindrical_uniformity": Term("Uniformity of Ez", "U0 of Ez"),
    "mean_scalar_illuminance": Term("Mean spherical illuminance", "E_sr"),
    "mean_hemispherical_illuminance": Term("Mean hemispherical illuminance", "E_hs"),
    "vector_over_scalar": Term("Light vector / scalar illuminance", "|E| / E_sr"),
    "ugr": Term("Unified glare rating, from emitters", "UGR", "at most"),
    "ugr_max": Term("Largest UGR of 24 bearings", "UGR", "at most"),
    "ugr_small_sources": Term("UGR with small sources, CIE 147", "UGR", "at most"),
    "ggr": Term("Great room glare rating, CIE 147", "GGR", "at most"),
    "ugr_non_uniform": Term("UGR of non-uniform sources, CIE 232", "UGR'", "at most"),
    "gr": Term("Glare rating outdoors, CIE 112", "GR", "at most"),
    "ugr_picture": Term("Unified glare rating, from the picture", "UGR", "at most"),
    "dgp": Term("Daylight glare probability", "DGP", "at most"),
    "dgi": Term("Daylight glare index", "DGI", "at most"),
    "dgi_modified": Term("Modified daylight glare index", "DGI mod", "at most"),
    "cgi": Term("CIE glare index", "CGI", "at most"),
    "vcp": Term("Visual comfort probability", "VCP"),
    "ugp": Term("Unified glare probability", "UGP", "at most"),
    "ugp2": Term("Unified glare probability 2017", "UGP2", "at most"),
    "ugr_experimental": Term("Experimental UGR", "UGR exp", "at most"),
    "veiling_luminance": Term("Veiling luminance, Poynter", "Lv", "at most"),
    "veiling_luminance_cie": Term("Veiling luminance, CIE 146", "Lv", "at most"),
    "background_luminance": Term("Background luminance", "Lb"),
    "vertical_illuminance": Term("Vertical illuminance", "Ev"),
    "direct_vertical_illuminance": Term("Direct vertical illuminance", "Edir"),
    "indirect_vertical_illuminance": Term("Indirect vertical illuminance", "Eind"),
    "cct": Term("Correlated colour temperature", "CCT"),
    "duv": Term("Distance from the Planckian locus", "Duv"),
    "ra": Term("Colour rendering index", "Ra"),
    "r9": Term("Special colour rendering index, red", "R9"),
    "rf": Term("Colour fidelity index", "Rf"),
    "rg": Term("Colour gamut index", "Rg"),
    "melanopic_edi": Term("Melanopic equivalent daylight illuminance", "mEDI"),
    "melanopic_der": Term("Melanopic daylight efficacy ratio", "mDER"),
    "mean_surface_illuminance": Term("Mean surface illuminance", "Es"),
    "mean_room_surface_exitance": Term("Mean room surface exitance", "MRSE"),
}

STAGES: dict[str, str] = {
    "read": "Reading the scene",
    "remesh": "Remeshing",
    "pilot": "Pilot walk",
    "estimate": "Local estimation",
    "fit": "Angular fit",
    "write": "Writing",
    "total": "Total",
}

#: Settings of a run by key: printed name and unit; ``%`` stands for a fraction printed in per cent.
SETTINGS: dict[str, tuple[str, str]] = {
    "target": ("Target of the relative standard error", "%"),
    "time": ("Time budget", "s"),
    "edge": ("Edge length of the mesh", "m"),
    "preset": ("Preset", ""),
    "method": ("Method of the angular field", ""),
    "threads": ("Threads", ""),
}

ABBREVIATIONS = frozenset({"sh", "ugr", "dgp", "ies", "rgb", "edi", "der"})

VERDICTS: dict[str, str] = {"pass": "✓ pass", "fail": "✗ fail", "undecided": "○ undecided"}

GLOSSARY: tuple[tuple[str, str], ...] = (
    (
        "Illuminance E, lx",
        "Luminous flux that arrives on a surface, per area. One lux is one lumen per square metre.",
    ),
    ("Luminance L, cd/m²", "Brightness of a surface towards the eye: luminous intensity per projected area."),
    ("Em, Emin, Emax", "Mean, smallest and largest illuminance over the points of a plane's grid."),
    ("U0, Ud", "Uniformity Emin/Em and diversity Emin/Emax over the points of a plane's grid."),
    (
        "Ez",
        "Mean cylindrical illuminance: the vertical illuminance averaged over all horizontal directions. "
        "Ez/Em, the modelling index, tells how well faces and solids are shaped by the light.",
    ),
    (
        "Lb",
        "Background luminance: the indirect vertical illuminance at the eye divided by π (CIE 117).",
    ),
    (
        "UGR",
        "Unified glare rating of CIE 117 for one eye and one line of sight; steps of 3 are one class, "
        "and values below 10 are written <10.",
    ),
    ("DGP", "Daylight glare probability, from the vertical illuminance and the bright sources in view."),
    (
        "Solid angle ω, sr",
        "Size of a source as the eye sees it; the half space in front of the eye has 2π sr.",
    ),
    ("T/R, H/R", "Sideways and upward distance of a source over its distance along the line of sight."),
    ("Position index p", "Guth's weight of a source off the line of sight: 1 on it, larger away from it."),
    (
        "Standard error",
        "Standard deviation of a calculated figure over repeated runs. The figure ± two standard errors "
        "holds the exact result of the model in about 95 of 100 runs; it says nothing about how well the "
        "model matches the building.",
    ),
    (
        "Undecided",
        "The requirement lies within the error of the figure: a run with a smaller error target decides it.",
    ),
    ("Node", "A point of the refined surface mesh at which the light is calculated."),
    (
        "Chain",
        "One random walk of light through the scene; each of its reflections lights every node it sees.",
    ),
)


def term_of(key: str) -> Term:
    """Look a key up; one that is not known is printed as words."""
    return TERMS.get(key, Term(words(key)))


def words(key: str) -> str:
    """Turn a key of a file into words: underscores to spaces, abbreviations and the first letter large."""
    spaced = " ".join(
        word.upper() if word in ABBREVIATIONS else word for word in key.replace("_", " ").split()
    )
    return spaced[:1].upper() + spaced[1:]


def print_order(key: str) -> int:
    """Rank of a quantity in tables; those that are not known come last."""
    return list(TERMS).index(key) if key in TERMS else len(TERMS)


def mark(number: int) -> str:
    """Letter of the observer with this index: A to Z, then AA.

    >>> mark(0), mark(25), mark(26)
    ('A', 'Z', 'AA')
    """
    letter = chr(ord("A") + number % 26)
    return letter if number < 26 else mark(number // 26 - 1) + letter
