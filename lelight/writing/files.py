"""Files appear whole or not at all, under names that are safe whatever the user called things."""

from __future__ import annotations

import errno
import os
import unicodedata
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import rmtree

from lelight.errors import OutputError

#: Longest safe name in bytes of UTF-8: room for a suffix and a number within the usual limit of 255.
NAME_BYTES = 120

#: What the names of files begin with that are not whole yet.
TEMPORARY = ".lelight-"
#: Files that are being written now.
_UNFINISHED: set[Path] = set()

#: What a name keeps beside letters, marks and digits of any script.
_KEPT_SIGNS = frozenset(" -_.,+=@()")

#: Device names that Windows, and shares mounted from it, refuse with any suffix.
_RESERVED = frozenset(
    ["con", "prn", "aux", "nul"] + [f"{port}{number}" for port in ("com", "lpt") for number in range(1, 10)]
)

_REMEDIES = {
    errno.ENOSPC: "the disk is full: free some space or choose another folder with -o",
    errno.EDQUOT: "the disk quota is used up: free some space or choose another folder with -o",
    errno.EFBIG: "larger than a file may be here (ulimit -f): raise the limit or choose another folder with -o",
    errno.EACCES: "permission denied: choose a folder that you may write to with -o",
    errno.EPERM: "permission denied: choose a folder that you may write to with -o",
    errno.EROFS: "the file system is read-only: choose another folder with -o",
    errno.ENOENT: "its folder does not exist any more: create it and run again",
    errno.ENOTDIR: "a part of its path is a file, not a folder: choose another folder with -o",
    errno.EEXIST: "a file stands where the folder should be: move it away or choose another folder with -o",
    errno.EISDIR: "a folder has this name: move it away or choose another folder with -o",
    errno.ENAMETOOLONG: "the path is too long: choose a shorter folder name with -o",
}


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yield a path beside ``path`` to write to, and rename it to ``path`` once it is safely on the disk.

    The yielded file exists, is empty and has the suffix of ``path``. When the block fails it is removed, and
    what stood at ``path`` before stands there still.

    Raises
    ------
    OutputError
        for every OSError of the block, in one line with the remedy
    """
    beside = path.with_name(f"{TEMPORARY}{uuid.uuid4().hex}{path.suffix}")
    _UNFINISHED.add(beside)
    try:
        beside.touch(exist_ok=False)
        yield beside
        _flush_to_disk(beside)
        beside.replace(path)
        _flush_folder(path.parent)
    except OSError as error:
        raise OutputError(_explain(path, error)) from error
    finally:
        with suppress(OSError):
            beside.unlink()
        _UNFINISHED.discard(beside)


def discard_unfinished() -> None:
    """Remove what `whole` is writing in any thread: for a process that ends without unwinding."""
    for beside in tuple(_UNFINISHED):
        with suppress(OSError):
            beside.unlink()


def write_text(path: Path, text: str) -> None:
    """Write ``text`` as UTF-8 with bare line feeds, whole or not at all."""
    with whole(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")


def make_folder(path: Path) -> Path:
    """Create ``path`` and what is missing above it, and give it back."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(_explain(path, error)) from error
    return path


def safe_name(name: str) -> str:
    """Turn a name that a user chose into a file stem that is harmless on every file system.

    Letters of every script stay (in Unicode's composed form NFC); separators, control characters, quotes and
    signs with a meaning to shells become ``_``; nothing leading makes a hidden file or an option.

    Examples
    --------
    >>> safe_name("Büro 1/2"), safe_name("../etc"), safe_name("")
    ('Büro 1_2', '_etc', 'unnamed')
    """
    kept = "".join(_kept_or_underscore(sign) for sign in unicodedata.normalize("NFC", name))
    stem = " ".join(kept.split()).lstrip(".- ").rstrip(". ")
    if stem.split(".")[0].strip().casefold() in _RESERVED:
        stem = f"_{stem}"
    return _shortened(stem, NAME_BYTES) or "unnamed"


def safe_names(names: Iterable[str]) -> tuple[str, ...]:
    """Make names safe and different from each other even where case does not count.

    The first of several equal names keeps it, the next ones get ``-2``, ``-3``: a name's result does not
    depend on what follows it.
    """
    taken: set[str] = set()
    unique = []
    for name in names:
        stem = _untaken(safe_name(name), taken)
        taken.add(stem.casefold())
        unique.append(stem)
    return tuple(unique)


def _untaken(stem: str, taken: set[str]) -> str:
    candidate, number = stem, 1
    while candidate.casefold() in taken:
        number += 1
        ending = f"-{number}"
        candidate = _shortened(stem, NAME_BYTES - len(ending)) + ending
    return candidate


def _kept_or_underscore(sign: str) -> str:
    if sign.isspace():
        return " "
    is_word = unicodedata.category(sign)[0] in "LMN"
    return sign if is_word or sign in _KEPT_SIGNS else "_"


def _shortened(stem: str, size: int) -> str:
    return stem.encode()[:size].decode(errors="ignore").rstrip(". ")


def remove_temporary(folder: Path) -> None:
    """Remove what a run that was killed left half written in a folder and those in it; which is no file of theirs."""
    for path in [*folder.glob(f"{TEMPORARY}*"), *folder.glob(f"*/{TEMPORARY}*")]:
        with suppress(OSError):
            rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


def _flush_to_disk(path: Path) -> None:
    with path.open("rb") as stream:
        os.fsync(stream.fileno())


def _flush_folder(folder: Path) -> None:
    """Make a rename last through a loss of power; some file systems cannot flush folders and need not."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _explain(path: Path, error: OSError) -> str:
    remedy = _REMEDIES.get(error.errno or 0) or error.strerror or str(error)
    return f"{path}: cannot be written: {remedy}"
