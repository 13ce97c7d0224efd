"""The table of all figures as JSON and CSV."""

from __future__ import annotations

import csv
import io
import json

from lelight.metrics.figure import Figure
from lelight.metrics.table import COLUMNS, metrics, rows, to_csv

MEAN = Figure(500.0, "lx", 5.0, "mean", "pass", 480.0, "EN 12464-1")
NONE = Figure(None, "1", None, "UGR", note="no glare source, none at all")


def table():
    return metrics(
        {'Schreibtisch "ä", 1': {"mean_illuminance": MEAN}}, {"desk.1": {"ugr": NONE}}, room={"m": MEAN}
    )


def test_figures_are_grouped_as_the_files_promise():
    found = table()
    assert list(found) == ["planes", "observers", "room"]
    assert found["planes"]['Schreibtisch "ä", 1']["mean_illuminance"] == MEAN.to_json()
    assert found["observers"]["desk.1"]["ugr"]["value"] is None
    assert metrics({}, {}) == {"planes": {}, "observers": {}, "room": {}}


def test_json_goes_there_and_back():
    assert json.loads(json.dumps(table(), allow_nan=False)) == table()


def test_csv_holds_every_figure_once_and_any_name():
    lines = list(csv.DictReader(io.StringIO(to_csv(table()))))
    assert [tuple(line)[:3] for line in lines] == [COLUMNS[:3]] * 3
    assert [(line["group"], line["name"], line["figure"]) for line in lines] == [
        ("planes", 'Schreibtisch "ä", 1', "mean_illuminance"),
        ("observers", "desk.1", "ugr"),
        ("room", "", "m"),
    ]
    assert (lines[0]["value"], lines[0]["verdict"], lines[0]["target"]) == ("500.0", "pass", "480.0")
    assert (lines[1]["value"], lines[1]["verdict"], lines[1]["note"]) == ("", "", NONE.note)


def test_csv_passes_over_what_is_no_figure():
    found = table()
    found["observers"]["desk.1"] |= {
        "sources": [{"name": "panel"}],
        "position": [0, 0, 1.2],
        "grid": {"rows": 2},
    }
    assert to_csv(found) == to_csv(table())


def test_csv_of_a_run_without_figures_is_its_head_line():
    assert to_csv(metrics({}, {})) == ",".join(COLUMNS) + "\n"
    assert list(rows({})) == []
