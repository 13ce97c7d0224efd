"""Options that commands share, and the types of their values."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])

#: Largest seed, and most directions of a hemisphere grid: those of harmonics far above any that are stored.
LARGEST_SEED, MOST_DIRECTIONS = 2**63 - 1, 1 << 16


class NamedPath(click.Path):
    """A path that says something and that every file format can hold."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse the empty path, which would mean the working folder, and bytes that are not UTF-8."""
        if value == "":
            self.fail("the path is empty", param, ctx)
        try:
            str(value).encode()
        except UnicodeEncodeError:
            self.fail(f"the name {value!a} is not UTF-8; rename the file", param, ctx)
        return super().convert(value, param, ctx)


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


def memory_size(given: str) -> float:
    """Read a size such as ``4GB``, in bytes."""
    from lelight.reading import quantities

    try:
        return quantities.memory_size(given)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


def edge_length(given: str) -> float:
    """Read a length in m, above 0 and no farther than any scene reaches."""
    from lelight.reading.limits import FARTHEST

    try:
        length = float(given)
    except ValueError:
        length = 0.0
    if not 0 < length <= FARTHEST:
        raise click.BadParameter(f"found {given!r}; allowed is a length in m, above 0")
    return length


SCENE = click.argument("scene", type=NamedPath())
OUT = click.argument("out", type=NamedPath())

_RUN_OPTIONS = [
    click.option(
        "--target", type=relative_error, metavar="ERROR", help="Relative standard error to reach, e.g. 2%."
    ),
    click.option("--time", type=seconds, metavar="TIME", help="Time of the whole command, e.g. 60s."),
    click.option("--preset", type=click.Choice(["draft", "normal", "fine"]), help="Default: normal."),
    click.option(
        "--method", type=click.Choice(["sh", "grid", "sampled"]), help="Angular detail of glossy nodes."
    ),
    click.option("--edge", type=edge_length, metavar="LENGTH", help="Edge of the node mesh, m."),
    click.option(
        "--adaptive",
        is_flag=True,
        default=None,
        help="Refine the mesh where light is not linear over its triangles; --time fits the mesh before that.",
    ),
    click.option(
        "--directions", type=click.IntRange(16, MOST_DIRECTIONS), help="Directions of --method grid."
    ),
    click.option(
        "--relightable",
        type=click.FloatRange(0, 256),
        metavar="EXPONENT",
        help="Keep at all nodes what relight needs for lobes up to this exponent.",
    ),
    click.option(
        "--seed", type=click.IntRange(0, LARGEST_SEED), help="Seed of the random numbers. Default: 0."
    ),
    click.option("--threads", type=click.IntRange(min=1), help="Default: all that may be used."),
    click.option(
        "--cluster",
        metavar="ADDRESS",
        help="Dask scheduler whose workers take part, e.g. tcp://host:8786, or local:4 for four processes here.",
    ),
    click.option(
        "--memory",
        type=memory_size,
        metavar="SIZE",
        help="Most to take, e.g. 4GB. Default: 70 % of what is free.",
    ),
]


def run_options(command: Command) -> Command:
    """Add the options that say how a run is to be done."""
    for option in reversed(_RUN_OPTIONS):
        command = option(command)
    return command
