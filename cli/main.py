"""The ``lelight`` command: finds the others when they are asked for, and turns errors into one line."""

from __future__ import annotations

import io
import sys
from importlib import import_module
from typing import Any

import click

import lelight
from lelight.cli.interruption import end, end_in_time
from lelight.errors import LelightError

#: Commands by name: the module of this package that holds ``command``, and the line that help shows.
COMMANDS = {
    "batch": "Compute many scenes; one that fails does not stop the others.",
    "calc": "Compute the light in a scene and write all results.",
    "check": "Read a scene, show the plan, the lint and what a run will take.",
    "photometry": "Read photometric files: info, check, convert, ugr.",
    "compare": "Say what differs between two results, and how sure that is.",
    "metrics": "Print every figure of a result.",
    "node": "Show how a node of a result looks from every side.",
    "relight": "Give surfaces of a result other materials, without a new run.",
    "render": "Take a new picture of a result.",
    "report": "Write a PDF report of a result: luminance or glare.",
    "tradeoff": "Measure speed against accuracy in a scene.",
    "validate": "Compute scenes with known answers and compare.",
}


class LazyGroup(click.Group):
    """Imports a command only when it runs, so that help comes at once."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of all commands, sorted."""
        return sorted(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the module of a command; None where there is no such command."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(f"lelight.cli.{cmd_name}").command
        return command

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; what click does about Ctrl-C adds an empty line."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            end()

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing any."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, COMMANDS[name]) for name in self.list_commands(ctx)])


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(lelight.__version__, prog_name="lelight")
def group() -> None:
    """Light in a scene, by local estimation of the Monte Carlo method, with its error."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; exit status 0 done, 1 failed, 2 misuse, 130 interrupted."""
    with end_in_time():
        sys.exit(_status(arguments))


def _status(arguments: list[str] | None) -> int:
    """Run the command line and tell its exit status; errors that a user can cause become one line."""
    _show_what_the_terminal_can()
    try:
        status = group.main(arguments, prog_name="lelight", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        end()
    except LelightError as error:
        return _failed(str(error))
    except MemoryError:
        return _failed("not enough memory; give a longer --edge or fewer glossy materials")
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _failed(f"{where}{error.strerror or error}; check the disk and the permissions")
    return status if isinstance(status, int) else 0


def _show_what_the_terminal_can() -> None:
    """Write letters that the terminal's encoding lacks as escapes."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _failed(message: str) -> int:
    """Say in one line what went wrong."""
    click.echo(f"lelight: {' '.join(message.split())}", err=True)
    return 1
