"""What the reports share: open the folder, put cover and content together, write the PDF."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from lelight.reports.document import write_document
from lelight.reports.folder import ResultFolder, open_folder
from lelight.reports.summary import cover

Figures = dict[str, bytes]


def write_report(
    out: Path,
    name: str,
    content_of: Callable[[ResultFolder], tuple[dict[str, Any], Figures]],
    *,
    kind: str,
    title: str | None,
    author: str | None,
    paper: str,
) -> Path:
    """Write ``NAME.pdf`` into a result folder by the template ``NAME.typ`` and return its path.

    Parameters
    ----------
    content_of : what the template shows of a folder, and the figures by file name
    kind : what the report calls itself
    """
    folder = open_folder(out)
    content, figures = content_of(folder)
    project = title or str(folder.run.get("scene") or out.name)
    return write_document(
        out / f"{name}.pdf",
        template=f"{name}.typ",
        content={
            **content,
            "cover": cover(folder, title=project, author=author),
            "kind": kind,
            "paper": paper,
        },
        figures=figures,
        date=folder.run.get("date"),
    )
