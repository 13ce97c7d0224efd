"""The checkpoint folder: ``run.json`` says which run it belongs to, numbered segments hold what that run found.

Segments are only ever added and, once all their records have been superseded, removed. Since work is the same
whenever it is done, any of them that are there are right, whatever was lost at whatever moment.
"""

from __future__ import annotations

import json
import re
import uuid
from contextlib import suppress
from pathlib import Path
from shutil import rmtree
from typing import Any

from lelight.checkpoint.identity import Identity, fingerprint
from lelight.checkpoint.records import Form, Found, Record
from lelight.checkpoint.segments import Segment, damaged, read_segment, write_segment
from lelight.errors import OutputError
from lelight.writing.files import TEMPORARY, make_folder, write_text

_SEGMENT = re.compile(r"[0-9]{6}\.kept")


class CheckpointFolder:
    """Owns a folder of segments; see the module.

    Attributes
    ----------
    path : the folder; it need not exist before something is written
    elapsed : seconds of work behind the newest segment
    seconds : likewise, by stage
    """

    def __init__(self, path: Path, identity: Identity) -> None:
        self.path = path
        self.elapsed = 0.0
        self.seconds: dict[str, float] = {}
        self._identity = identity
        self._run = fingerprint(identity)
        self._segments: dict[int, Segment] = {}
        self._holder: dict[str, int] = {}
        self._begun = False

    @property
    def exists(self) -> bool:
        """Whether a run left something here."""
        return (self.path / "run.json").exists()

    @property
    def holds_anything(self) -> bool:
        """Whether there is anything here that this run could go on with."""
        return self._begun and bool(self._holder) and self.exists

    def stored_identity(self) -> Identity:
        """Read which run the folder belongs to."""
        path = self.path / "run.json"
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            identity = {str(group): dict(table) for group, table in content["identity"].items()}
        except OSError as error:
            raise OutputError(f"{path}: cannot be read: {error.strerror or error}") from error
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise damaged(path) from error
        if content.get("sha256") != fingerprint(identity):
            raise damaged(path, "damaged: its checksum does not hold")
        return identity

    def open(self) -> None:
        """Take over what a run of the same identity left.

        Raises
        ------
        OutputError
            where a segment is damaged
        """
        self._begun = True
        for number, path in self._files().items():
            segment = read_segment(path)
            if segment.head.get("run") != self._run:
                raise damaged(path, "belongs to another run than the run.json beside it")
            self._take(number, segment)
            self.elapsed = _seconds(path, segment.head.get("elapsed"))
            stages = segment.head.get("seconds")
            if not isinstance(stages, dict):
                raise damaged(path)
            self.seconds = {str(stage): _seconds(path, spent) for stage, spent in stages.items()}
        for key in list(self._holder):
            if "/" not in key:
                self.drop(f"{key}/")

    def __contains__(self, key: str) -> bool:
        """Whether there is a record of this key."""
        return key in self._holder

    def unpacked(self, key: str, form: Form[Found]) -> Found:
        """Read back what a record was made of.

        Raises
        ------
        OutputError
            where the record is not of this form
        """
        segment = self._segments[self._holder[key]]
        try:
            return form.unpack(segment.read(key))
        except (KeyError, TypeError, ValueError) as error:
            raise damaged(segment.path, f"its record {key!r} is not what it should be") from error

    def write(self, records: dict[str, Record], *, elapsed: float, seconds: dict[str, float]) -> None:
        """Add a segment; its records supersede those of the same keys."""
        self._begin()
        number = max(self._segments, default=0) + 1
        path = self.path / f"{number:06}.kept"
        head = {"run": self._run, "elapsed": elapsed, "seconds": seconds}
        self._take(number, write_segment(path, head, records))

    def drop(self, prefix: str) -> None:
        """Forget the records whose keys begin so, and remove segments that hold nothing any more."""
        for key in [key for key in self._holder if key.startswith(prefix)]:
            self._release(key)

    def remove(self) -> None:
        """Take the whole folder away at once."""
        aside = self.path.with_name(f"{TEMPORARY}{uuid.uuid4().hex}")
        with suppress(OSError):
            self.path.rename(aside)
            rmtree(aside)
        self._begun = False

    def _begin(self) -> None:
        """Make the folder this run's, before its first segment."""
        if self._begun:
            return
        make_folder(self.path)
        with suppress(FileNotFoundError):
            (self.path / "run.json").unlink()
        for path in self._files().values():
            path.unlink()
        content = {"sha256": self._run, "identity": self._identity}
        write_text(self.path / "run.json", json.dumps(content, indent=1, ensure_ascii=False) + "\n")
        self._begun = True

    def _files(self) -> dict[int, Path]:
        """Segments on the disk by number, in order."""
        try:
            names = sorted(path.name for path in self.path.iterdir() if _SEGMENT.fullmatch(path.name))
        except OSError as error:
            raise OutputError(f"{self.path}: cannot be read: {error.strerror or error}") from error
        return {int(name[:6]): self.path / name for name in names}

    def _take(self, number: int, segment: Segment) -> None:
        self._segments[number] = segment
        for key in segment.entries:
            if key in self._holder:
                self._release(key)
            self._holder[key] = number

    def _release(self, key: str) -> None:
        number = self._holder.pop(key)
        if number not in self._holder.values():
            path = self._segments.pop(number).path
            with suppress(OSError):
                path.unlink()


def _seconds(path: Path, found: Any) -> float:
    if not isinstance(found, int | float) or not 0 <= found < float("inf"):
        raise damaged(path)
    return float(found)
