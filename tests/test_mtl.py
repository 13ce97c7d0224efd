"""MTL files: four keys kept as written, the rest said once, mistakes by line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lelight.errors import InputError
from lelight.reading.mtl import MtlLibrary, read_mtl


def read(folder: Path, contents: bytes) -> MtlLibrary:
    path = folder / "Büro 1.mtl"
    path.write_bytes(contents)
    return read_mtl(path)


def test_values_stay_as_written(tmp_path: Path) -> None:
    text = "# by hand\r\nnewmtl weiße Wand\r\n\tKd 0.1234567890123456 0.2 1e-1\r\nKs 0.05\r\nNs 96.078431\r\n"
    library = read(tmp_path, (text + "newmtl lamp\nKe 12000 11000 1e4\n").encode())
    wall, lamp = library.materials["weiße Wand"], library.materials["lamp"]
    assert wall.diffuse is not None
    assert wall.specular is not None
    assert lamp.luminance is not None
    assert wall.diffuse.tolist() == [0.1234567890123456, 0.2, 0.1]
    assert wall.specular.tolist() == [0.05, 0.05, 0.05]
    assert wall.exponent == 96.078431
    assert wall.luminance is None
    assert (wall.line, lamp.line) == (2, 6)
    assert lamp.luminance.tolist() == [12000, 11000, 10000]
    assert (lamp.diffuse, lamp.specular, lamp.exponent) == (None, None, None)
    assert library.warnings == ()


def test_keys_without_photometric_meaning_are_said_once(tmp_path: Path) -> None:
    text = b"newmtl a\nKd 0.5\nd 1\nTr 0\nillum 2\nmap_Kd wood.png\nnewmtl b\nillum 2\nd 1\n"
    assert read(tmp_path, text).warnings == (
        "Büro 1.mtl: d, Tr, illum, map_Kd carry no photometric meaning here and are ignored",
    )


def test_repeated_material_is_said_and_the_last_counts(tmp_path: Path) -> None:
    library = read(tmp_path, b"newmtl a\nKd 0.5\nKs 0.1\nnewmtl a\nKd 0.25\n")
    assert library.warnings == ('Büro 1.mtl:4: newmtl "a" again; the last one counts',)
    material = library.materials["a"]
    assert material.diffuse is not None
    assert material.diffuse.tolist() == [0.25] * 3
    assert material.specular is None


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (b"Kd 0.5 0.5", '2: Kd: found "0.5 0.5"; allowed are one or three numbers, 0 or more'),
        (b"Kd spectral wall.rfl", '2: Kd: found "spectral"; allowed are numbers'),
        (b"Kd", '2: Kd: found ""; allowed are one or three numbers'),
        (b"Ke 1 nan 1", '2: Ke: found "1 nan 1"; allowed are finite numbers'),
        (b"Ks -0.1", '2: Ks: found "-0.1"; allowed are one or three numbers, 0 or more'),
        (b"Ns 1 2", '2: Ns: found "1 2"; allowed is one number, 0 or more'),
        (b"Ns inf", '2: Ns: found "inf"; allowed are finite numbers'),
        (b"newmtl", "2: newmtl: found no name; allowed is the name that usemtl gives"),
        (b"Kd 0,5", '2: Kd: found "0,5"; allowed are numbers like 0.25 or 1e-3'),
    ],
)
def test_mistakes_name_their_line(tmp_path: Path, line: bytes, says: str) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, b"newmtl a\n" + line)
    assert str(caught.value).startswith(f"{tmp_path / 'Büro 1.mtl'}:{says}")


def test_value_before_any_material_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r":1: Kd: found before any newmtl; allowed is a newmtl line first$"):
        read(tmp_path, b"Kd 0.5\nnewmtl a\n")


def test_mutated_files_are_read_or_refused_in_one_line(tmp_path: Path) -> None:
    sample = "newmtl weiß\nKd 0.5 0.4 0.3\nKs 0.1\nNs 20 \\\n\nKe 1e3 0 0\nillum 2\n".encode()
    rng = np.random.default_rng(2)
    outcomes = {"read": 0, "refused": 0}
    for _ in range(300):
        text = bytearray(sample)
        for place in rng.integers(len(sample), size=3):
            text[place] = rng.integers(256)
        try:
            library = read(tmp_path, bytes(text))
        except InputError as error:
            assert str(error).isprintable()
            outcomes["refused"] += 1
        else:
            colours = [material.diffuse for material in library.materials.values()]
            assert all(colour is None or (np.isfinite(colour) & (colour >= 0)).all() for colour in colours)
            outcomes["read"] += 1
    assert min(outcomes.values()) > 30
