"""Live progress on stderr, and its silent twin."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import click

from lelight.course import Standing

Watch = tuple[Callable[[str], None], Callable[[Standing], None]]

#: Seconds between two lines of a log.
LOG_INTERVAL = 10.0


@contextmanager
def watched(*, quiet: bool, title: Callable[[], str] = str) -> Iterator[Watch]:
    """Two callables for a run: one takes the name of each stage, one where the estimate stands.

    Parameters
    ----------
    title : what stands before every line, asked for each time
    """
    if quiet:
        yield (lambda _: None), (lambda _: None)
    elif sys.stderr.isatty():
        with _live(title) as watch:
            yield watch
    else:
        yield (lambda _: None), _log(title)


@contextmanager
def _live(title: Callable[[], str]) -> Iterator[Watch]:
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status("starting") as status:
        yield (
            lambda stage: status.update(escape(title() + stage)),
            lambda standing: status.update(escape(title() + _line(standing))),
        )


def _log(title: Callable[[], str]) -> Callable[[Standing], None]:
    """Lines for a file or a pipe: one at the first replicate, when the scene has proved sound, then seldom."""
    due, named = 0.0, title()

    def log(standing: Standing) -> None:
        nonlocal due, named
        if title() != named:
            due, named = 0.0, title()
        if standing.seconds >= due:
            click.echo(f"lelight: {title()}{_line(standing)}", err=True)
            due = standing.seconds + LOG_INTERVAL

    return log


def _line(standing: Standing) -> str:
    """Say how far the estimate is and how long it may take."""
    text = f"estimating: {standing.replicates} replicates doubled {standing.doublings} times, {standing.seconds:.0f} s"
    if standing.error is None:
        return text
    reached = f"{text}, error {standing.error.rms:.2%} of {standing.target:.2%}"
    left = standing.seconds * max(0.0, (standing.error.rms / standing.target) ** 2 - 1.0)
    return f"{reached}, about {left:.0f} s left"
