"""A result folder as the reports see it: ``metrics.json`` and ``run.json``, and where the other files lie."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import lelight
from lelight.errors import OutputError
from lelight.reports.reading import Reading, readings_of
from lelight.reports.texts import Texts, read_texts
from lelight.resultfiles import METRICS, RUN, Kind, read_object

CALC = "`lelight calc SCENE -o OUT` writes it"


@dataclass(frozen=True)
class Subject:
    """A plane, an observer or the room, with the figures found for it.

    Attributes
    ----------
    stem : name of its files, without folder and suffix
    entry : its part of ``metrics.json`` as read, for what is not a figure (``grid``, ``sources``, ...)
    """

    name: str
    stem: str
    readings: tuple[Reading, ...]
    entry: Mapping[str, Any]


@dataclass(frozen=True)
class ResultFolder:
    """What ``lelight calc`` left in ``path``.

    Attributes
    ----------
    views : by observer, what is no single figure: the rose, statistics of luminance
    texts : the language in which it is reported on
    """

    path: Path
    run: Mapping[str, Any]
    planes: tuple[Subject, ...]
    observers: tuple[Subject, ...]
    room: Subject
    views: Mapping[str, Any]
    texts: Texts

    def file(self, *parts: str, remedy: str = CALC) -> Path:
        """Path of a file that must be there; one line says which command makes it where it is not."""
        path = self.path.joinpath(*parts)
        if not path.is_file():
            raise OutputError(f"{path}: missing; {remedy}")
        return path


def open_folder(path: Path, texts: Texts | None = None) -> ResultFolder:
    """Read the two JSON files of a result folder.

    Raises
    ------
    OutputError
        The folder or one of the files is missing, cannot be read as what it should be, or is of a newer version.
    """
    texts = texts or read_texts()
    if not path.is_dir():
        raise OutputError(f"{path}: no such result folder; `lelight calc SCENE -o {path}` makes it")
    run = _json_object(path / "run.json", RUN)
    _require_known_version(path / "run.json", run)
    metrics = _json_object(path / "metrics.json", METRICS)
    return ResultFolder(
        path=path,
        run=run,
        planes=_subjects(path, metrics, "planes", texts),
        observers=_subjects(path, metrics, "observers", texts),
        room=_subject(texts["room"], _object(path, metrics, "room"), texts),
        views=_object(path, metrics, "views"),
        texts=texts,
    )


def _require_known_version(path: Path, run: Mapping[str, Any]) -> None:
    """Refuse what a newer lelight wrote: it may hold what this one would leave out."""
    written = str(run.get("lelight") or "")
    if _release(written) > _release(lelight.__version__):
        raise OutputError(
            f"{path}: written by lelight {written}, newer than this one, {lelight.__version__}; "
            "update lelight, or `lelight calc SCENE -o OUT` writes the folder anew"
        )


def _release(version: str) -> tuple[int, ...]:
    """Leading numbers of a version; what follows them does not count."""
    numbers = re.match(r"\d+(?:\.\d+)*", version)
    return tuple(int(number) for number in numbers[0].split(".")) if numbers else ()


def _json_object(path: Path, kind: Kind) -> Mapping[str, Any]:
    if not path.is_file():
        raise OutputError(f"{path}: missing; {CALC}")
    return read_object(path, kind, remedy=f"{CALC} anew")


def _object(path: Path, parent: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    child = parent.get(key, {})
    if not isinstance(child, dict):
        raise OutputError(f"{path / 'metrics.json'}: {key!r} is not an object; {CALC} anew")
    return child


def _subjects(path: Path, metrics: Mapping[str, Any], group: str, texts: Texts) -> tuple[Subject, ...]:
    entries = _object(path, metrics, group)
    return tuple(_subject(name, _object(path, entries, name), texts) for name in entries)


def _subject(name: str, entry: Mapping[str, Any], texts: Texts) -> Subject:
    # The last part only: a name that looks like a path must not lead out of the folder.
    return Subject(name, Path(str(entry.get("file", name))).name, readings_of(entry, texts), entry)
