"""The luminous opening as LM-63 codes it: by the signs of width, length and height.

A negative size is a diameter. Length lies along the zero plane (C0), width across it (C90), height is vertical.

====================  ================  =================
shape                 2002 and 2019     1986 to 1995
====================  ================  =================
point                 0, 0, 0           0, 0, 0
rectangle, sides      w, l, 0 or h      w, l, 0 or h
circle, cylinder      -d, -d, 0 or h    -d, 0, 0 or h
ellipse, cylinder     -w, -l, 0 or h    -w, l, h; w, -l, h
sphere                -d, -d, -d        -d, 0, -d
ellipsoid             -w, -l, -h        -w, l, -h; w, -l, -h
tube along C0         -w, l, -h         0, l, -d
tube along C90        w, -l, -h         w, 0, -d
upright disc          -w, 0, -h
====================  ================  =================

Each edition's files are found with the codes of the other; where both have a meaning the edition decides.
"""

from __future__ import annotations

from lelight.photometry.opening import Opening


def opening_of(width: float, length: float, height: float, *, edition: int) -> Opening:
    """Tell the opening from signed sizes in m (LM-63-2002, table 1; LM-63-1995, clause on luminous dimensions)."""
    across, along, tall = abs(width), abs(length), abs(height)
    sides = (tall,) * 4
    if height < 0:
        return _body(width, length, tall, edition=edition)
    if width == 0 and length == 0 and height == 0:
        return Opening()
    if width < 0 or length < 0:
        # One diameter given: a circle. Two: an ellipse.
        return Opening("ellipse", along or across, across or along, sides)
    return Opening("rectangle", along, across, sides)


def _body(width: float, length: float, tall: float, *, edition: int) -> Opening:
    """Shapes with a negative height: spheres, lying tubes, upright discs."""
    across, along, sides = abs(width), abs(length), (tall,) * 4
    early = edition < 2002
    if width > 0 and length > 0:
        return Opening("rectangle", along, across, sides)
    if length > 0 and not (early and width < 0):
        return Opening("tube_c0", along, across or tall, sides)
    if width > 0 and not (early and length < 0):
        return Opening("tube_c90", along or tall, across, sides)
    if early and length == 0 and width < 0:
        return Opening("ellipsoid", across, across, sides)
    return Opening("ellipsoid", along, across, sides)


def signed_sizes(opening: Opening) -> tuple[float, float, float] | None:
    """Width, length and height in m as LM-63-2002 signs them; None where it has no code for the shape."""
    along, across, tall = opening.along_c0, opening.along_c90, opening.height
    if len(set(opening.heights)) > 1:
        return None
    return {
        "point": (0.0, 0.0, 0.0),
        "rectangle": (across, along, tall),
        "ellipse": (-across, -along, tall),
        "ellipsoid": (-across, -along, -tall),
        "tube_c0": (-across, along, -tall),
        "tube_c90": (across, -along, -tall),
    }[opening.shape]
