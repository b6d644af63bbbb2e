"""The command line: parse, call, print, exit. Heavy modules are imported when a command runs.

Knows: commands, options, help and what the terminal shows; only here typer is imported.
Asks: any package below.
Asked by: no package.
"""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from types import FrameType
from typing import Any, cast


def _quit(number: int, frame: FrameType | None) -> None:
    """End at once with the status of an interrupt: nothing has been computed or written."""
    os._exit(128 + number)


_outside: Any = signal.default_int_handler
with suppress(ValueError):  # imported by a thread: it gets no signals
    _outside = signal.signal(signal.SIGINT, _quit)  # the imports below take most of a short command's time

import sys
from importlib import import_module

import typer
from typer.core import CompletionItem, TyperGroup  # type: ignore[attr-defined]  # typer lists no names

from gimcli import __version__
from gimcli.cli.command import Command, taking_plain_values
from gimcli.cli.console import end_bars, print_json, printable, progress_bar
from gimcli.cli.settings_folder import provide_settings_folder
from gimcli.errors import GimError, reason, refuse

GROUPS: dict[str, dict[str, str]] = {
    "Position and motion": {
        "check": "Report what a mechanism is and does; warn of errors.",
        "solve": "Find a position, or all configurations, at given inputs.",
        "trace": "Follow the motion; write positions and coupler curves.",
        "workspace": "Find the region or the paths that a point can reach.",
        "view": "Show the motion in the browser while the file is edited.",
    },
    "Families of designs": {
        "sweep": "Vary dimensions: solve many designs, keep quantities of each.",
        "sensitivity": "Find how positions depend on dimensions and tolerances.",
        "fit": "Find dimensions for which the motion passes targets.",
    },
    "Structure": {
        "mobility": "Count freedoms; name redundant constraints, undriven nodes.",
        "groups": "Show the driving links and Assur groups.",
        "sequence": "Show the order in which positions are solved, and why.",
    },
    "Branches and limits": {
        "singularities": "List limits, dead points and change points of a circuit.",
        "circuits": "Find which configurations the motion connects.",
    },
    "Forces and dynamics": {
        "equilibrium": "Find the positions in which all forces balance.",
        "forces": "Find driving efforts and reactions for a prescribed motion.",
        "modes": "Find natural frequencies and shapes of small vibrations.",
        "simulate": "Simulate the motion of free inputs under forces.",
        "reduce": "Find the equivalent one-degree-of-freedom model.",
    },
    "Methods, files and manual": {
        "new": "Write a shipped model as a template, or list all.",
        "tradeoff": "Compare speed and accuracy of the solution methods.",
        "convert": "Convert files of other programs to model files, and back.",
        "schema": "Print the JSON Schema of the model file.",
        "manual": "Show a page of the manual.",
    },
}
"""Commands by the questions that they answer, with a line of help; each has a module of its name in this package."""

COMMANDS = {name: line for group in GROUPS.values() for name, line in group.items()}

VERBOSE = "gimcli.verbose"
"""Key of the option in the context of the command line."""

SETTINGS: dict[str, Any] = {
    "pretty_exceptions_enable": False, "rich_markup_mode": None,
    "context_settings": {"help_option_names": ["-h", "--help"], "max_content_width": 80},
}  # fmt: skip


class _Commands(TyperGroup):
    """The commands; each is imported when it is used. A closed pipe (`gim ... | head`) is not an error."""

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.commands = cast(Any, dict.fromkeys(COMMANDS))  # names are enough to suggest one

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options before a command."""
        return taking_plain_values(super().get_params(ctx))

    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        """Return the names of commands, or the options before a command, that begin with a text."""
        names = [CompletionItem(name, help=line) for name, line in COMMANDS.items() if name.startswith(incomplete)]
        return names or super().shell_complete(ctx, incomplete)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands by groups."""
        for title, lines in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(f"{name:13}", line) for name, line in lines.items()])

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command by its name; None where there is none."""
        if cmd_name not in COMMANDS:
            return None
        alone = typer.Typer(**SETTINGS, add_completion=False)
        if ctx is not None and ctx.resilient_parsing:  # a shell completes the options
            from gimcli.cli.completion import completed

            alone.command(cmd_name, cls=Command)(completed(cmd_name))
            return typer.main.get_command(alone)
        module = import_module(f"gimcli.cli.{cmd_name}")
        text = f"{COMMANDS[cmd_name]}\n\n{module.HELP}"
        alone.command(cmd_name, help=text, short_help=COMMANDS[cmd_name], cls=Command)(module.command)
        found: Any = typer.main.get_command(alone)
        found.name, found.examples, found.kind = cmd_name, module.EXAMPLES, getattr(module.command, "kind", None)
        return found

    def invoke(self, ctx: Any) -> Any:
        """Run a command; an interrupt ends it in order."""
        own = signal.getsignal(signal.SIGINT) is _quit
        if own:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        progress_bar(next((word for word in sys.argv[1:] if not word.startswith("-")), "gim"))
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the rest of the output is discarded
            raise typer.Exit(0) from None
        except Exception as error:
            if hasattr(error, "format_message") and hasattr(error, "exit_code"):  # typer's own: wrong usage
                _print_json_error(error.format_message(), error.exit_code)
            raise
        finally:
            end_bars()
            if own:
                signal.signal(signal.SIGINT, _quit)


app = typer.Typer(
    **SETTINGS,
    cls=_Commands,
    no_args_is_help=True,
    help="Analyse planar mechanisms that are described in text files.\n"
    "\n"
    "Example: gim trace crank_rocker --steps 360\n"
    "\n"
    "Each command has --help with examples; `gim manual` has all pages.",
)


def _verbose(context: typer.Context, wanted: bool) -> bool:
    context.meta[VERBOSE] = wanted  # eager options are read before the others
    return wanted


def _version(context: typer.Context, wanted: bool) -> None:
    if wanted:
        typer.echo(f"gim {__version__}")
        if context.meta.get(VERBOSE):
            from gimcli.cli.versions import version_lines

            for line in version_lines():
                typer.echo(line)
        raise typer.Exit


@app.callback()
def _main(
    version: bool = typer.Option(False, "--version", callback=_version, help="Show the version."),
    verbose: bool = typer.Option(
        False, "--verbose", callback=_verbose, is_eager=True,
        help="With --version: libraries, cache and cores too.",
    ),
) -> None:  # fmt: skip
    refuse((verbose, "--verbose: expected `gim --version --verbose`; commands print all that they have to report"))


def _print_json_error(text: str, exit_code: int) -> None:
    """Print an error as a JSON object, if --json is given."""
    if "--json" in sys.argv[1:]:
        print_json({"error": text, "exit": exit_code})


def _stop(number: int, frame: FrameType | None) -> None:
    """Exit as after an error, so that no incomplete file remains."""
    sys.exit(128 + number)


def _prepare_streams() -> None:
    """Discard what is printed to a closed stream, as by `2>&-`; escape letters that an encoding does not have."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - open as long as the process
        elif getattr(stream, "errors", "") == "strict" and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a pipe on Windows has the encoding of the system


def main() -> None:
    """Run the command line and exit with the status that the manual lists."""
    signal.signal(signal.SIGINT, _quit)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the matrices are small: more threads only wait for each other
    _prepare_streams()
    provide_settings_folder()
    signal.signal(signal.SIGTERM, _stop)
    try:
        app(prog_name="gim")
    except GimError as error:
        text = printable(str(error))
        typer.echo(f"gim: {text}" if "\n" not in text else f"gim:\n{text}", err=True)
        _print_json_error(text, error.exit_code)
        sys.exit(error.exit_code)
    except OSError as error:
        typer.echo(f"gim: the output cannot be written: {reason(error)}", err=True)
        os._exit(6)  # closing standard output would fail once more


with suppress(ValueError):
    signal.signal(signal.SIGINT, _outside)  # `main` takes the signals of its own process
