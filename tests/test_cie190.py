"""Tabular UGR against the printed example of CIE 190 and, where they are at hand, other programs' tables."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import cie190_example
import numpy as np
import pytest
from photofiles import batwing, ldt

from lelight.metrics.cie190 import background_luminances, ugr_table, zone_sums
from lelight.metrics.cie190_tables import GEOMETRIC, ROOMS, TRANSFER
from lelight.photometry.photometry import Photometry
from lelight.photometry.reading import read_photometry

#: Folder with ``sample_NN.ldt`` and ``t_NN_Relux.csv`` (19 rows, 5 columns crosswise and 5 endwise).
PRINTED_TABLES = "LELIGHT_UGR_TABLES"


def read(tmp_path: Path, text: str) -> Photometry:
    (tmp_path / "lamp.ldt").write_text(text)
    return read_photometry(tmp_path / "lamp.ldt")


@pytest.fixture
def example(tmp_path) -> Photometry:
    return read(tmp_path, cie190_example.luminaire())


def test_printed_example_in_all_190_cells(example):
    table = ugr_table(example, spacing=1.0)
    found = np.hstack([table.crosswise, table.endwise])
    assert np.abs(found - cie190_example.RATINGS).max() <= 0.13


def test_printed_example_step_by_step(example):
    # Zonal fluxes 338.5, 534.4, 621.3, 650.1 lm and E_WID = 27.37 lx (2H x 4H, 70/50/20) are printed.
    sums, down, up = zone_sums(example)
    assert sums == pytest.approx([338.5, 534.4, 621.3, 650.1], rel=2e-3)
    assert (down, up) == (pytest.approx(649.7, abs=0.1), pytest.approx(0.0, abs=1.0))
    assert background_luminances(example, 1.0)[2, 0] * np.pi == pytest.approx(27.37, rel=2e-3)


def test_twice_the_flux_rates_8_lg_2_higher(example):
    double = replace(example, candela=2.0 * example.candela)
    difference = ugr_table(double).crosswise - ugr_table(example).crosswise
    assert difference == pytest.approx(8.0 * np.log10(2.0), abs=1e-9)


def test_turned_luminaire_exchanges_crosswise_and_endwise(example):
    opening = replace(example.opening, along_c0=example.opening.along_c90, along_c90=example.opening.along_c0)
    turned = replace(example, candela=np.roll(example.candela, 6, axis=0), opening=opening)
    assert ugr_table(turned).crosswise == pytest.approx(ugr_table(example).endwise, abs=1e-9)


def test_a_wrong_opening_does_not_pass(example):
    smaller = replace(example.opening, along_c0=0.3)
    table = ugr_table(replace(example, opening=smaller), spacing=1.0)
    assert np.abs(np.hstack([table.crosswise, table.endwise]) - cie190_example.RATINGS).max() > 0.13


def test_tables_are_whole():
    assert ROOMS.shape == (19, 2)
    assert GEOMETRIC.shape == (19, 4)
    assert TRANSFER.shape == (5, 19, 3)
    # Factors of one room index are the same whichever way the room lies: 2 x 4 and 4 x 2 H.
    assert GEOMETRIC[2].tolist() == GEOMETRIC[6].tolist()


def test_without_opening_or_light_there_is_no_rating(tmp_path):
    with pytest.raises(ValueError, match="opening"):
        ugr_table(read(tmp_path, ldt(batwing, sizes=[0] * 9)))
    with pytest.raises(ValueError, match="no light"):
        ugr_table(read(tmp_path, ldt(lambda c, g: 0.0)))


def test_printed_tables_of_another_program():
    folder = os.environ.get(PRINTED_TABLES)
    if not folder:
        pytest.skip(f"set {PRINTED_TABLES} to a folder with sample_NN.ldt and t_NN_Relux.csv")
    files = sorted(Path(folder).glob("sample_*.ldt"))
    assert files
    for file in files:
        printed = np.genfromtxt(file.with_name(f"t_{file.stem[7:]}_Relux.csv"), delimiter=",")
        table = ugr_table(read_photometry(file))
        # Cells printed as "<10" hold no number.
        assert np.nanmax(np.abs(np.hstack([table.crosswise, table.endwise]) - printed)) <= 0.45, file.name
