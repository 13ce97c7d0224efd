"""Files that a file names stay in its folder: no ``..``, no absolute path, no link that leads out."""

from __future__ import annotations

from pathlib import Path, PureWindowsPath


def confined(folder: Path, name: str) -> Path | None:
    """Find the path of a file by the name that another file in ``folder`` gives it; None where it leads out."""
    if name.startswith("/") or PureWindowsPath(name).drive:
        return None
    try:
        inside = (folder / name).resolve().is_relative_to(folder.resolve())
    except ValueError:
        # No file has a name like that, so there is none to be found.
        return folder / name
    except (OSError, RuntimeError):
        return None
    return folder / name if inside else None
