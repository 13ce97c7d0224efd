"""Plan of a scene's luminaires as SVG: where each hangs, its opening, and where C0 and the light point."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from lelight.luminaires import Luminaire, PhotometricLuminaire
from lelight.scene import FloatArray, Scene, triangle_normals
from lelight.writing.files import write_text

#: Longest side of the drawing in units, and its margin.
SIDE, MARGIN = 800.0, 60.0
#: Length of an arrow as a share of the scene's larger side.
ARROW = 0.06
#: Least sine of the angle between two faces whose common edge is drawn.
CREASE = 0.2
#: Most edges of the scene that are drawn.
MOST_EDGES = 20_000

_HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}"
 viewBox="0 0 {width:.0f} {height:.0f}">
<style>
.scene {{ stroke: #bbb; stroke-width: 0.7; }}
.opening {{ fill: #ffd54a; stroke: #7a5c00; stroke-width: 1; }}
.c0 {{ stroke: #c62828; stroke-width: 1.6; fill: #c62828; }}
.aim {{ stroke: #1565c0; stroke-width: 1.6; fill: #1565c0; stroke-dasharray: 4 2; }}
text {{ font: 11px sans-serif; fill: #222; }}
</style>
<rect width="100%" height="100%" fill="white"/>
"""


class _Sheet:
    """Scene metres to drawing units, y upwards."""

    def __init__(self, low: FloatArray, high: FloatArray) -> None:
        self.low, self.high = low, high
        self.scale = SIDE / max(float((high - low).max()), 1e-9)
        self.length = ARROW * float((high - low).max())
        self.width = self.scale * float(high[0] - low[0]) + 2 * MARGIN
        self.height = self.scale * float(high[1] - low[1]) + 2 * MARGIN + 40

    def at(self, point: FloatArray) -> tuple[float, float]:
        x = MARGIN + self.scale * float(point[0] - self.low[0])
        y = MARGIN + self.scale * float(self.high[1] - point[1])
        return x, y

    def line(self, start: FloatArray, end: FloatArray, kind: str) -> str:
        (x1, y1), (x2, y2) = self.at(start), self.at(end)
        return f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'

    def arrow(self, start: FloatArray, direction: FloatArray, kind: str) -> str:
        """Draw an arrow along the plan's part of a direction; a direction along the view is a dot."""
        flat = np.array([direction[0], direction[1], 0.0])
        x, y = self.at(start)
        if np.linalg.norm(flat) < 0.02:
            return f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="2"/>'
        tip = start + self.length * flat
        back = flat / np.linalg.norm(flat)
        side = np.array([-back[1], back[0], 0.0])
        barb = 0.25 * self.length
        corners = [tip, tip - barb * back + 0.5 * barb * side, tip - barb * back - 0.5 * barb * side]
        head = " ".join(f"{a:.1f},{b:.1f}" for a, b in map(self.at, corners))
        return self.line(start, tip, kind) + f'<polygon class="{kind}" points="{head}"/>'


def write_layout(path: Path, scene: Scene) -> None:
    """Draw the plan, seen from above, x to the right and y up."""
    used = scene.vertices[np.unique(scene.triangles)]
    places = np.array([lamp.position for lamp in scene.luminaires]).reshape(-1, 3)
    everything = np.concatenate([used, places])
    sheet = _Sheet(everything.min(axis=0), everything.max(axis=0))
    parts = [_HEAD.format(width=sheet.width, height=sheet.height)]
    parts += [sheet.line(start, end, "scene") for start, end in _edges(scene)]
    for lamp in scene.luminaires:
        parts += _drawn(sheet, lamp)
    parts += _legend(sheet)
    write_text(path, "\n".join(parts) + "\n</svg>\n")


def _edges(scene: Scene) -> FloatArray:
    """Edges (k, 2, 3) in m at which a surface ends or turns."""
    sides = np.concatenate([scene.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    owner = np.tile(np.arange(len(scene.triangles)), 3)
    points = np.round(scene.vertices / max(scene.diagonal * 1e-7, 1e-12)).astype(np.int64)
    _, welded = np.unique(points, axis=0, return_inverse=True)
    keys = np.sort(welded.reshape(-1)[sides], axis=1)
    _, first, inverse, count = np.unique(
        keys, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    normals = triangle_normals(scene.corners)
    order = np.argsort(inverse.reshape(-1), kind="stable")
    starts = np.cumsum(count) - count
    one, other = owner[order[starts]], owner[order[starts + count - 1]]
    turn = np.linalg.norm(np.cross(normals[one], normals[other]), axis=1)
    kept = first[(count != 2) | (turn > CREASE)][:MOST_EDGES]
    return np.asarray(scene.vertices[sides[kept]])


def _drawn(sheet: _Sheet, lamp: Luminaire) -> list[str]:
    x, y = sheet.at(lamp.position)
    label = _label(sheet, lamp)
    if not isinstance(lamp, PhotometricLuminaire):
        return [f'<circle class="opening" cx="{x:.1f}" cy="{y:.1f}" r="4"/>', label]
    outline = " ".join(f"{a:.1f},{b:.1f}" for a, b in map(sheet.at, opening_outline(lamp)))
    return [
        f'<polygon class="opening" points="{outline}"/>',
        sheet.arrow(lamp.position, lamp.axes[0], "c0"),
        sheet.arrow(lamp.position, lamp.aim, "aim"),
        label,
    ]


def _label(sheet: _Sheet, lamp: Luminaire) -> str:
    """Name beside the luminaire, below whatever its arrows point at."""
    x, y = sheet.at(lamp.position)
    drop = 0.0
    if isinstance(lamp, PhotometricLuminaire):
        low = min(float(corner[1]) for corner in opening_outline(lamp))
        low = min(low, float(lamp.position[1] + sheet.length * min(lamp.axes[0][1], lamp.aim[1], 0.0)))
        drop = sheet.scale * (float(lamp.position[1]) - low)
    name = escape(_legible(lamp.name))
    return f'<text x="{x:.1f}" y="{y + drop + 14:.1f}" text-anchor="middle">{name}</text>'


def _legible(name: str) -> str:
    """Name without characters that XML cannot hold."""
    return "".join(letter if letter.isprintable() else "?" for letter in name)[:60]


def opening_outline(lamp: PhotometricLuminaire) -> FloatArray:
    """Corners (n, 3) in m of an opening's largest section; a point's is a small square for the eye."""
    first, second, round_ = lamp.figure()
    if lamp.photometry.opening.size == 0:
        first, second = 0.05 * lamp.axes[0], 0.05 * lamp.axes[1]
    if round_:
        turn = 2.0 * np.pi * np.arange(24) / 24
        weights = 0.5 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    else:
        weights = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return np.asarray(lamp.position + weights @ np.stack([first, second]))


def _legend(sheet: _Sheet) -> Sequence[str]:
    """Say what colours mean, and draw a bar of round length."""
    y = sheet.height - 18
    span = 0.25 * SIDE / sheet.scale
    decade = 10.0 ** np.floor(np.log10(span))
    bar = max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= span)
    x1, x2 = sheet.width - MARGIN - sheet.scale * bar, sheet.width - MARGIN
    return [
        f'<path d="M{x1:.1f} {y - 26:.0f} v6 H{x2:.1f} v-6" fill="none" stroke="#222"/>',
        f'<text x="{(x1 + x2) / 2:.1f}" y="{y - 26:.0f}" text-anchor="middle">{bar:g} m</text>',
        f'<text x="{MARGIN:.0f}" y="{y:.0f}">seen from above, x right, y up; red: C0 half-plane; '
        "blue, dashed: γ = 0 (a dot where it points along the view); yellow: luminous opening</text>",
    ]
