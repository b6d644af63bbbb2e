"""`gim view`: show the motion in the browser, and solve it again when the file is saved."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Annotated

import typer

from gimcli.cli.arguments import MODEL, NONE, SHARED, Assembly, ModelPath, Set, assignments
from gimcli.cli.console import note, printable
from gimcli.cli.measures import PLOT, QUANTITIES, measures_of
from gimcli.cli.progress import end_bars, progress_bar
from gimcli.errors import UsageError

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


def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    steps: Annotated[int, SHARED["steps"]] = 360,
    assembly: Assembly = "",
    derivatives: Annotated[
        int,
        typer.Option(
            "--derivatives", "-d", metavar="K", min=0, max=3, rich_help_panel=QUANTITIES,
            help="1: velocities; 2: also accelerations; 3: also jerks.",
        ),
    ] = 0,
    measure: Annotated[
        list[str],
        typer.Option(
            "--measure", "-m", metavar="QUANTITY", rich_help_panel=QUANTITIES,
            help="Add a quantity, such as |A.f|; repeatable.",
        ),
    ] = NONE,
    plot: Annotated[list[str], PLOT] = NONE,
    port: Annotated[
        int | None,
        typer.Option(
            "--port", metavar="N", min=0, max=65535, rich_help_panel=SERVER,
            help="Port; by default 8642, or a free one.",
        ),
    ] = None,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.", rich_help_panel=SERVER)
    ] = True,
) -> None:  # fmt: skip
    """Show a motion in the browser while its file is edited."""
    measures_of(measure)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have switched it off for a background job
    settings = {"steps": steps, "derivatives": derivatives, "measure": measure, "plot": ",".join(plot)}
    try:
        _serve(model, changes, assembly, port, settings, browser)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        if sys.stdout.isatty():
            typer.echo()  # the terminal shows ^C


def _serve(
    model: str, changes: list[str], assembly: str, port: int | None, settings: dict[str, object], browser: bool
) -> None:
    from gimcli.library.load import is_address
    from gimcli.view.server import served

    if is_address(model):
        raise UsageError("an address does not change: write its model file with `gim convert` and view that")
    values = assignments(changes)
    with served(
        Path(model), values, assembly, port, settings, lambda text: note(printable(text)), progress_bar
    ) as server:
        end_bars()
        typer.echo(f"{Path(model).name}: {server.url} (Ctrl-C ends)")
        sys.stdout.flush()
        if browser:
            _open(server.url)
        server.serve_forever()


def _open(url: str) -> None:
    """Open the page in a browser with windows; one that uses the terminal would hide what is printed."""
    import webbrowser

    try:
        found = webbrowser.get()
    except webbrowser.Error:
        return
    if type(found) is not webbrowser.GenericBrowser:
        found.open(url)
