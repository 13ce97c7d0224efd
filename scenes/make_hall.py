"""Write a library hall of 40 x 25 x 8 m with 21 753 books: hall.obj, hall.mtl, hall.toml.

    python make_hall.py [FOLDER]

The folder is the script's own where none is given. The same files come out every time. Metres, z up; the
shell is wound towards the hall, everything in it outwards; solids stand on the floor or on each other.
"""

from __future__ import annotations

import argparse
import math
import random
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

Point = tuple[float, float, float]
Polygon = Sequence[int]

LENGTH, WIDTH, HEIGHT = 40.0, 25.0, 8.0
PANEL_CENTRES_X = [2.0 + 4.0 * i for i in range(10)]
PANEL_CENTRES_Y = [2.5 + 4.0 * j for j in range(6)]
PANEL_LENGTH, PANEL_WIDTH = 1.2, 0.6

COLUMN_CENTRES = [(x, y) for x in (4.0, 20.0, 36.0) for y in (4.5, 12.5, 20.5)]
COLUMN_RADIUS, COLUMN_SIDES = 0.3, 32

CASE_CORNERS = [(x + 1.02 * i, 3.0 + 3.6 * row) for row in range(6) for x in (6.0, 22.0) for i in range(12)]
CASE_WIDTH, CASE_DEPTH, CASE_HEIGHT, BOARD = 1.0, 0.3, 2.2, 0.025
SHELF_HEIGHTS = [0.1, 0.45, 0.8, 1.15, 1.5, 1.85]

MATERIALS = """\
# Diffuse reflectances of the library hall, grey: free choices, usual values indoors.
newmtl ceiling
Kd 0.8 0.8 0.8
newmtl wall
Kd 0.6 0.6 0.6
newmtl floor
Kd 0.25 0.25 0.25
newmtl column
Kd 0.6 0.6 0.6
newmtl shelf
Kd 0.4 0.4 0.4
newmtl book_dark
Kd 0.15 0.15 0.15
newmtl book_light
Kd 0.4 0.4 0.4
newmtl panel
Kd 0.7 0.7 0.7
"""

DESCRIPTION = """\
# Library hall of 40 x 25 x 8 m, written by make_hall.py. A size test: nothing is known exactly but the lamps.
# Sixty panels of 1.2 x 0.6 m: 43.2 m2, at 4000 cd/m2 pi 4000 43.2 = 542 867 lm, 543 lm for each m2 of floor.
unit = "m"
up = "z"

[materials]
"panel" = { luminance = 4000, sides = "front" }

[[observers]]
name = "main aisle"
position = [20.0, 1.0, 1.6]
direction = [0, 1, 0]

[[observers]]
name = "between the shelves"
position = [5.0, 5.0, 1.6]
direction = [1, 0, 0]

[[planes]]
name = "reading area"
origin = [0.5, 0.5, 0.75]
u = [3, 0, 0]
v = [0, 24, 0]
target = { mean_illuminance = 200, uniformity = 0.4 }

[[planes]]
name = "book spines"
origin = [6.0, 2.9, 0.1]
u = [12, 0, 0]
v = [0, 0, 2]
"""


class Wavefront:
    """Lines of an OBJ file, with the number of vertices written so far."""

    def __init__(self, heading: str) -> None:
        self.lines = [heading]
        self._vertex_count = 0

    def begin(self, name: str) -> None:
        """Start a named object."""
        self.lines.append(f"\no {name}")

    def points(self, points: Iterable[Point]) -> int:
        """Add vertices; return the number of the first."""
        lines = [f"v {x:.3f} {y:.3f} {z:.3f}" for x, y, z in points]
        self.lines += lines
        self._vertex_count += len(lines)
        return self._vertex_count - len(lines) + 1

    def faces(self, material: str, first: int, polygons: Iterable[Polygon]) -> None:
        """Add polygons, whose corners count from the vertex ``first``."""
        self.lines.append(f"usemtl {material}")
        self.lines += ["f " + " ".join(str(first + corner) for corner in polygon) for polygon in polygons]

    def box(self, material: str, low: Point, high: Point) -> None:
        """Add a closed box along the axes."""
        corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
        self.faces(material, self.points(corners), BOX)


#: Faces of a box, outwards; bit 0 of a corner's number is x, bit 1 y, bit 2 z.
BOX = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def grid_lines(length: float, centres: Sequence[float], width: float) -> list[float]:
    """Both ends of a side and the edges of every panel along it."""
    return [0.0, *(centre + half for centre in centres for half in (-width / 2, width / 2)), length]


def lattice(columns: int, rows: int) -> Iterator[tuple[int, int, Polygon]]:
    """Cells of a grid of (columns + 1) x (rows + 1) points, x running fastest, anticlockwise from +z."""
    for row in range(rows):
        for column in range(columns):
            low = row * (columns + 1) + column
            yield column, row, (low, low + 1, low + columns + 2, low + columns + 1)


def write_shell(obj: Wavefront) -> None:
    """Floor, ceiling with flush panels, and walls: one conforming grid without T-junctions."""
    xs = grid_lines(LENGTH, PANEL_CENTRES_X, PANEL_LENGTH)
    ys = grid_lines(WIDTH, PANEL_CENTRES_Y, PANEL_WIDTH)
    cells = list(lattice(len(xs) - 1, len(ys) - 1))
    obj.begin("shell")
    floor = obj.points((x, y, 0.0) for y in ys for x in xs)
    ceiling = obj.points((x, y, HEIGHT) for y in ys for x in xs)
    obj.faces("floor", floor, [cell for _, _, cell in cells])
    obj.faces("ceiling", ceiling, [cell[::-1] for i, j, cell in cells if not (i % 2 and j % 2)])
    obj.faces("panel", ceiling, [cell[::-1] for i, j, cell in cells if i % 2 and j % 2])
    write_walls(obj, outline(xs, ys))


def outline(xs: Sequence[float], ys: Sequence[float]) -> list[tuple[float, float]]:
    """Grid points of the plan's border, anticlockwise."""
    south, east = [(x, 0.0) for x in xs[:-1]], [(LENGTH, y) for y in ys[:-1]]
    return south + east + [(LENGTH - x, WIDTH) for x in xs[:-1]] + [(0.0, y) for y in ys[:0:-1]]


def write_walls(obj: Wavefront, border: Sequence[tuple[float, float]]) -> None:
    """Upright quadrilaterals over the border of the plan, facing in."""
    count = len(border)
    foot = obj.points((x, y, z) for z in (0.0, HEIGHT) for x, y in border)
    quads = [((i + 1) % count, i, count + i, count + (i + 1) % count) for i in range(count)]
    obj.faces("wall", foot, quads)


def write_column(obj: Wavefront, x: float, y: float) -> None:
    """Write a prism that stands for a round column, from floor to ceiling."""
    angles = [2 * math.pi * i / COLUMN_SIDES for i in range(COLUMN_SIDES)]
    ring = [(x + COLUMN_RADIUS * math.cos(angle), y + COLUMN_RADIUS * math.sin(angle)) for angle in angles]
    top, axis = COLUMN_SIDES + 1, COLUMN_SIDES
    obj.begin("column")
    first = obj.points((*point, z) for z in (0.0, HEIGHT) for point in [*ring, (x, y)])
    sides = [(i, (i + 1) % COLUMN_SIDES) for i in range(COLUMN_SIDES)]
    mantle: list[Polygon] = [(i, j, top + j, top + i) for i, j in sides]
    ends: list[Polygon] = [end for i, j in sides for end in ((j, i, axis), (top + i, top + j, top + axis))]
    obj.faces("column", first, mantle + ends)


def write_bookcase(obj: Wavefront, number: int, corner: tuple[float, float], chance: random.Random) -> None:
    """Two side panels, boards between them, and a row of books on each board; open at front and back."""
    x, y = corner
    right, back = x + CASE_WIDTH, y + CASE_DEPTH
    obj.begin(f"bookcase_{number}")
    obj.box("shelf", (x, y, 0.0), (x + BOARD, back, CASE_HEIGHT))
    obj.box("shelf", (right - BOARD, y, 0.0), (right, back, CASE_HEIGHT))
    for z in SHELF_HEIGHTS:
        obj.box("shelf", (x + BOARD, y + 0.01, z), (right - BOARD, back - 0.01, z + BOARD))
        for low, high in books((x + BOARD, y + 0.01, z + BOARD), CASE_WIDTH - 2 * BOARD, chance):
            obj.box(chance.choice(("book_dark", "book_light")), low, high)


def books(corner: Point, length: float, chance: random.Random) -> Iterator[tuple[Point, Point]]:
    """Boxes that stand side by side, 2 mm apart, with their spines near the edge of the board."""
    x, y, z = corner
    end = x + length
    x += 0.002
    while True:
        thick, deep, tall = chance.uniform(0.02, 0.05), chance.uniform(0.14, 0.24), chance.uniform(0.2, 0.3)
        if x + thick > end - 0.002:
            return
        spine = y + chance.uniform(0.005, 0.02)
        yield (x, spine, z), (x + thick, spine + deep, z + tall)
        x += thick + 0.002


def hall() -> str:
    """Text of the whole OBJ file."""
    obj = Wavefront("# Library hall, written by make_hall.py. Metres, z up.\nmtllib hall.mtl")
    chance = random.Random(1)
    write_shell(obj)
    for x, y in COLUMN_CENTRES:
        write_column(obj, x, y)
    for number, corner in enumerate(CASE_CORNERS, start=1):
        write_bookcase(obj, number, corner, chance)
    return "\n".join(obj.lines) + "\n"


def write(path: Path, text: str) -> None:
    """Put the file in place whole: written beside, then renamed."""
    beside = path.with_name(path.name + ".part")
    beside.write_text(text, encoding="utf-8", newline="\n")
    beside.replace(path)


def write_hall(folder: Path) -> None:
    """Write the three files, the OBJ last, so that where it is the others are too."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (("hall.mtl", MATERIALS), ("hall.toml", DESCRIPTION), ("hall.obj", hall())):
        write(folder / name, text)


def main() -> None:
    """Read the command line and write the three files."""
    parser = argparse.ArgumentParser(description="Write hall.obj, hall.mtl and hall.toml.")
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parent)
    folder = parser.parse_args().folder
    try:
        write_hall(folder)
    except OSError as error:
        parser.exit(1, f"make_hall.py: cannot write to {folder}: {error.strerror}\n")


if __name__ == "__main__":
    main()
