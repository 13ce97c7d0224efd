"""One HTML page over the results of many scenes; every name in it is data, never markup."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any
from urllib.parse import quote

_STYLE = """
body { font: 15px/1.5 sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; color: #222; }
section { display: grid; grid-template-columns: 22em 1fr; gap: 1.5em; border-top: 1px solid #ccc; padding: 1em 0; }
img { width: 100%; } h2 { margin: 0; font-size: 1.2em; } td { padding-right: 1.5em; vertical-align: top; }
.fail, .failed { color: #b00020; } .pass { color: #1b6e2c; } .undecided { color: #8a5a00; }
"""


def index_page(rows: Sequence[Mapping[str, Any]]) -> str:
    """Page with a section a scene.

    Parameters
    ----------
    rows : ``scene``, ``status``, ``message``, ``nodes``, ``seconds``, ``error_rms``, ``target``; ``path`` of the
        result folder from the page; ``figures`` as rows of the table of metrics
    """
    failed = sum(row["status"] == "failed" for row in rows)
    sections = "\n".join(_section(row) for row in rows)
    return (
        '<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8"><title>lelight</title>'
        f"<style>{_STYLE}</style></head>\n<body>\n<h1>{len(rows)} scenes, {failed} failed</h1>\n{sections}\n"
        "</body>\n</html>\n"
    )


def _section(row: Mapping[str, Any]) -> str:
    title = f"<h2>{escape(str(row['scene']))}</h2>"
    if row["status"] == "failed":
        return f'<section><div>{title}</div><p class="failed">{escape(str(row["message"]))}</p></section>'
    folder = quote(str(row["path"]))
    error = "" if row["error_rms"] is None else f", relative standard error {row['error_rms']:.2%}"
    links = " ".join(
        f'<a href="{folder}/{name}">{name}</a>'
        for name in ("run.json", "metrics.csv", "field.vtp", "scene.vtm")
    )
    figures = "".join(_figure(figure) for figure in row["figures"])
    return (
        f'<section><img src="{folder}/overview.png" alt="overview"><div>{title}'
        f"<p>{row['nodes']} nodes{error}, target {row['target']:.2%}</p>"
        f"<table>{figures}</table><p>{links}</p></div></section>"
    )


def _figure(figure: Mapping[str, Any]) -> str:
    unit = "" if figure["unit"] in (None, "1") else f" {figure['unit']}"
    value = "-" if figure["value"] is None else f"{figure['value']:.4g}{unit}"
    target = "" if figure["target"] is None else f"target {figure['target']:g}{unit}"
    verdict = str(figure["verdict"] or "")
    cells = (f"{figure['name'] or ''}", str(figure["figure"]).replace("_", " "), value, target)
    shown = "".join(f"<td>{escape(cell)}</td>" for cell in cells)
    return f'<tr>{shown}<td class="{escape(verdict)}">{escape(verdict)}</td></tr>'
