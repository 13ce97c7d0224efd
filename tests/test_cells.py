"""Cells on triangles: where places are drawn, and how densely."""

from __future__ import annotations

import numpy as np
import pytest

from lelight.estimate.cells import Cells, cut
from lelight.scene import triangle_areas

FRONT_AND_BACK = np.array([0, 1, 1, 3]), np.array([1, 1, -1, -1])


@pytest.fixture(name="cells")
def uneven_cells() -> Cells:
    rng = np.random.default_rng(1)
    cells = cut(
        rng.random((5, 3, 3)), faces=FRONT_AND_BACK, weights=np.array([1.0, 2.0, 3.0, 1.0]), wanted=500
    )
    return cells.with_weights(rng.random(len(cells)))


def test_there_are_about_as_many_as_wanted(cells: Cells) -> None:
    assert 450 < len(cells) < 550
    assert len(cut(cells.corners, faces=FRONT_AND_BACK, weights=np.ones(4), wanted=1)) == 4


def test_places_are_found_again_in_the_cell_they_were_drawn_in(cells: Cells) -> None:
    drawn, _ = cells.draw(np.random.default_rng(2).random((100_000, 3)))
    np.testing.assert_allclose(cells.density(drawn.triangle, drawn.side, drawn.points) * drawn.area, 1.0)


def test_cells_are_drawn_by_their_weights(cells: Cells) -> None:
    _, cell = cells.draw(np.random.default_rng(3).random((100_000, 3)))
    counts = np.bincount(cell, minlength=len(cells))
    expected = 100_000 * cells.probability
    large = expected > 5
    chi_square = np.sum((counts - expected)[large] ** 2 / expected[large])
    assert chi_square < large.sum() + 5 * np.sqrt(2 * large.sum())


def test_drawn_areas_add_up_to_the_surface(cells: Cells) -> None:
    drawn, _ = cells.draw(np.random.default_rng(4).random((200_000, 3)))
    area = triangle_areas(cells.corners)[FRONT_AND_BACK[0]].sum()
    error = drawn.area.std() / np.sqrt(200_000)
    assert drawn.area.mean() == pytest.approx(area, abs=4 * error)


def test_places_on_other_sides_are_never_drawn(cells: Cells) -> None:
    triangle, side = np.array([0, 2, 4]), np.array([-1, 1, -1])
    points = cells.corners[triangle].mean(axis=1)
    np.testing.assert_array_equal(cells.density(triangle, side, points), 0.0)
