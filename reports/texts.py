"""Texts of the reports in one language: ``texts/LANGUAGE.toml``, read once."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from lelight.reports.vocabulary import Term, sense_of, words


@dataclass(frozen=True)
class Texts:
    """Every word that a report prints, but for what the result files say themselves.

    Attributes
    ----------
    labels : short texts by key; what stands in braces is filled in
    terms : name and symbol of a figure by its key in ``metrics.json``, in printing order
    settings : name and unit of a setting of a run
    """

    language: str
    labels: Mapping[str, str]
    terms: Mapping[str, tuple[str, str]]
    verdicts: Mapping[str, str]
    stages: Mapping[str, str]
    settings: Mapping[str, tuple[str, str]]
    glossary: tuple[tuple[str, str], ...]

    def __getitem__(self, key: str) -> str:
        """Label by its key."""
        return self.labels[key]

    def filled(self, key: str, **parts: object) -> str:
        """Label with its braces filled in."""
        return self.labels[key].format(**parts)

    def term(self, key: str) -> Term:
        """Name, symbol and sense of a figure; one that is not known is printed as words."""
        name, symbol = self.terms.get(key, (words(key), ""))
        return Term(name, symbol, sense_of(key))

    def rank(self, key: str) -> int:
        """Place of a figure in tables; those that are not known come last."""
        return list(self.terms).index(key) if key in self.terms else len(self.terms)


def languages() -> tuple[str, ...]:
    """Name the languages that there are texts of."""
    names = (entry.name for entry in files("lelight.reports").joinpath("texts").iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


@cache
def read_texts(language: str = "en") -> Texts:
    """Read the texts of a language.

    Raises
    ------
    ValueError
        where there are none
    """
    if language not in languages():
        raise ValueError(f"language: {language!r} is none of {', '.join(languages())}")
    content = files("lelight.reports").joinpath("texts", f"{language}.toml").read_text(encoding="utf-8")
    table: dict[str, Any] = tomllib.loads(content)
    return Texts(
        language=table["language"],
        labels=table["labels"],
        terms={key: (name, symbol) for key, (name, symbol) in table["terms"].items()},
        verdicts=table["verdicts"],
        stages=table["stages"],
        settings={key: (name, unit) for key, (name, unit) in table["settings"].items()},
        glossary=tuple((entry["term"], entry["text"]) for entry in table["glossary"]),
    )
