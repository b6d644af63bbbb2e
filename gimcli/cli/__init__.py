"""The command line: parse, call, print, exit. Nothing heavy is imported before a command runs."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import Any

import typer
from typer.core import TyperGroup

from gimcli import __version__
from gimcli.cli import (
    circuits,
    forces,
    groups,
    mobility,
    reduce,
    schema,
    sequence,
    simulate,
    singularities,
    solve,
    trace,
    tradeoff,
    workspace,
)
from gimcli.cli.progress import end_bars, progress_bar
from gimcli.errors import GimError


class _Commands(TyperGroup):
    """The commands; a reader that has gone away (`gim ... | head`) is no failure of theirs."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        progress_bar(next((word for word in sys.argv[1:] if not word.startswith("-")), "gim"))
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left to flush goes nowhere
            raise typer.Exit(0) from None
        except Exception as error:
            if hasattr(error, "format_message") and hasattr(error, "exit_code"):  # typer's own: wrong usage
                _tell_json(error.format_message(), error.exit_code)
            raise
        finally:
            end_bars()


app = typer.Typer(
    cls=_Commands,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Analyse planar mechanisms drawn in text model files, by the Geometrical-Iterative Method.\n\n"
    "Example: gim trace models/crank_rocker.yaml --steps 360",
)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"gim {__version__}")
        raise typer.Exit


@app.callback()
def _main(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Tell the version."),
) -> None:
    pass


MODULES = (
    solve, trace, sequence, mobility, singularities, circuits, workspace,
    groups, forces, simulate, reduce, tradeoff, schema,
)  # fmt: skip

for module in MODULES:
    app.command(module.NAME, help=module.HELP)(module.command)


def _tell_json(text: str, exit_code: int) -> None:
    """Print what went wrong as a JSON object, where one is asked for."""
    if "--json" in sys.argv[1:]:
        from gimcli.cli.console import print_json

        print_json({"error": text, "exit": exit_code})


def _stop(number: int, frame: FrameType | None) -> None:
    """End as an error does, so that nothing half-written stays."""
    sys.exit(128 + number)


def main() -> None:
    """Run the command line and exit with the status that the format page promises."""
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")  # none is used, and looking for them costs time
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the matrices are small: more threads only wait for each other
    signal.signal(signal.SIGTERM, _stop)
    every = app.registered_commands
    app.registered_commands = [c for c in every if [c.name] == sys.argv[1:2]] or every  # the others cost time to build
    try:
        app()
    except GimError as error:
        from gimcli.cli.console import printable

        text = printable(str(error))
        typer.echo(f"gim: {text}" if "\n" not in text else f"gim:\n{text}", err=True)
        _tell_json(text, error.exit_code)
        sys.exit(error.exit_code)
    except OSError as error:
        typer.echo(f"gim: the output cannot be written: {error.strerror or error}", err=True)
        os._exit(6)  # closing standard output would fail once more
    finally:
        app.registered_commands = every
