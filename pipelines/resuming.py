"""Where a run begins: anew, or where one that was stopped, killed or cut off has come to."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from lelight.checkpoint.folder import CheckpointFolder
from lelight.checkpoint.identity import Identity, differences, fingerprint
from lelight.errors import OutputError
from lelight.pipelines.results import read_run

#: Whether to go on with what is there: not; yes, or refuse where it is another run's; only where it is not.
Resume = Literal["no", "yes", "where it is the same"]


def checkpoint(
    out: Path, identity: Identity, *, resume: Resume, tell: Callable[[str], None]
) -> CheckpointFolder:
    """Open the checkpoint of a result folder: with what is in it, or to be begun anew.

    Parameters
    ----------
    tell : told in a line what was found there

    Raises
    ------
    OutputError
        where what is there is damaged, or belongs to a run that differs in something, which is named
    """
    folder = CheckpointFolder(out / "checkpoint", identity)
    if resume == "where it is the same" and folder.exists:
        resume = "no" if differences(folder.stored_identity(), identity) else "yes"
    if resume == "no":
        if folder.exists:
            tell(
                f"warning: {folder.path} holds an unfinished run, which --resume goes on with; this one replaces it"
            )
        return folder
    if not folder.exists:
        tell(f"nothing to resume in {out}: beginning anew")
        return folder
    if found := differences(folder.stored_identity(), identity):
        raise OutputError(
            f"{folder.path}: belongs to another run: {', '.join(found)}; make it as it was, or run without "
            "--resume, which begins anew"
        )
    folder.open()
    tell(f"going on after {folder.elapsed:.0f} s of work kept in {folder.path}")
    return folder


def is_finished(out: Path, identity: Identity) -> bool:
    """Say whether a result folder holds what a run of this identity would give, whole."""
    try:
        return read_run(out).get("fingerprint") == fingerprint(identity)
    except OutputError:
        return False
