"""Options that commands share, and the types of their values."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])


def relative_error(given: str) -> float:
    """Read a share such as ``0.02`` or ``2%``."""
    from lelight.reading import quantities

    try:
        return quantities.relative_error(given)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


def seconds(given: str) -> float:
    """Read a time such as ``90``, ``90s``, ``5min`` or ``2h``, in seconds."""
    from lelight.reading import quantities

    try:
        return quantities.seconds(given)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


SCENE = click.argument("scene", type=click.Path(path_type=Path))
OUT = click.argument("out", type=click.Path(path_type=Path))

_RUN_OPTIONS = [
    click.option(
        "--target", type=relative_error, metavar="ERROR", help="Relative standard error to reach, e.g. 2%."
    ),
    click.option("--time", type=seconds, metavar="TIME", help="Stop at this budget, e.g. 60s."),
    click.option("--preset", type=click.Choice(["draft", "normal", "fine"]), help="Default: normal."),
    click.option("--method", type=click.Choice(["sh", "grid"]), help="Angular detail of glossy nodes."),
    click.option("--edge", type=click.FloatRange(min=0, min_open=True), help="Edge of the node mesh, m."),
    click.option("--directions", type=click.IntRange(min=16), help="Directions of --method grid."),
    click.option("--seed", type=click.IntRange(min=0), help="Seed of every random number. Default: 0."),
    click.option("--threads", type=click.IntRange(min=1), help="Default: all that may be used."),
]


def run_options(command: Command) -> Command:
    """Add the options that say how a run is to be done."""
    for option in reversed(_RUN_OPTIONS):
        command = option(command)
    return command
