"""Which MTL files an ``mtllib`` line means, none of them outside the folder of its OBJ."""

from __future__ import annotations

import re
from pathlib import Path

from lelight.errors import InputError
from lelight.reading.confinement import confined
from lelight.reading.inputfile import decoded, quoted

_NAMES_BY_ENDING = re.compile(r"\S.*?\.mtl(?=\s|$)", re.IGNORECASE)


def material_libraries(obj_path: Path, names: bytes, *, line: int) -> tuple[Path, ...]:
    """Find the files that the text after ``mtllib`` names.

    The line may hold one name with spaces or several names: the reading whose files all exist is taken.

    Raises
    ------
    InputError
        where a name leads out of the OBJ's folder, or no reading finds its files
    """
    text = decoded(names).replace("\\", "/").strip()
    if not text:
        raise InputError.at(obj_path, line, "mtllib: found no file name; allowed are names of MTL files")
    for reading in ([text], _NAMES_BY_ENDING.findall(text), text.split()):
        paths = [_confined(obj_path, name, line) for name in reading]
        if paths and all(map(_is_file, paths)):
            return tuple(paths)
    raise InputError.at(
        obj_path,
        line,
        f"mtllib: {quoted(text)} is not in the folder {obj_path.parent.resolve()}; put it there, or "
        "delete this line and give the materials in the scene's TOML file",
    )


def _confined(obj_path: Path, name: str, line: int) -> Path:
    path = confined(obj_path.parent, name)
    if path is None:
        message = (
            f"mtllib: {quoted(name)} leads out of the folder of the OBJ file; put the MTL file beside it"
        )
        raise InputError.at(obj_path, line, message)
    return path


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:
        return False
