"""Requirements of common tasks in EN 12464-1:2021.

From memory, but for the row of office work, which a manufacturer's page prints; verify a row before it is
quoted. The first of two maintained illuminances is the required one, not the modified one.
"""

from __future__ import annotations

#: Keys of a plane's target, in the order of the columns below.
COLUMNS = (
    "mean_illuminance",
    "uniformity",
    "ra",
    "ugr",
    "mean_cylindrical_illuminance",
    "wall_illuminance",
    "ceiling_illuminance",
)

_ROWS: dict[str, tuple[float, ...]] = {
    "filing": (300, 0.40, 80, 19, 100, 100, 75),
    "writing": (500, 0.60, 80, 19, 150, 150, 100),
    "technical drawing": (750, 0.70, 80, 16, 150, 150, 100),
    "cad": (500, 0.60, 80, 19, 150, 150, 100),
    "conference": (500, 0.60, 80, 19, 150, 150, 100),
    "reception": (300, 0.60, 80, 22, 100, 100, 75),
    "archive": (200, 0.40, 80, 25, 75, 75, 50),
    "classroom": (500, 0.60, 80, 19, 150, 150, 100),
    "board": (500, 0.70, 80, 19),
    "auditorium": (500, 0.60, 80, 19, 150, 150, 50),
    "corridor": (100, 0.40, 40, 28, 50, 50, 30),
    "stairs": (100, 0.40, 40, 25, 50, 50, 30),
    "canteen": (200, 0.40, 80, 22, 75, 75, 50),
    "plant room": (200, 0.40, 60, 25, 50, 50, 30),
    "examination": (500, 0.60, 90, 19, 150, 150, 100),
    "retail": (300, 0.40, 80, 22, 75, 75, 30),
}

#: Requirements by task.
TASKS: dict[str, dict[str, float]] = {
    task: dict(zip(COLUMNS, map(float, row), strict=False)) for task, row in _ROWS.items()
}
