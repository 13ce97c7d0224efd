"""The validation report: every case with a known answer, its values, differences, errors and verdicts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lelight.reports.document import write_document
from lelight.reports.figures.standing import Standing, standing_chart
from lelight.reports.rounding import MINUS, MISSING, NO_BREAK_SPACE, as_given, fixed, significant
from lelight.reports.summary import printed_date

TITLE = "Validation report"
CHART = "standing.svg"
#: Letters of a value and its reference.
DIGITS = 6
#: Least difference and standard error that are printed, in per cent.
LEAST_PERCENT = 1e-3


def write_validation_report(path: Path, record: Mapping[str, Any], *, paper: str = "a4") -> Path:
    """Write the PDF of a validation and return its path.

    Parameters
    ----------
    record : what ``validation.json`` holds
    paper : ``a3``, ``a4``, ``us-letter`` or ``us-legal``
    """
    content = {
        "kind": TITLE,
        "paper": paper,
        "cover": _cover(record),
        "verdict": _verdict_sentence(record["cases"]),
        "statement": _statement(record),
        "chart": CHART,
        "summary": [_summary_row(case) for case in record["cases"]],
        "groups": _groups(record["cases"]),
        "versions": [[name, version] for name, version in record["versions"].items()],
    }
    figures = {CHART: standing_chart({case["name"]: _standings(case) for case in record["cases"]})}
    return write_document(
        path, template="validation.typ", content=content, figures=figures, date=record["date"]
    )


def _cover(record: Mapping[str, Any]) -> dict[str, Any]:
    facts = [
        ("Cases", f"{len(record['cases'])} of the {'full' if record['full'] else 'short'} set"),
        ("Seed", str(record["seed"])),
        ("Time", f"{fixed(record['seconds'], 0)}{NO_BREAK_SPACE}s"),
        ("Calculated", printed_date(record["date"])),
        ("Program", f"lelight {record['lelight']}"),
    ]
    program = f"lelight {record['lelight']}"
    return {"title": "Cases with known answers", "author": "", "facts": facts, "program": program}


def _verdict_sentence(cases: Sequence[Mapping[str, Any]]) -> str:
    verdicts = Counter(case["verdict"] for case in cases)
    told = [f"{verdicts[verdict]} {word}" for verdict, word in _WORDS if verdicts[verdict]]
    return f"{len(cases)} case{'s' if len(cases) > 1 else ''}: {', '.join(told)}."


_WORDS = (("pass", "passed"), ("fail", "failed"), ("undecided", "undecided within the error"))


def _statement(record: Mapping[str, Any]) -> str:
    return (
        "A value passes where it differs from the reference by no more than the tolerance, where Student's t of the "
        "difference does not exceed its limit, and where its standard error is small enough to tell. The limit calls a "
        f"case whose reference is right wrong with a probability of {as_given(100 * record['level'])} % over all "
        "values of the case (Šidák). Differences and standard errors are shares of the reference, or of 5 % of the "
        "case's mean where that is more. Single nodes of a surface may differ ten times as much as their mean; the "
        "summary names the mean's difference and error."
    )


def _summary_row(case: Mapping[str, Any]) -> dict[str, str]:
    points = [point for point in case["points"] if point["tolerance"] <= case["tolerance"]]
    return {
        "name": case["name"],
        "title": f"{case['group']}: {case['title']}",
        "values": str(case["tested"]),
        "difference": _percent(max((abs(p["relative_difference"] or 0.0) for p in points), default=0.0)),
        "error": _percent(max((p["relative_std_error"] or 0.0 for p in points), default=0.0)),
        "t": _t(max((abs(p["t"]) for p in case["points"] if p["t"] is not None), default=None)),
        "limit": fixed(case["t_limit"], 1),
        "tolerance": _percent(case["tolerance"]),
        **_verdict(case["verdict"]),
    }


def _groups(cases: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Put cases under their headings, in their order."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for case in cases:
        groups.setdefault(case["group"], []).append(_detail(case))
    return [{"name": name, "cases": details} for name, details in groups.items()]


def _detail(case: Mapping[str, Any]) -> dict[str, Any]:
    facts = [
        f"Reference: {case['basis']}",
        f"tolerance {_percent(case['tolerance'])}",
        f"standard error at most {_percent(case['precision'])}",
        f"|t| at most {fixed(case['t_limit'], 1)} ({as_given(case['degrees_of_freedom'])} degrees of freedom, "
        f"{case['tested']} value{'s' if case['tested'] > 1 else ''})",
        f"{fixed(case['seconds'], 1)}{NO_BREAK_SPACE}s",
    ]
    return {
        "name": case["name"],
        "title": case["title"],
        "facts": "; ".join(facts) + ".",
        "quantity": f"{case['quantity'].capitalize()}, {case['unit']}",
        "rows": [_row(point) for point in case["points"]],
    }


def _row(point: Mapping[str, Any]) -> dict[str, str]:
    return {
        "label": point["label"],
        "found": _value(point["value"]),
        "reference": _value(point["reference"]),
        "difference": _percent(point["relative_difference"], signed=True),
        "error": _percent(point["relative_std_error"]),
        "t": _t(point["t"]),
        **_verdict(point["verdict"]),
    }


def _verdict(verdict: str) -> dict[str, str]:
    return {"verdict": verdict, "verdict_text": verdict.capitalize()}


def _value(number: float | None) -> str:
    return MISSING if number is None else significant(number, DIGITS)


def _percent(share: float | None, *, signed: bool = False) -> str:
    """Write a share in per cent; what is smaller than any tolerance is 0."""
    if share is None:
        return MISSING
    percent = 100.0 * share
    if abs(percent) < LEAST_PERCENT:
        return f"0{NO_BREAK_SPACE}%"
    sign = "+" if signed and percent > 0 else ""
    return f"{sign}{significant(percent, 2)}{NO_BREAK_SPACE}%"


def _t(t: float | None) -> str:
    return MISSING if t is None else fixed(t, 1).replace(f"{MINUS}0.0", "0.0")


def _standings(case: Mapping[str, Any]) -> list[Standing]:
    """Differences and errors as shares of the tolerance; what is missing lies off the axis."""
    return [
        (
            _over(point["relative_difference"], point["tolerance"]),
            _over(point["relative_std_error"], point["tolerance"]),
            point["verdict"] == "pass",
        )
        for point in case["points"]
    ]


def _over(share: float | None, tolerance: float) -> float:
    return float("inf") if share is None else share / tolerance
