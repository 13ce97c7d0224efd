"""The two PDF reports, from the outside: bytes, text and pages."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import warnings

import numpy as np
import pytest
from test_reports_resultfolder import figure, make_result_folder

from lelight.errors import OutputError
from lelight.reports.document import MissingGlyphWarning, timestamp_of
from lelight.reports.glare import write_glare_report
from lelight.reports.luminance import write_luminance_report
from lelight.reports.report import Order
from lelight.reports.summary import MAIN
from lelight.writing.pictures import write_exr
from lelight.writing.polydata import PolyData, write_polydata

WRITERS = [write_luminance_report, write_glare_report]

needs_poppler = pytest.mark.skipif(
    not (shutil.which("pdftotext") and shutil.which("pdftoppm")),
    reason="poppler (pdftotext, pdftoppm) is not installed",
)


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    return make_result_folder(tmp_path_factory.mktemp("reports") / "office ü.lelight")


@pytest.fixture(scope="module")
def pdfs(out):
    """Both reports, by the function that writes them."""
    return {write: write(out, Order(title="Head office", author="A. Nyone")) for write in WRITERS}


def text_of(pdf):
    run = subprocess.run(["pdftotext", "-layout", str(pdf), "-"], capture_output=True, check=True)
    assert run.stderr == b""
    return run.stdout.decode().replace("\u00a0", " ")


def change(folder, file, edit):
    content = json.loads((folder / file).read_text(encoding="utf-8"))
    edit(content)
    (folder / file).write_text(json.dumps(content), encoding="utf-8")


@pytest.mark.parametrize("write", WRITERS)
def test_the_same_folder_gives_the_same_bytes(out, pdfs, write, monkeypatch, tmp_path):
    first = pdfs[write].read_bytes()
    # Elsewhere, later and in another folder for temporary files.
    copy = tmp_path / "copy.lelight"
    shutil.copytree(out, copy)
    monkeypatch.setenv("TZ", "Pacific/Auckland")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    assert write(copy, Order(title="Head office", author="A. Nyone")).read_bytes() == first
    assert str(tmp_path).encode() not in first


@pytest.mark.parametrize("write", WRITERS)
def test_reports_are_archivable_and_carry_the_date_of_the_run(pdfs, write):
    pdf = pdfs[write].read_bytes()
    assert re.search(rb"<pdfaid:part>2</pdfaid:part>\s*<pdfaid:conformance>B<", pdf)
    assert b"2026-03-04T05:06:07" in pdf


def test_dates_without_a_zone_are_utc_and_no_date_is_1970():
    # 2026-03-04T05:06:07Z is 20516 days and 18367 s after the beginning of 1970.
    assert (
        timestamp_of("2026-03-04T05:06:07")
        == timestamp_of("2026-03-04T06:06:07+01:00")
        == 20516 * 86400 + 18367
    )
    assert timestamp_of("yesterday") == timestamp_of(None) == 0


@needs_poppler
def test_the_summary_tells_what_metrics_json_holds(out, pdfs):
    text = text_of(pdfs[write_luminance_report])
    mean = json.loads((out / "metrics.json").read_text(encoding="utf-8"))["planes"]["work plane"][
        "mean_illuminance"
    ]
    # Two standard errors of 1.7 lx are 3.4 lx, two digits by the rule: one decimal.
    assert mean["std_error"] == 1.7
    assert re.search(rf"Mean illuminance +Em +{mean['value']:.1f} +± 3\.4 +lx +≥ 500 lx +✗ fail", text)
    # 0.012: ± 0.024, three decimals. 0.21 cd/m²: ± 0.42, one decimal. 0.06: ± 0.12, two decimals.
    assert re.search(r"Uniformity Emin / Em +U0 +0\.\d{3} +± 0\.024 +– +≥ 0\.6 +○ undecided", text)
    assert re.search(r"Background luminance +19\.1 +± 0\.4 cd/m²", text)
    assert re.search(r"UGR +17\.83 +± 0\.12 +– +≤ 19 +✓ pass", text)
    assert re.search(r"UGR +<10 +– +≤ 19 +✓ pass", text)
    assert "4 requirements: 2 passed, 1 failed, 1 undecided within the error." in text
    assert "Head office" in text
    assert "A. Nyone" in text


@needs_poppler
def test_every_number_of_the_summary_is_that_of_metrics_json(out, pdfs):
    """By the file, not by the program's rounding: within half of the last digit that is printed."""
    text = text_of(pdfs[write_luminance_report])
    summary = text[text.index("Summary") : text.index("Contents")]
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    names = {
        "mean_illuminance": r"Mean illuminance +Em",
        "uniformity": r"Uniformity Emin / Em +U0",
        "mean_cylindrical_illuminance": r"Mean cylindrical illuminance +Ez",
        "ugr": r"Unified glare rating, from emitters +UGR",
        "mean_room_surface_exitance": r"Mean room surface exitance +MRSE",
    }
    number = r"(<?[\d.]+)(?: +± ([\d.]+))? +(lx|lm/m²|–)"
    printed = re.findall(rf"({'|'.join(names.values())}) +{number}", summary)
    entries = [*metrics["planes"].values(), *metrics["observers"].values(), metrics["room"]]
    required = {
        key for entry in entries for key, each in entry.items() if isinstance(each, dict) and "target" in each
    }
    assert required | {key for entry in entries for key in MAIN & entry.keys()} == set(names)
    expected = [(entry[key], pattern) for entry in entries for key, pattern in names.items() if key in entry]
    assert len(printed) == len(expected) == 6
    for (label, value, half_width, unit), (entry, pattern) in zip(printed, expected, strict=True):
        assert re.fullmatch(pattern, label)
        assert unit == {"1": "–"}.get(entry["unit"], entry["unit"])
        if value == "<10":
            assert entry["value"] < 10.0
            continue
        last_digit = 10.0 ** -len(value.partition(".")[2])
        assert float(value) == pytest.approx(entry["value"], abs=0.5 * last_digit * (1 + 1e-9))
        assert float(half_width) == pytest.approx(2 * entry["std_error"], abs=0.5 * last_digit * (1 + 1e-9))


@needs_poppler
def test_data_sheets_show_file_hash_and_table(out, pdfs):
    sheet = json.loads((out / "run.json").read_text(encoding="utf-8"))["data_sheets"][0]
    luminance, glare = (text_of(pdfs[write]) for write in WRITERS)
    assert "lamps/panel.ldt" in luminance
    assert sheet["sha256"] in luminance
    ratings = [*sheet["ugr"]["crosswise"][7], *sheet["ugr"]["endwise"][7]]
    row = "4H × 3H +" + " +".join("<10" if each < 10 else f"{each:.1f}" for each in ratings)
    assert re.search(row, luminance) and re.search(row, glare)
    assert "they say nothing about an observer of this scene" in re.sub(r"\s+", " ", glare)


@needs_poppler
@pytest.mark.parametrize("write", WRITERS)
def test_fonts_are_embedded_and_sections_have_bookmarks(pdfs, write):
    fonts = subprocess.run(["pdffonts", str(pdfs[write])], capture_output=True, check=True, text=True)
    lines = fonts.stdout.splitlines()[2:]
    assert lines and all(re.search(r" yes yes yes +\d+ +\d+$", line) for line in lines)
    for title in (b"Summary", b"A  desk 1", b"Method and accuracy", b"Glossary"):
        assert b"/Title(" + title + b")" in pdfs[write].read_bytes()


@needs_poppler
def test_every_figure_of_a_plane_is_printed_to_its_error(out, pdfs):
    text = text_of(pdfs[write_luminance_report])
    figures = json.loads((out / "metrics.json").read_text(encoding="utf-8"))["planes"]["work plane"]
    # Decimals that follow from twice the standard errors by the Particle Data Group's rule, by hand.
    decimals = {
        "mean_illuminance": 1,  # 3.4
        "minimum_illuminance": 0,  # 4.8 -> 5
        "maximum_illuminance": 0,  # 6.2 -> 6
        "uniformity": 3,  # 0.024
        "diversity": 3,  # 0.018
        "mean_cylindrical_illuminance": 1,  # 1.8
        "modelling": 3,  # 0.0042 -> 0.004
        "some_new_figure": 2,  # 0.20
    }
    chapter = text[text.rindex("Illuminance on planes") :]
    for key, places in decimals.items():
        entry = figures[key]
        printed = f"{entry['value']:.{places}f} *± ?{2 * entry['std_error']:.{places}f}"
        assert re.search(rf"(?<![\d.]){printed}(?!\d)", chapter), key


@needs_poppler
@pytest.mark.parametrize("write", WRITERS)
def test_no_raw_key_reaches_the_page(pdfs, write):
    text = text_of(pdfs[write])
    assert re.findall(r"\w+_(?:illuminance|figure|degree|m2|error|picture)|\bNone\b|\bnan\b", text) == []


@needs_poppler
def test_the_glare_report_says_what_it_is_not(pdfs):
    text = text_of(pdfs[write_glare_report])
    assert "not the tabular UGR" in text
    assert not re.search("compl(y|ies|iant|iance)", text, re.IGNORECASE)
    assert "not counted: outside the field" in text
    assert re.search(r"A +desk 1 +<10 +– +18\.2 +0\.193 +19\.1 +≤ 19 +✓ pass", text)


@needs_poppler
@pytest.mark.parametrize("write", WRITERS)
def test_pages_render_without_a_word(pdfs, write, tmp_path):
    pdf = pdfs[write]
    run = subprocess.run(
        ["pdftoppm", "-r", "20", "-gray", str(pdf), str(tmp_path / "page")], capture_output=True, check=True
    )
    assert run.stderr == b""
    pages = sorted(tmp_path.glob("page*"))
    assert len(pages) > 3
    # No page but the last ends above a quarter of its height: two thirds of header and footer aside.
    assert min(_filled(page) for page in pages[:-1]) > 0.25


@needs_poppler
@pytest.mark.parametrize("figures", [0, 12, 24, 36])
def test_charts_of_a_plane_do_not_spill_onto_a_page_of_their_own(figures, tmp_path):
    folder = make_result_folder(tmp_path / "x", pixels=16, observers=("one",))
    more = {f"figure_{k}": figure(100.0 + k, "lx", 1.0) for k in range(figures)}
    change(folder, "metrics.json", lambda metrics: metrics["planes"]["work plane"].update(more))
    pdf = write_luminance_report(folder, Order(paper="us-letter"))
    subprocess.run(["pdftoppm", "-r", "20", "-gray", str(pdf), str(tmp_path / "page")], check=True)
    pages = sorted(tmp_path.glob("page*"))
    assert min(_filled(page) for page in pages[:-1]) > 0.3


def _filled(page):
    """Share of a page's height, without header and footer, down to the last dark line."""
    header, pixels = page.read_bytes().split(b"\n255\n", 1)
    columns, rows = (int(number) for number in header.split()[-2:])
    body = np.frombuffer(pixels, np.uint8).reshape(rows, columns)[rows // 12 : -rows // 12]
    dark = np.flatnonzero((body < 200).any(axis=1))
    return (dark[-1] + 1) / len(body) if len(dark) else 0.0


NASTY = [
    '#let x = $1$ \\ "q" <lab> @ref *b* _i_ `r` [c] // x',
    '#panic("run") #sys.inputs {{x}}',
    "N" * 200,
    "a\nb\x00\t\ud800\u202e",
    "../../etc/passwd",
]


@needs_poppler
@pytest.mark.parametrize("write", WRITERS)
def test_names_are_data_whatever_they_hold(write, tmp_path):
    folder = make_result_folder(tmp_path / "x", planes=NASTY[:1], observers=NASTY[1:], pixels=16)
    text = text_of(write(folder, Order(title=NASTY[0], author=NASTY[1]))).replace("\u200b", "")
    assert [name for name in (NASTY[0], NASTY[1], NASTY[4], "NNNNNNNN") if name not in text] == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["x"]


@needs_poppler
@pytest.mark.parametrize("write", WRITERS)
def test_letters_without_a_glyph_cost_the_archive_format_only(write, tmp_path):
    # Cuneiform is hardly in a font here; Hebrew may be, and must not turn what follows around.
    names = ["\U00012000\u6f22", "שולחן"]
    folder = make_result_folder(tmp_path / "x", observers=names, pixels=16)
    change(
        folder,
        "metrics.json",
        lambda metrics: metrics["observers"][names[1]].update(ugr=figure(21.0, "1", 0.06)),
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pdf = write(folder)
    assert {warning.category for warning in caught} <= {MissingGlyphWarning}
    assert re.search(r"21\.00 +± 0\.12", text_of(pdf))


@needs_poppler
def test_a_number_stands_in_for_a_letter_that_no_font_has(tmp_path):
    # Cuneiform is hardly in a font here.
    folder = make_result_folder(tmp_path / "x", observers=["seat \U00012000\U00012001"], pixels=16)
    with pytest.warns(
        MissingGlyphWarning, match=r"letters \[U\+12000\], \[U\+12001\]; they are written by their numbers"
    ):
        pdf = write_glare_report(folder)
    assert "seat [U+12000 U+12001]" in text_of(pdf)
    assert b"<pdfaid:part>2</pdfaid:part>" in pdf.read_bytes()


def test_figures_alone_are_written_as_svg(out, tmp_path):
    copy = tmp_path / "copy.lelight"
    shutil.copytree(out, copy)
    written = {write: write(copy, Order(figures_only=True)) for write in WRITERS}
    assert not list(copy.glob("*.pdf")) or all((out / name.name).exists() for name in copy.glob("*.pdf"))
    names = {path.name for path in written[write_luminance_report].iterdir()}
    assert {"plan.svg", "isometric.svg", "view-A.svg", "isolines-P1.svg", "luminaire-1.svg"} <= names
    assert {"glare-A.svg", "rose-B.svg", "cones-A.svg"} <= {
        path.name for path in (copy / "figures" / "glare").iterdir()
    }
    assert all(path.read_bytes().startswith(b"<?xml") for path in (copy / "figures").rglob("*.svg"))


def test_a_logo_is_set_or_refused_in_one_line(tmp_path):
    folder = make_result_folder(tmp_path / "x", pixels=16, observers=())
    logo = tmp_path / "logo.svg"
    logo.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><rect width="9" height="9"/></svg>'
    )
    assert write_glare_report(folder, Order(logo=logo)).stat().st_size > 10_000
    for name, content, told in (
        ("bad.png", b"no picture", "is no picture"),
        ("logo.gif", b"GIF89a", "a logo is one of .svg"),
        ("absent.png", None, "No such file"),
    ):
        if content is not None:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(OutputError, match=r"^[^\n]+$") as error:
            write_glare_report(folder, Order(logo=tmp_path / name))
        assert str(tmp_path / name) in str(error.value)
        assert told in str(error.value)


@pytest.mark.parametrize(
    ("version", "newer"), [("99.0.0", True), ("0.1.1", True), ("0.1.0", False), ("0.0.9", False)]
)
def test_a_folder_of_a_newer_version_is_refused(tmp_path, version, newer):
    folder = make_result_folder(tmp_path / "x", pixels=16, observers=())
    change(folder, "run.json", lambda run: run.update(lelight=version))
    if not newer:
        assert write_glare_report(folder).exists()
        return
    with pytest.raises(
        OutputError, match=rf"written by lelight {version}, newer than this one, .*lelight calc"
    ):
        write_glare_report(folder)


@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize("lacking", [{"observers": ()}, {"planes": (), "observers": ("one",)}])
def test_scenes_without_observers_or_planes_are_reported(write, lacking, tmp_path):
    pdf = write(make_result_folder(tmp_path / "x", pixels=16, **lacking))
    assert pdf.read_bytes().startswith(b"%PDF-")


@pytest.mark.parametrize("grid", [(1, 1), (1, 7), (40, 40)])
def test_one_node_and_any_grid_are_reported(grid, tmp_path):
    folder = make_result_folder(tmp_path / "x", pixels=16, grid=grid, observers=())
    arrays = {
        "illuminance_lx": np.array([0.0]),
        "normal": np.array([[0.0, 0, 1]]),
        "hidden": np.zeros(1, "u1"),
    }
    write_polydata(folder / "field.vtp", PolyData(points=np.array([[0.1, 0.2, 0.3]]), point_arrays=arrays))
    assert all(write(folder).read_bytes().startswith(b"%PDF-") for write in WRITERS)


@pytest.mark.parametrize("write", WRITERS)
def test_a_dark_picture_and_a_bare_run_are_reported(write, tmp_path):
    folder = make_result_folder(tmp_path / "x", pixels=16)
    write_exr(folder / "observers" / "desk 1.exr", np.zeros((16, 16)), view="")
    write_exr(folder / "observers" / "desk 2.exr", np.zeros((16, 16)), view="")
    (folder / "run.json").write_text("{}", encoding="utf-8")
    change(
        folder,
        "metrics.json",
        lambda metrics: [metrics["observers"][name].pop("sources") for name in metrics["observers"]],
    )
    assert write(folder).stat().st_size > 10_000


@pytest.mark.parametrize("write", WRITERS)
@pytest.mark.parametrize(
    ("missing", "remedy"),
    [
        ("metrics.json", "lelight calc"),
        ("run.json", "lelight calc"),
        ("field.vtp", "lelight calc"),
        ("observers/desk 2.exr", "lelight render"),
    ],
)
def test_what_is_missing_is_told_in_one_line(write, missing, remedy, tmp_path):
    folder = make_result_folder(tmp_path / "x", pixels=16)
    (folder / missing).unlink()
    with pytest.raises(OutputError, match=r"^[^\n]+$") as error:
        write(folder)
    assert missing in str(error.value)
    assert remedy in str(error.value)
    assert list(folder.glob("*.pdf")) == []


@pytest.mark.parametrize("write", WRITERS)
def test_a_folder_that_is_not_there_is_told(write, tmp_path):
    with pytest.raises(OutputError, match="no such result folder; `lelight calc"):
        write(tmp_path / "nowhere")


def test_a_paper_that_is_none_is_the_callers_mistake(out):
    with pytest.raises(ValueError, match="paper: 'a5x' is none of a3, a4"):
        write_luminance_report(out, Order(paper="a5x"))
