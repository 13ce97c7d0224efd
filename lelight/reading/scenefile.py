"""Scene files (TOML): read, checked, and refused in one line that names the key."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from lelight.errors import InputError
from lelight.reading.inputfile import LONGEST_QUOTE, file_contents, quoted
from lelight.reading.scenetables import SceneTables

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_TOML_PLACE = re.compile(r" \(at line (\d+), column \d+\)$")


def read_scene_file(path: Path) -> SceneTables:
    """Read and check a scene file.

    Raises
    ------
    InputError
        with the line of a TOML mistake, or the dotted key, what was found and what is allowed
    """
    tables = _toml(path)
    try:
        return SceneTables.model_validate(tables)
    except ValidationError as error:
        raise InputError.at(path, None, complaint(error)) from None
    except RecursionError:
        raise InputError.at(path, None, "tables are nested too deeply") from None


def _toml(path: Path) -> dict[str, Any]:
    contents = file_contents(path)
    try:
        text = contents.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = contents.count(b"\n", 0, error.start) + 1
        raise InputError.at(path, line, "is not UTF-8 text; save the file as UTF-8") from None
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError.at(path, None, "tables are nested too deeply") from None
    except ValueError as error:
        raise _syntax_error(path, text, str(error)) from None


def _syntax_error(path: Path, text: str, message: str) -> InputError:
    place = _TOML_PLACE.search(message)
    at_end = text.count("\n") + 1 if message.endswith("(at end of document)") else None
    line = int(place[1]) if place else at_end
    what = message.partition(" (at ")[0]
    return InputError.at(path, line, f"not TOML: {quoted(what)[1:-1]}")


def complaint(error: ValidationError) -> str:
    """First of a validation's mistakes as ``key: found ..., allowed ...``."""
    mistake = error.errors(include_url=False)[0]
    context = mistake.get("ctx", {})
    place = [*mistake["loc"], *([context["key"]] if "key" in context else [])]
    if mistake["type"] == "unknown_key":
        return f"{dotted(place)}: unknown key; {context['reason']}"
    if mistake["type"] == "missing":
        return f"{dotted(place)}: is missing; add it"
    found = quoted(context["name"]) if "name" in context else _shown(mistake["input"])
    return f"{dotted(place)}: found {found}; {_allowed(mistake['msg'])}"


def _allowed(message: str) -> str:
    """Pydantic's message in our words."""
    message = message.removeprefix("Value error, ")
    for theirs, ours in (("Input should be", "allowed is"), ("String should", "the text should")):
        message = message.replace(theirs, ours)
    return re.sub(r"a valid dictionary.*", "a table", message).replace("valid list", "list of tables")


def _shown(found: object) -> str:
    if isinstance(found, dict):
        return quoted(", ".join(f"{key} = {item}" for key, item in found.items()))
    return quoted(found) if isinstance(found, str) else quoted(found)[1:-1]


def dotted(place: list[int | str]) -> str:
    """Key as TOML writes it, ``materials."floor*".reflectance``; entries of an array count from 0."""
    text = ""
    for step in place:
        if isinstance(step, int):
            text += f"[{step}]"
        else:
            bare = _BARE_KEY.fullmatch(step) and len(step) <= LONGEST_QUOTE
            key = step if bare else quoted(step)
            text += f".{key}" if text else key
    return text or "the file"
