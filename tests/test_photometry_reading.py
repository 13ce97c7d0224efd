"""Photometric files as vendors write them, and files that are none."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import photofiles
import pytest
from matplotlib.figure import Figure
from photofiles import (
    CORPUS_IES,
    CORPUS_LDT,
    GAMMA,
    batwing,
    ies,
    lambertian,
    ldt,
    sideways,
    skew,
    uplight,
    wallwasher,
)

from lelight.errors import InputError
from lelight.photometry.diagram import paint_polar, polar_curves
from lelight.photometry.findings import findings
from lelight.photometry.photometry import Photometry
from lelight.photometry.reading import read_photometry
from lelight.photometry.writing import convert
from lelight.photometry.zones import (
    downward_fraction,
    flux_below,
    flux_code,
    light_output_ratio,
    luminous_flux,
    spread,
)

CLOSE = 1e-6
#: A table in steps of 5 degrees, linear between, holds this little less flux than the curve it samples.
STEP_LOSS = 2e-3


def read(tmp_path: Path, content: str | bytes, name: str = "lamp.ldt") -> Photometry:
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode("latin-1"))
    return read_photometry(path)


def rules(photometry: Photometry) -> set[str]:
    return {finding.rule for finding in findings(photometry)}


@pytest.mark.parametrize(
    ("symmetry", "intensity"), [(0, skew), (1, lambertian), (2, wallwasher), (3, sideways), (4, batwing)]
)
def test_every_symmetry_of_eulumdat_gives_the_whole_turn(tmp_path, symmetry, intensity):
    photometry = read(tmp_path, ldt(intensity, symmetry=symmetry, per_klm=100.0))
    for c in range(0, 360, 15):
        expected = [300.0 * intensity(c, g) for g in GAMMA]
        assert photometry.intensity(c, GAMMA) == pytest.approx(expected, rel=CLOSE, abs=1e-6)


@pytest.mark.parametrize(
    ("horizontal", "intensity"),
    [
        ([0], lambertian),
        (range(0, 91, 15), batwing),
        (range(0, 181, 15), wallwasher),
        (range(90, 271, 15), sideways),
        (range(0, 361, 15), skew),
        (range(0, 360, 15), skew),
        (range(-180, 181, 15), skew),
    ],
)
def test_every_range_of_horizontal_angles_gives_the_whole_turn(tmp_path, horizontal, intensity):
    photometry = read(tmp_path, ies(intensity, horizontal=list(horizontal), scale=300.0), "lamp.ies")
    for c in range(0, 360, 15):
        expected = [300.0 * intensity(c, g) for g in GAMMA]
        assert photometry.intensity(c, GAMMA) == pytest.approx(expected, rel=CLOSE, abs=1e-6)


def test_flux_is_the_integral(tmp_path):
    photometry = read(tmp_path, ldt(lambertian, symmetry=1))
    assert luminous_flux(photometry) == pytest.approx(3000.0, rel=STEP_LOSS)
    assert flux_below(photometry, 60.0) == pytest.approx(3000.0 * 0.75, rel=STEP_LOSS)
    assert light_output_ratio(photometry) == pytest.approx(1.0, rel=STEP_LOSS)
    assert downward_fraction(read(tmp_path, ldt(uplight, symmetry=1))) == pytest.approx(0.0, abs=1e-12)
    # An isotropic source of 1 cd: the table is exact, 4 π lm.
    flat = read(tmp_path, ies(lambda c, g: 1.0, scale=1.0), "flat.ies")
    assert luminous_flux(flat) == pytest.approx(4.0 * math.pi, rel=CLOSE)


def test_flux_code_of_a_lambertian_source(tmp_path):
    # sin² of the cones' half angles: 1 - (3/4)², 1 - (1/2)², 1 - (1/4)².
    assert flux_code(read(tmp_path, ldt(lambertian, symmetry=1))) == (44, 75, 94, 100, 100)


def test_beam_of_a_cosine_is_120_degrees(tmp_path):
    angles = spread(read(tmp_path, ldt(lambertian, symmetry=1)), 0.0)
    assert angles.beam == pytest.approx(120.0, abs=0.2)
    assert angles.field == pytest.approx(2 * math.degrees(math.acos(0.1)), abs=0.2)
    up = spread(read(tmp_path, ldt(lambda c, g: max(0.0, -math.cos(math.radians(g))), symmetry=1)), 0.0)
    assert up.beam == pytest.approx(120.0, abs=0.2)


def test_factors_of_lm63(tmp_path):
    plain = luminous_flux(read(tmp_path, ies(), "a.ies"))
    for edition, expected in (("IESNA:LM-63-1995", 0.9 * 0.5), ("IESNA:LM-63-2002", 0.9)):
        made = read(tmp_path, ies(first=edition, multiplier=2.0, ballast="0.9 0.5 25"), "b.ies")
        assert luminous_flux(made) == pytest.approx(2.0 * expected * plain, rel=CLOSE)


def test_factors_of_eulumdat(tmp_path):
    made = read(
        tmp_path, ldt(factor=2.0, lamps=((2, "T16", 1500, "830", "1B", 62), (1, "LED", 900, "", "", 9)))
    )
    assert made.candela.max() == pytest.approx(2.0 * 1500 / math.pi, rel=CLOSE)
    assert [lamp.flux for lamp in made.lamps] == [1500, 900]
    assert "lamp-sets" in rules(made)


def test_sizes_lie_across_each_other_in_the_two_formats(tmp_path):
    of_ldt = read(tmp_path, ldt(sizes=(620, 320, 80, 600, 300, 10, 20, 30, 40))).opening
    assert (of_ldt.along_c90, of_ldt.along_c0, of_ldt.heights) == (0.6, 0.3, (0.01, 0.02, 0.03, 0.04))
    of_ies = read(tmp_path, ies(sizes=(0.3, 0.6, 0.02)), "a.ies").opening
    assert (of_ies.along_c0, of_ies.along_c90, of_ies.height) == (0.6, 0.3, 0.02)
    feet = read(tmp_path, ies(sizes=(1, 2, 0), unit=1), "a.ies")
    assert feet.opening.along_c0 == pytest.approx(0.6096)
    assert "unit-feet" in rules(feet)


@pytest.mark.parametrize(
    ("sizes", "shape", "nadir", "side"),
    [
        # width, length, height; areas seen from below and along C90, from the shapes' own formulas.
        ((0.3, 0.6, 0.0), "rectangle", 0.18, 0.0),
        ((0.3, 0.6, 0.1), "rectangle", 0.18, 0.06),
        ((-0.4, -0.4, 0.0), "ellipse", math.pi * 0.04, 0.0),
        ((-0.4, 0.0, 0.0), "ellipse", math.pi * 0.04, 0.0),
        ((-0.4, -0.4, 0.5), "ellipse", math.pi * 0.04, 0.2),
        ((-0.4, -0.8, 0.0), "ellipse", math.pi * 0.08, 0.0),
        ((-0.4, -0.4, -0.4), "ellipsoid", math.pi * 0.04, math.pi * 0.04),
        ((-0.4, 0.0, -0.4), "ellipsoid", 0.0, 0.0),
        ((-0.1, 1.2, -0.1), "tube_c0", 0.12, 0.12),
        ((1.2, -0.1, -0.1), "tube_c90", 0.12, math.pi * 0.0025),
        ((0.0, 0.6, 0.3), "rectangle", 0.0, 0.18),
        ((0.0, 0.0, 0.0), "point", 0.0, 0.0),
        # A lying cylinder whose ends are ellipses 0.2 m wide and 0.1 m high.
        ((-0.2, 1.2, -0.1), "tube_c0", 0.24, 0.12),
        ((1.2, -0.2, -0.1), "tube_c90", 0.24, math.pi * 0.005),
    ],
)
def test_signs_code_the_shape_of_the_opening(tmp_path, sizes, shape, nadir, side):
    opening = read(tmp_path, ies(sizes=sizes), "a.ies").opening
    assert opening.shape == shape
    assert opening.projected_area(0.0, 0.0) == pytest.approx(nadir, abs=1e-12)
    assert opening.projected_area(90.0, 90.0) == pytest.approx(side, abs=1e-12)


@pytest.mark.parametrize(
    ("sizes", "shape", "nadir", "side"),
    [
        ((-0.4, 0.0, -0.4), "ellipsoid", math.pi * 0.04, math.pi * 0.04),
        ((-0.4, 0.0, 0.5), "ellipse", math.pi * 0.04, 0.2),
        ((0.0, 1.2, -0.1), "tube_c0", 0.12, 0.12),
        ((1.2, 0.0, -0.1), "tube_c90", 0.12, math.pi * 0.0025),
        ((-0.4, 0.8, 0.0), "ellipse", math.pi * 0.08, 0.0),
        ((0.4, -0.8, 0.5), "ellipse", math.pi * 0.08, 0.4),
        ((-0.4, 0.8, -0.6), "ellipsoid", math.pi * 0.08, math.pi * 0.12),
        ((0.8, -0.4, -0.6), "ellipsoid", math.pi * 0.08, math.pi * 0.06),
    ],
)
def test_editions_before_2002_code_some_shapes_otherwise(tmp_path, sizes, shape, nadir, side):
    for edition in ("IESNA:LM-63-1995", "IESNA91", ""):
        opening = read(tmp_path, ies(sizes=sizes, first=edition), "a.ies").opening
        assert opening.shape == shape
        assert opening.projected_area(0.0, 0.0) == pytest.approx(nadir, abs=1e-12)
        assert opening.projected_area(90.0, 90.0) == pytest.approx(side, abs=1e-12)


def counted(symmetry: int, planes, columns, intensity) -> str:
    """A file that counts ``planes`` and gives ``columns`` under a symmetry indicator, right or wrong."""
    head = ldt(intensity).split("\r\n")[:42]
    head[2:5] = str(symmetry), str(len(planes)), "15"
    body = [
        *planes,
        *GAMMA,
        *(1000 / math.pi * intensity(float(c), float(g)) for c in columns for g in GAMMA),
    ]
    return "\r\n".join(map(str, head + body)) + "\r\n"


QUARTER, HALF, TURN = range(0, 91, 15), range(0, 181, 15), range(0, 360, 15)
ACROSS = [*range(270, 360, 15), *QUARTER]


@pytest.mark.parametrize(
    ("symmetry", "planes", "columns", "intensity", "severity"),
    [
        # The number of planes counts those of the sector only.
        (4, QUARTER, QUARTER, batwing, "warning"),
        (2, HALF, HALF, wallwasher, "warning"),
        (3, ACROSS, ACROSS, sideways, "warning"),
        # More planes than the indicator needs: they are used.
        (4, TURN, HALF, batwing, "error"),
        (4, TURN, TURN, skew, "error"),
        (1, TURN, QUARTER, batwing, "error"),
    ],
)
def test_planes_that_are_there_are_believed(tmp_path, symmetry, planes, columns, intensity, severity):
    photometry = read(tmp_path, counted(symmetry, planes, columns, intensity))
    for c in range(0, 360, 15):
        expected = [3000 / math.pi * intensity(c, g) for g in GAMMA]
        assert photometry.intensity(c, GAMMA) == pytest.approx(expected, rel=CLOSE, abs=1e-6)
    said = [finding.severity for finding in photometry.findings if finding.rule == "symmetry"]
    assert said == [severity]


def test_planes_that_are_missing_are_not_made_up(tmp_path):
    with pytest.raises(InputError, match=r"holds 7 planes, as symmetry indicator 4 has; .* needs 24"):
        read(tmp_path, counted(0, TURN, QUARTER, batwing))


def test_type_b_becomes_c_and_gamma(tmp_path):
    angles = np.arange(-90.0, 91.0, 5.0)

    def lobe(h: float, v: float) -> float:
        """cos of the angle to the beam axis, leaning up: depends on H and V by the coordinates' definition."""
        h, v = math.radians(h), math.radians(v)
        return max(0.0, math.cos(h) * math.cos(v)) + 0.3 * max(0.0, math.cos(h) * math.sin(v))

    text = ies(lobe, horizontal=angles, gamma=angles, kind=2, scale=1000.0)
    photometry = read(tmp_path, text, "flood.ies")
    for c, gamma in ((0, 0), (0, 30), (90, 30), (270, 30), (45, 60), (200, 75)):
        t, g = math.radians(c), math.radians(gamma)
        y, z = math.sin(g) * math.sin(t), math.cos(g)
        assert photometry.intensity(c, gamma) == pytest.approx(1000 * (z + 0.3 * max(0.0, y)), abs=4.0)
    # Half of the table where the other half mirrors it.
    half = ies(lobe, horizontal=angles[angles >= 0], gamma=angles, kind=2, scale=1000.0)
    assert luminous_flux(read(tmp_path, half, "half.ies")) == pytest.approx(
        luminous_flux(photometry), rel=CLOSE
    )


def test_tilt_factors_are_kept(tmp_path):
    photometry = read(tmp_path, CORPUS_IES[3], "a.ies")
    assert photometry.tilt.tolist() == [[0, 1], [45, 0.95], [90, 0.9]]
    assert photometry.format == "IES LM-63-1986"


def with_remarks(text: str) -> str:
    """What some editors write behind the numbers, and words where a factor is not known."""
    lines = text.split("\r\n")
    lines[32] = "n/a"
    return "\r\n".join(
        line + " ; remark 7" if number in {2, 3, 12} or (number > 42 and line) else line
        for number, line in enumerate(lines)
    )


@pytest.mark.parametrize(
    "spoil",
    [
        lambda text: text.replace("\r\n", "\n"),
        lambda text: text.replace("\r\n", "\r"),
        lambda text: text.replace("\r\n", "\r\r\n"),
        lambda text: text.replace("\r\n", "\n\n"),
        lambda text: "\ufeff" + text,
        lambda text: text + "\r\n\r\nexported by TOOL 3\r\n",
        lambda text: text + "\x1a\x1a",
        lambda text: text.replace("\r\n", " \t\r\n"),
        lambda text: text.replace(".", ","),
        lambda text: text.replace("panel", "Möbelleuchte ½", 1),
        lambda text: text.rstrip(),
        lambda text: text.replace("\r\n3000\r\n", "\r\n3000 lm\r\n").replace("\r\n620\r\n", "\r\n620mm\r\n"),
        with_remarks,
    ],
)
def test_habits_of_eulumdat_writers_change_nothing(tmp_path, spoil):
    expected = read(tmp_path, ldt(batwing))
    for encoding in ("utf-8", "utf-16"):
        found = read(tmp_path, spoil(ldt(batwing)).encode(encoding))
        assert np.array_equal(found.candela, expected.candela)
        assert found.opening == expected.opening


def test_a_power_in_words_is_no_reason_to_refuse_the_light(tmp_path):
    found = read(tmp_path, ldt(lamps=((1, "LED", 3000, "840", "1B", "see label"),)))
    assert luminous_flux(found) == pytest.approx(3000.0, rel=STEP_LOSS)
    assert (found.power, "watts" in rules(found)) == (0.0, True)


def test_a_blank_line_too_many_in_the_numbers_changes_nothing(tmp_path):
    lines = ldt(batwing).split("\r\n")
    spoilt = "\r\n".join([*lines[:15], "", *lines[15:]])
    # As an empty field the line would shift all that follow; the file only makes sense without it.
    found = read(tmp_path, spoilt)
    assert np.array_equal(found.candela, read(tmp_path, ldt(batwing)).candela)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.replace("\n", "\n\n"),
        lambda text: "\ufeff" + text,
        lambda text: text + "\n[END]\n",
        lambda text: text + "\x1a",
        lambda text: text.replace("TILT=NONE", "tilt = none "),
        lambda text: text.replace("TILT=NONE", "TILT=NONE ; no tilt"),
        lambda text: "\n\n\n" + text,
        lambda text: text.replace("[LUMCAT] P-600\n", ""),
        lambda text: text.replace("lelight tests", "Österreich"),
        lambda text: text[: text.index("TILT")] + text[text.index("TILT") :].replace(" ", ", "),
        lambda text: text[: text.index("TILT")] + text[text.index("TILT") :].replace(" ", "\t"),
        lambda text: text[: text.index("TILT")] + text[text.index("TILT") :].replace(" ", "\n"),
        lambda text: text.replace("IESNA:LM-63-2002", "IES:LM-63-2019"),
        lambda text: text.replace("IESNA:LM-63-2002\n", ""),
        lambda text: text.replace("1 1 25\n", "1 1 25 ; ballast\n"),
        lambda text: text[: text.index("TILT") + 9] + text[text.index("TILT") + 9 :].replace(".", ","),
    ],
)
def test_habits_of_lm63_writers_change_nothing(tmp_path, spoil):
    text = ies(batwing, horizontal=(0, 30, 60, 90))
    expected = read(tmp_path, text, "a.ies")
    found = read(tmp_path, spoil(text).encode("utf-8"), "b.ies")
    assert np.array_equal(found.candela, expected.candela)
    assert found.opening == expected.opening


@pytest.mark.parametrize(
    ("spoil", "rule"),
    [
        (lambda text: ldt(lambertian, per_klm=250.0), "flux"),
        (lambda text: ldt(lambda c, g: lambertian(c, g) + 0.2 * (c == 0 and g == 0)), "nadir"),
        (lambda text: ldt(gamma=[0, 10, 5, *range(15, 91, 5)]), "unsorted-angles"),
        (lambda text: ldt(gamma=[0, 5, 5, *range(10, 91, 5)]), "repeated-angles"),
        (lambda text: ldt(gamma=[0] * 19, symmetry=1), "missing-angles"),
        (lambda text: ldt(sizes=[0] * 9), "zero-size"),
        (lambda text: ldt(sizes=(600, 0, 80, 0, 300, 0, 0, 0, 0)), "one-sided-size"),
        (lambda text: ldt(sizes=(1200, 300, 80, 280, 1180, 0, 0, 0, 0)), "c0-opening"),
        (lambda text: ldt(lambda c, g: lambertian(c, g) + 1e-3), "false-uplight"),
        (lambda text: ldt(lambda c, g: lambertian(c, g) - 0.01), "negative-candela"),
        (lambda text: ldt(skew, symmetry=0).replace("\r\n0\r\n24\r\n", "\r\n4\r\n24\r\n", 1), "symmetry"),
        (lambda text: ies(batwing, horizontal=range(45, 136, 15)), "open-planes"),
        (lambda text: ldt(sizes=(-620, 320, 80, 600, 300, 0, 0, 0, 0)), "negative-size"),
    ],
)
def test_linter_names_what_is_wrong(tmp_path, spoil, rule):
    assert rule not in rules(read(tmp_path, ldt(symmetry=1)))
    assert rule in rules(read(tmp_path, spoil("")))


@pytest.mark.parametrize(
    ("content", "name", "words"),
    [
        (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", "a.ies", "binary"),
        (b"", "a.ldt", "empty"),
        (b"hello\nworld\n", "a.txt", "neither"),
        (b"hello\nworld\n", "a.ies", "TILT="),
        (ies(kind=3).encode(), "a.ies", "type A"),
        (ies().replace("37 1 1 2", "1000000000 1 1 2").encode(), "a.ies", "1000000000"),
        (ies()[:-200].encode(), "a.ies", "cut off"),
        (ies().replace("TILT=NONE", "TILT=lamp.tlt").encode(), "a.ies", "NONE or INCLUDE"),
        (ldt()[:-300].encode(), "a.ldt", "cut off"),
        (ldt().replace("\r\n24\r\n", "\r\n1000000000\r\n", 1).encode(), "a.ldt", "C planes"),
        (ldt().replace("\r\n24\r\n", "\r\nmany\r\n", 1).encode(), "a.ldt", "many"),
        (ies().replace("954.92", "nan", 1).encode(), "a.ies", "nan"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line_with_its_place(tmp_path, content, name, words):
    with pytest.raises(InputError, match=words) as failure:
        read(tmp_path, content, name)
    assert str(failure.value).startswith(str(tmp_path / name))
    assert "\n" not in str(failure.value)


@pytest.mark.parametrize("source", [*CORPUS_LDT, *CORPUS_IES])
@pytest.mark.parametrize("ending", [".ies", ".ldt"])
def test_written_and_read_again_is_the_same(tmp_path, source, ending):
    photometry = read(tmp_path, source)
    convert(photometry, tmp_path / f"out{ending}")
    again = read_photometry(tmp_path / f"out{ending}")
    c = np.arange(0.0, 360.0, 7.5)[:, None]
    gamma = np.arange(0.0, 180.0, 2.5)
    expected = photometry.intensity(c, gamma)
    # Seven digits are written, and in EULUMDAT of the flux as well.
    assert again.intensity(c, gamma) == pytest.approx(expected, rel=5e-6, abs=1e-6 * expected.max())
    assert again.power == photometry.power
    if photometry.opening.shape in {"rectangle", "point"}:
        assert again.opening.along_c0 == pytest.approx(photometry.opening.along_c0)


def test_conversion_says_what_is_lost(tmp_path):
    oval = read(tmp_path, ies(sizes=(-0.3, -0.6, 0)), "a.ies")
    assert any("ellipse" in lost for lost in convert(oval, tmp_path / "b.ldt"))
    assert any("lamp sets" in lost for lost in convert(read(tmp_path, CORPUS_LDT[3]), tmp_path / "b.ies"))
    with pytest.raises(InputError, match="allowed are"):
        convert(oval, tmp_path / "b.pdf")


@pytest.mark.parametrize(("intensity", "above"), [(wallwasher, False), (uplight, True)])
def test_polar_diagram_is_whole_with_nadir_below_and_c0_to_the_right(tmp_path, intensity, above):
    axes = Figure(figsize=(5, 5)).add_subplot(projection="polar")
    paint_polar(axes, polar_curves(read(tmp_path, ldt(intensity, symmetry=2))))
    curve = axes.lines[0]
    points = axes.transData.transform(np.column_stack([curve.get_xdata(), curve.get_ydata()]))
    right, up = (points - axes.transData.transform((0.0, 0.0)))[np.argmax(curve.get_ydata())]
    assert (up > 0) == above
    # The wall washer of the tests leans towards C0: largest at sin γ = 0.461, in steps of 5° at 25°.
    assert right == pytest.approx(0.0 if above else -up * math.tan(math.radians(25.0)), abs=1.0)
    assert (axes.get_thetamin(), axes.get_thetamax()) == (0.0, 360.0)


def test_mutated_files_read_or_fail_in_one_line(tmp_path):
    from fuzz_photometry import fuzz

    for corpus, ending in ((photofiles.CORPUS_IES, ".ies"), (photofiles.CORPUS_LDT, ".ldt")):
        read_some = fuzz(corpus, ending, count=300, seed=7, folder=tmp_path)
        assert 30 < read_some < 290
