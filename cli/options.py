"""Options that commands share, and the types of their values."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])


class RelativeError(click.ParamType):
    """A share such as 0.02, or ``2%``."""

    name = "error"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read a share between 0 and 1."""
        from lelight.reading.quantities import relative_error

        try:
            return relative_error(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


class Seconds(click.ParamType):
    """A time such as 90, ``90s``, ``5min`` or ``2h``."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read a time in seconds."""
        from lelight.reading.quantities import seconds

        try:
            return seconds(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


SCENE = click.argument("scene", type=click.Path(path_type=Path))
OUT = click.argument("out", type=click.Path(path_type=Path))

_RUN_OPTIONS = [
    click.option("--target", type=RelativeError(), help="Relative standard error to reach, e.g. 2%."),
    click.option("--time", type=Seconds(), help="Stop at this budget, e.g. 60s."),
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
