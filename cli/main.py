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
    "calc": "Compute the light in a scene and write all results.",
    "check": "Read a scene, show the plan, the lint and what a run will take.",
    "photometry": "Read photometric files: info, check, convert, ugr.",
    "compare": "Say what differs between two results, and how sure that is.",
    "metrics": "Print every figure of a result.",
    "render": "Take a new picture of a result.",
    "report": "Write a PDF report of a result: luminance or glare.",
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
    end_in_time()
    _show_what_the_terminal_can()
    try:
        status = group.main(arguments, prog_name="lelight", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        end()
    except LelightError as error:
        _fail(str(error), 1)
    except MemoryError:
        _fail("not enough memory; give a longer --edge or fewer glossy materials", 1)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        _fail(f"{where}{error.strerror or error}; check the disk and the permissions", 1)
    sys.exit(status if isinstance(status, int) else 0)


def _show_what_the_terminal_can() -> None:
    """Write letters that the terminal's encoding lacks as escapes."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _fail(message: str, status: int) -> None:
    click.echo(f"lelight: {' '.join(message.split())}", err=True)
    sys.exit(status)
