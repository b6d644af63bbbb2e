"""`gim view`: show the motion in the browser, and solve it again when the file is saved."""

from __future__ import annotations

import signal
import sys
import webbrowser
from pathlib import Path
from typing import Annotated, Any

import typer

from gimcli.cli.arguments import Assembly, assignments, declared
from gimcli.cli.console import end_bars, note, printable, progress_bar
from gimcli.cli.from_verb import COMMON, own_options
from gimcli.cli.measures import measures_of
from gimcli.cli.trace import OPTIONS
from gimcli.errors import refuse
from gimcli.library.load import is_address
from gimcli.library.trace import trace
from gimcli.view.server import served

SERVER = "Server"

HELP = (
    "Serves one page on this machine (127.0.0.1) with the motion, its graphs and a slider for each input and parameter."
    " The motion is solved again whenever the file or one of its tables is saved; errors appear on the page, beside the"
    " last motion. Ctrl-C ends it."
)
EXAMPLES = (
    "gim view crank_rocker",
    "gim view jansen --steps 180 --plot velocity",
    "gim view excavator --no-browser --port 8700",
)


TRACED = ("steps", "derivatives", "measure", "plot")
"""The options of `gim trace` that the page takes."""


def _view(
    model: str, changes: list[str], assembly: str, port: int | None, browser: bool, measure: list[str], plot: list[str],
    **traced: Any,
) -> None:  # fmt: skip
    """Show a motion in the browser while its file is edited."""
    settings = {"measure": measures_of(measure), "plot": ",".join(plot), **traced}
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have switched it off for a background job
    try:
        _serve(model, changes, assembly, port, settings, browser)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        if sys.stdout.isatty():
            typer.echo()  # the terminal shows ^C


def _serve(
    model: str, changes: list[str], assembly: str, port: int | None, settings: dict[str, object], browser: bool
) -> None:
    refuse((is_address(model), "an address does not change: write its model file with `gim convert` and view that"))
    values, path = assignments(changes), Path(model)
    with served(path, values, assembly, port, settings, lambda text: note(printable(text)), progress_bar) as server:
        end_bars()
        typer.echo(f"{path.name}: {server.url} (Ctrl-C ends)")
        sys.stdout.flush()
        if browser:
            _open(server.url)
        server.serve_forever()


def _open(url: str) -> None:
    """Open the page in a browser with windows; one that uses the terminal would hide what is printed."""
    try:
        found = webbrowser.get()
    except webbrowser.Error:
        return
    if type(found) is not webbrowser.GenericBrowser:
        found.open(url)


PORT = typer.Option(
    "--port", metavar="N", min=0, max=65535, rich_help_panel=SERVER,
    help="Port; by default 8642, or a free one.\n0: any free one.",
)  # fmt: skip
BROWSER = typer.Option(
    "--browser/--no-browser", help="Open the page in the browser.\nElse only its address is printed.",
    rich_help_panel=SERVER,
)  # fmt: skip
command = declared(
    _view,
    *COMMON,
    ("assembly", Assembly, ""),
    *(one for one in own_options(trace, OPTIONS) if one[0] in TRACED),
    ("port", Annotated[int | None, PORT], None),
    ("browser", Annotated[bool, BROWSER], True),
)
