"""Damage to text files, by seed: what mail programs, editors, converters and enemies do to them."""

from __future__ import annotations

import numpy as np

#: Pieces that break readers.
POISON = (
    b"nan", b"inf", b"-inf", b"1e999", b"-1", b"0", b"1e300", b"1000000000", b"999999999999999999999999",
    b"0x10", b"1_000", b",", b"1,5", b"", b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"TILT=NONE", b"TILT=INCLUDE",
    b"TILT=../../x", b"-0.0", b"1e-320", b"[MORE]", b"\t", b"\x1a", b"\r\r\n", b"2.5", b"360", b"181", b"1d5", b"4",
    b"\xc3", b"+", b"%s",
)  # fmt: skip


#: Pieces that break readers of scenes and results.
POISON_OF_SCENES = (
    *POISON, b"1e308", b"-0", b"[[", b"]]", b"{", b"}", b'"', b"=", b"[materials]", b"[[luminaires]]", b"null",
    b"true", b"[[[[[[[[", b"f 1 1 1", b"f 1 2 3 4 5 6 7", b"f -1 -2 -3", b"f 1//2 2/3 3", b"v 1 2", b"usemtl", b"\\",
    b"mtllib ../../etc/passwd", b"mtllib /etc/passwd", b"newmtl x", b"Kd 1e9 0 0", b"Kd -1", b"Ke 1e30", b"Ns 1e9",
    b'geometry = "../x.obj"', b"unit = 3", b'"*" = { reflectance = 2 }', b"9" * 5000, b"a" * 5000, b"\xed\xa0\x80",
)  # fmt: skip


def mutated(source: bytes, rng: np.random.Generator, poison: tuple[bytes, ...] = POISON) -> bytes:
    """Damage a file in one to three places."""
    for _ in range(int(rng.integers(1, 4))):
        damage = _DAMAGES[int(rng.integers(len(_DAMAGES)))]
        source = damage(source, rng, poison) if damage in _POISONINGS else damage(source, rng)
    return source


def _at(source: bytes, rng: np.random.Generator) -> int:
    return int(rng.integers(len(source) + 1))


def _truncated(source: bytes, rng: np.random.Generator) -> bytes:
    return source[: _at(source, rng)]


def _flipped(source: bytes, rng: np.random.Generator) -> bytes:
    k = _at(source, rng)
    return source[:k] + bytes([int(rng.integers(256))]) + source[k + 1 :]


def _poisoned_line(source: bytes, rng: np.random.Generator, poison: tuple[bytes, ...]) -> bytes:
    lines = source.split(b"\n")
    lines[int(rng.integers(len(lines)))] = poison[int(rng.integers(len(poison)))]
    return b"\n".join(lines)


def _poisoned_token(source: bytes, rng: np.random.Generator, poison: tuple[bytes, ...]) -> bytes:
    tokens = source.split(b" ")
    tokens[int(rng.integers(len(tokens)))] = poison[int(rng.integers(len(poison)))]
    return b" ".join(tokens)


def _line_dropped(source: bytes, rng: np.random.Generator) -> bytes:
    lines = source.split(b"\n")
    del lines[int(rng.integers(len(lines)))]
    return b"\n".join(lines)


def _line_repeated(source: bytes, rng: np.random.Generator) -> bytes:
    lines = source.split(b"\n")
    k = int(rng.integers(len(lines)))
    return b"\n".join(lines[:k] + lines[k : k + 1] * int(rng.integers(2, 5)) + lines[k:])


def _lines_exchanged(source: bytes, rng: np.random.Generator) -> bytes:
    lines = source.split(b"\n")
    i, j = rng.integers(len(lines), size=2)
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def _inserted(source: bytes, rng: np.random.Generator, poison: tuple[bytes, ...]) -> bytes:
    k = _at(source, rng)
    return source[:k] + poison[int(rng.integers(len(poison)))] + source[k:]


def _digits_changed(source: bytes, rng: np.random.Generator) -> bytes:
    digits = [k for k, byte in enumerate(source) if 48 <= byte <= 57]
    if not digits:
        return source
    k = digits[int(rng.integers(len(digits)))]
    return source[:k] + str(int(rng.integers(10**6))).encode() + source[k + 1 :]


def _line_ends(source: bytes, rng: np.random.Generator) -> bytes:
    ends = (b"\r", b"\n", b"\r\n", b"\r\r\n", b"\n\n", b"\x0b", b"\x0c", b" \n")
    return source.replace(b"\r\n", b"\n").replace(b"\n", ends[int(rng.integers(len(ends)))])


_DAMAGES = (
    _truncated, _flipped, _poisoned_line, _poisoned_line, _poisoned_token, _poisoned_token, _line_dropped,
    _line_repeated, _lines_exchanged, _inserted, _digits_changed, _digits_changed, _line_ends,
)  # fmt: skip
_POISONINGS = (_poisoned_line, _poisoned_token, _inserted)
