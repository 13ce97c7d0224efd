"""Pictures: EXR and HDR come back, evalglare agrees, false colour tells what it clips."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from radianceprograms import environment, program

from lelight.camera import Fisheye, as_picture
from lelight.errors import OutputError
from lelight.writing.falsecolour import Marks, decade_limits, scale_ticks, write_falsecolour
from lelight.writing.pictures import read_exr, write_exr
from lelight.writing.radiancehdr import scanlines, shared_exponent, write_hdr

VIEW = "-vta -vp 0 0 1.2 -vd 1 0 0 -vu 0 0 1 -vh 180 -vv 180"


def gradient(height=20, width=300):
    """Five decades with an exact zero."""
    luminance = np.logspace(-1, 4, height * width).reshape(height, width)
    luminance[0, 0] = 0
    return luminance


def test_exr_keeps_every_float_and_says_what_it_is(tmp_path):
    luminance = gradient().astype(np.float32)
    luminance[3, 4] = np.nan
    path = tmp_path / "Schreibtisch ü.exr"
    write_exr(path, luminance, view=VIEW)
    picture = OpenImageIO.ImageInput.open(str(path))
    spec = picture.spec()
    assert (spec.width, spec.height, spec.channelnames) == (300, 20, ("Y",))
    assert str(spec.format) == "float"
    assert spec.getattribute("radiance_view") == VIEW and spec.getattribute("unit") == "cd/m2"
    picture.close()
    np.testing.assert_array_equal(read_exr(path), np.nan_to_num(luminance))


def test_an_exr_that_is_missing_damaged_or_in_colour_is_refused(tmp_path):
    with pytest.raises(OutputError, match=r"gone\.exr: cannot be read") as caught:
        read_exr(tmp_path / "gone.exr")
    assert "\n" not in str(caught.value)
    path = tmp_path / "half.exr"
    write_exr(path, gradient(), view=VIEW)
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(OutputError, match=r"half\.exr"):
        read_exr(path)
    colour = OpenImageIO.ImageOutput.create(str(tmp_path / "colour.exr"))
    colour.open(str(tmp_path / "colour.exr"), OpenImageIO.ImageSpec(4, 4, 3, OpenImageIO.FLOAT))
    colour.write_image(np.ones((4, 4, 3), dtype=np.float32))
    colour.close()
    with pytest.raises(OutputError, match="has the channels R, G, B"):
        read_exr(tmp_path / "colour.exr")


def test_pictures_need_their_folder(tmp_path):
    for write, name in ((write_exr, "a.exr"), (write_hdr, "a.hdr")):
        with pytest.raises(OutputError, match="folder does not exist"):
            write(tmp_path / "gone" / name, gradient(), view=VIEW)


@pytest.mark.parametrize("width", [5, 8, 127, 128, 129, 300])
def test_hdr_reads_back_within_the_precision_of_its_mantissas(tmp_path, width):
    luminance = gradient(11, width)
    luminance[2, 3] = np.nan
    path = tmp_path / "desk 1.hdr"
    write_hdr(path, luminance, view=VIEW)
    found = OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.FLOAT)
    assert found.shape == (11, width, 3)
    # OpenImageIO takes mantissas, 128 to 255, as they are, and they were rounded down.
    shown = 179 * found @ np.array([0.265, 0.670, 0.065])
    expected = np.nan_to_num(luminance)
    np.testing.assert_array_less(shown, expected * (1 + 1e-6) + 1e-30)
    np.testing.assert_array_less(expected * (1 - 1 / 128) - 1e-30, shown)


def test_hdr_has_the_header_that_radiance_reads(tmp_path):
    write_hdr(tmp_path / "a.hdr", gradient(4, 9), view=VIEW)
    header = (tmp_path / "a.hdr").read_bytes().split(b"\n\n")[0].decode().splitlines()
    assert header == [
        "#?RADIANCE",
        "SOFTWARE=lelight",
        f"VIEW= {VIEW}",
        "EXPOSURE=1.0",
        "FORMAT=32-bit_rle_rgbe",
    ]


def test_shared_exponents_of_known_radiances():
    # 1 = 0.5 * 2^1: mantissa 128, exponent byte 129. 0.75 = 0.75 * 2^0: 192, 128. 3 = 0.75 * 2^2.
    radiance = np.array([[1, 1, 1], [0.75, 0.375, 0], [3, 1, 0.01], [0, 0, 0], [1e-40, 0, 0]])
    expected = [[128, 128, 128, 129], [192, 96, 0, 128], [192, 64, 0, 130], [0, 0, 0, 0], [0, 0, 0, 0]]
    np.testing.assert_array_equal(shared_exponent(radiance), expected)


def test_a_scanline_is_four_literal_channels():
    pixels = np.arange(4 * 130, dtype=np.uint8).reshape(1, 130, 4)
    encoded = scanlines(pixels)
    assert encoded[:4] == bytes([2, 2, 0, 130])
    red = pixels[0, :, 0].tobytes()
    assert encoded[4 : 4 + 132] == bytes([128]) + red[:128] + bytes([2]) + red[128:]
    assert len(encoded) == 4 + 4 * 132


def evalglare(picture: Path) -> dict[str, float]:
    """Figures that evalglare prints, by name."""
    run = subprocess.run(
        [program("evalglare"), "-d", picture],
        capture_output=True,
        text=True,
        check=True,
        env=environment(),
    )
    assert run.stderr == ""
    names, numbers = run.stdout.splitlines()[-1].split(":")
    return dict(zip(names.split(","), map(float, numbers.split()), strict=True))


def disc(camera, size, *, elevation, half_angle, luminance, field):
    """Luminance of a uniform field with a disc at an elevation over the line of sight, in degrees."""
    _, directions = camera.rays(size, size)
    angle = np.radians(elevation)
    towards = np.array([np.cos(angle), 0, np.sin(angle)])
    return np.where(directions @ towards > np.cos(np.radians(half_angle)), luminance, field)


def test_evalglare_reads_the_picture_and_finds_the_same_light(tmp_path):
    camera = Fisheye(np.array([0, 0, 1.2]), np.array([1.0, 0, 0]))
    size = 1000
    mask = camera.mask(size, size)
    luminance = disc(camera, size, elevation=20, half_angle=5, luminance=10001.6, field=100.338)
    write_hdr(tmp_path / "disc.hdr", as_picture(luminance, mask), view=camera.view(size, size))
    figures = evalglare(tmp_path / "disc.hdr")
    _, directions = camera.rays(size, size)
    vertical_illuminance = (luminance * directions[:, 0]) @ camera.solid_angles(size, size)[mask]
    assert figures["E_v"] == pytest.approx(vertical_illuminance, rel=5e-3)
    # Closed form with B = 100.338, L = 10001.6, omega = 2 pi (1 - cos 5°) = 0.023909 sr and Guth's index
    # p = 2.1460 at 20° above the axis: Ev = pi B + (L - B) pi sin²5° cos 20° = 537.25 lx,
    # UGR = 8 lg(0.25/B L² omega/p²) = 24.920. evalglare takes p at a truncated pixel, 2.1360: 24.953.
    assert figures["E_v"] == pytest.approx(537.25, rel=1e-4)
    assert figures["ugr"] == pytest.approx(24.953, abs=1e-3)
    assert figures["dgp"] == pytest.approx(0.25573, abs=1e-5)


def test_false_colour_is_a_png_with_the_same_bytes_every_time(tmp_path):
    luminance = gradient(60, 80)
    luminance[:5] = np.nan
    for name in ("a.png", "b.png"):
        write_falsecolour(tmp_path / name, luminance, title="Büro $x_{ \\frac 日本\n2")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("luminance", [np.zeros((8, 8)), np.full((8, 8), np.nan), np.full((2, 900), 7.0)])
def test_false_colour_draws_what_is_dark_empty_or_flat(tmp_path, luminance):
    write_falsecolour(tmp_path / "a.png", luminance, title="")
    assert (tmp_path / "a.png").stat().st_size > 1000


def covered(path, colour):
    """Pixels of a PNG that have exactly this colour."""
    pixels = (255 * OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.FLOAT)[..., :3]).round()
    return int(np.all(pixels == colour, axis=-1).sum())


@pytest.mark.parametrize(
    ("limits", "below", "above"),
    [((1, 1000), False, False), ((10, 1000), True, False), ((1, 100), False, True), ((10, 100), True, True)],
)
def test_what_the_scale_clips_has_colours_of_its_own(tmp_path, limits, below, above):
    # A third of the picture has each value; the lettering holds a few pixels of the same grey.
    luminance = np.tile([[5.0, 50.0, 500.0]], (9, 3))
    write_falsecolour(tmp_path / "a.png", luminance, title="", limits=limits)
    third = 600 * 600 / 3
    for colour, expected in (((105, 105, 105), below), ((215, 25, 28), above)):
        count = covered(tmp_path / "a.png", colour)
        assert count > 0.95 * third if expected else count < 0.01 * third


@pytest.mark.parametrize(
    ("darkest", "brightest", "limits"),
    [
        (0.5, 950, (0.3, 1000)),  # between three and four decades: just below the darkest
        (1e-5, 900, (0.1, 1000)),  # never more than four
        (500, 2900, (3, 3000)),  # never less than three
        (1, 1000, (1, 1000)),
        (3, 3000, (3, 3000)),
        (np.nan, 0, (1e-3, 1)),
    ],
)
def test_default_limits_are_of_the_series_1_3_10(darkest, brightest, limits):
    luminance = np.repeat([0.0, darkest, brightest], 50)
    assert decade_limits(luminance) == pytest.approx(limits, rel=1e-12)


def test_a_scale_of_given_decades_has_these():
    luminance = np.repeat([0.5, 950.0], 50)
    assert decade_limits(luminance, decades=2) == pytest.approx((10, 1000), rel=1e-12)


def test_isolines_run_where_the_luminance_is_crossed(tmp_path):
    # Luminance rises from left to right by a decade; 30 is crossed in the middle third, 200 and nan nowhere.
    luminance = np.tile(np.logspace(1, 2, 120), (120, 1))
    luminance[:10] = np.nan
    pictures = {}
    for name, values in (("plain", None), ("line", (30.0,)), ("none", (200.0,)), ("legend", ())):
        marks = Marks(extremes=False, isolines=values)
        write_falsecolour(tmp_path / f"{name}.png", luminance, title="", marks=marks)
        pictures[name] = OpenImageIO.ImageBuf(str(tmp_path / f"{name}.png")).get_pixels(OpenImageIO.FLOAT)
    np.testing.assert_array_equal(pictures["none"], pictures["plain"])
    columns = np.flatnonzero(np.any(pictures["line"] != pictures["plain"], axis=(0, 2)))
    # log10(30) - 1 = 0.477 of the width, 600 pixels wide after a margin of 24; the value stands on the line.
    assert abs(np.median(columns) - (24 + 0.477 * 600)) < 15
    assert np.ptp(columns) < 60
    np.testing.assert_array_equal(pictures["legend"], pictures["line"])


def test_extremes_are_marked_unless_not_wanted(tmp_path):
    sizes = []
    for extremes in (True, False):
        write_falsecolour(tmp_path / "a.png", gradient(60, 80), title="", marks=Marks(extremes=extremes))
        sizes.append((tmp_path / "a.png").read_bytes())
    assert sizes[0] != sizes[1]


def test_a_picture_without_a_radiance_view_names_none(tmp_path):
    write_hdr(tmp_path / "a.hdr", gradient(4, 9), view="")
    assert b"VIEW" not in (tmp_path / "a.hdr").read_bytes()
    write_exr(tmp_path / "a.exr", gradient(4, 9), view="")
    picture = OpenImageIO.ImageInput.open(str(tmp_path / "a.exr"))
    assert picture.spec().getattribute("radiance_view") is None
    picture.close()


def test_a_single_glint_does_not_move_the_scale():
    assert decade_limits(np.append(np.full(5000, 90.0), 1e6)) == pytest.approx((0.1, 100), rel=1e-12)


def test_ticks_are_1_3_10():
    np.testing.assert_allclose(scale_ticks(0.3, 30), [0.3, 1, 3, 10, 30], rtol=1e-12)


def test_limits_that_cannot_be_are_refused(tmp_path):
    for limits in ((0.0, 1.0), (10.0, 1.0)):
        with pytest.raises(ValueError, match="limits"):
            write_falsecolour(tmp_path / "a.png", np.ones((4, 4)), title="", limits=limits)
