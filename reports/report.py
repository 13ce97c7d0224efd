"""What the reports share: open the folder, put cover and content together, write the PDF or its figures alone."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lelight.reports.document import read_logo, write_document
from lelight.reports.folder import ResultFolder, open_folder
from lelight.reports.summary import cover
from lelight.reports.texts import read_texts
from lelight.writing.files import make_folder, whole

Figures = dict[str, bytes]
#: Told what is being done.
Announce = Callable[[str], None]


def silent(_: str) -> None:
    """Announce nothing."""


@dataclass(frozen=True)
class Order:
    """How a report is wanted.

    Attributes
    ----------
    title : name of the project; default the name of the scene
    paper : ``a3``, ``a4``, ``us-letter`` or ``us-legal``
    logo : picture for the cover
    language : one of `lelight.reports.texts.languages`
    figures_only : write the figures as SVG instead of the PDF
    announce : told what is being done
    """

    title: str | None = None
    author: str | None = None
    paper: str = "a4"
    logo: Path | None = None
    language: str = "en"
    figures_only: bool = False
    announce: Announce = silent


def write_report(
    out: Path,
    name: str,
    content_of: Callable[[ResultFolder, Announce], tuple[dict[str, Any], Figures]],
    order: Order,
) -> Path:
    """Write ``NAME.pdf`` into a result folder by the template ``NAME.typ``, or ``figures/NAME/``; returns its path.

    Parameters
    ----------
    content_of : what the template shows of a folder, and the figures by file name
    """
    texts = read_texts(order.language)
    logo = read_logo(order.logo) if order.logo is not None else {}
    folder = open_folder(out, texts)
    content, figures = content_of(folder, order.announce)
    if order.figures_only:
        return _write_figures(out / "figures" / name, figures)
    order.announce(f"setting {name}.pdf")
    project = order.title or str(folder.run.get("scene") or out.name)
    return write_document(
        out / f"{name}.pdf",
        template=f"{name}.typ",
        content={
            **content,
            "cover": cover(folder, title=project, author=order.author) | {"logo": next(iter(logo), "")},
            "kind": texts[f"{name}_report"],
            "paper": order.paper,
        },
        figures=figures | logo,
        date=folder.run.get("date"),
        texts=texts,
    )


def _write_figures(folder: Path, figures: Figures) -> Path:
    """Write the figures and nothing else into a folder."""
    shutil.rmtree(folder, ignore_errors=True)
    make_folder(folder)
    for name, svg in figures.items():
        with whole(folder / name) as part:
            part.write_bytes(svg)
    return folder
