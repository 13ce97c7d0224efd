"""What a run depends on to the last bit: scene files, settings and versions; and how two runs differ in it."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from lelight.scene import Scene
from lelight.settings import Settings
from lelight.versions import versions

#: Groups of names and values.
Identity = dict[str, dict[str, Any]]

#: Settings that change no bit.
WITHOUT_EFFECT = ("threads", "memory", "cluster")
#: Longest piece of a value that a difference repeats.
LONGEST = 40


def identity_of(scene: Scene, settings: Settings) -> Identity:
    """Gather what the bits of a run depend on.

    Parameters
    ----------
    scene : as read, with hashes of its files
    settings : with those of the scene file
    """
    table = settings.as_table()
    return {
        "versions": versions(),
        "settings": {name: value for name, value in table.items() if name not in WITHOUT_EFFECT},
        "files": dict(scene.files),
    }


def fingerprint(identity: Identity) -> str:
    """SHA-256 of an identity, in hexadecimal."""
    text = json.dumps(identity, sort_keys=True, ensure_ascii=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def differences(before: Identity, now: Identity) -> list[str]:
    """Name everything in which two runs differ, in words."""
    found = []
    for group, told in (("files", _file), ("settings", _setting), ("versions", _version)):
        one, other = before.get(group, {}), now.get(group, {})
        for name in sorted({*one, *other}):
            if name not in one or name not in other or one[name] != other[name]:
                found.append(told(name, one.get(name), other.get(name)))
    return found


def _file(name: str, before: Any, now: Any) -> str:
    if before is None or now is None:
        return f"file {name} was {'not there' if before is None else 'there'}"
    return f"file {name} has changed"


def _setting(name: str, before: Any, now: Any) -> str:
    return f"--{name} was {_short(before)}, is {_short(now)}"


def _version(name: str, before: Any, now: Any) -> str:
    return f"{name} was version {_short(before)}, is {_short(now)}"


def _short(value: Any) -> str:
    text = "not given" if value is None else str(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
