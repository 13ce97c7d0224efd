"""Reports of sixty observers in under a minute. Run by hand: pytest tests/bench_reports.py -s."""

from __future__ import annotations

from time import perf_counter

import pytest
from test_reports_resultfolder import make_result_folder

from lelight.reports.glare import write_glare_report
from lelight.reports.luminance import write_luminance_report

#: Pixels of a picture under the preset "normal".
PIXELS = 800
LONGEST = 60.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    names = [f"seat {number}" for number in range(60)]
    return make_result_folder(tmp_path_factory.mktemp("many") / "x", observers=names, pixels=PIXELS)


@pytest.mark.parametrize("write", [write_luminance_report, write_glare_report])
def test_sixty_observers(folder, write):
    started = perf_counter()
    size = write(folder).stat().st_size
    seconds = perf_counter() - started
    print(f"{write.__name__}: {seconds:.1f} s, {size / 1e6:.1f} MB")
    assert seconds < LONGEST
