"""The luminous opening as LM-63 codes it: by the signs of width, length and height.

A negative size is a diameter. The editions of 1986 to 1995 write zero where that of 2002 repeats a diameter;
both are understood. Length lies along the zero plane (C0), width across it (C90), height is vertical.
"""

from __future__ import annotations

from lelight.photometry.opening import Opening


def opening_of(width: float, length: float, height: float) -> Opening:
    """Tell the opening from signed sizes in m (LM-63-2002, table 1; LM-63-1995, clause on luminous dimensions)."""
    across, along, tall = abs(width), abs(length), abs(height)
    if height < 0:
        return _body(width, length, across, along, tall)
    sides = (tall,) * 4
    if width == 0 and length == 0 and height == 0:
        return Opening()
    if width < 0 or length < 0:
        # One diameter given: a circle. Two: an ellipse.
        return Opening("ellipse", along or across, across or along, sides)
    return Opening("rectangle", along, across, sides)


def _body(width: float, length: float, across: float, along: float, tall: float) -> Opening:
    """Shapes with a negative height: spheres, lying tubes, upright discs."""
    sides = (tall,) * 4
    if width > 0 and length > 0:
        return Opening("rectangle", along, across, sides)
    if length > 0:
        return Opening("tube_c0", along, across or tall, sides)
    if width > 0:
        return Opening("tube_c90", along or tall, across, sides)
    if width < 0 and length < 0:
        return Opening("ellipsoid", along, across, sides)
    if width < 0 and across == tall and length == 0:
        return Opening("ellipsoid", 0.0, across, sides)
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
