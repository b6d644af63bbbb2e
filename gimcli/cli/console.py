"""What the terminal shows: tables, JSON, notes, and progress; rich is loaded only when a table or a bar is drawn.

Progress is a bar that appears after a second and names the phase of the computation. A spinner and the time turn
whether or not the work reports how far it has come.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from threading import RLock, Timer
from typing import TYPE_CHECKING, Any

import typer

from gimcli import output
from gimcli.progress import Progress, no_progress

if TYPE_CHECKING:
    from gimcli.library.record import Records
    from gimcli.mechanism import Mechanism
    from gimcli.motion.motion import Motion

DRAWING = "drawing"
"""Name of the last phase of most commands."""

DELAY = 1.0
"""Seconds before the bar appears."""

_phases: list[_Phase] = []
_bars: list[Any] = []
_lock = RLock()


def progress_bar(label: str) -> Progress:
    """Begin a phase and end the previous one; return a function of (done, total) that moves its bar."""
    if not sys.stderr.isatty():
        return no_progress
    end_bars()
    phase = _Phase(label)
    _phases.append(phase)
    phase.timer.start()
    return phase.show


def end_bars() -> None:
    """Remove the bar and show the cursor again: before a report, and whenever the program ends."""
    with _lock:
        while _phases:
            _phases.pop().timer.cancel()
        while _bars:
            _bars.pop().stop()


def note(text: str) -> None:
    """Print a line on standard error, above the bar if there is one."""
    with _lock:
        if _bars:
            _bars[-1].console.print(text, markup=False, highlight=False, soft_wrap=True)
        else:
            print(text, file=sys.stderr, flush=True)


class _Phase:
    """A phase that may take long; a timer opens its bar, also if the computation does not report progress."""

    def __init__(self, label: str) -> None:
        import time

        self.label, self.clock, self.start = label, time.monotonic, time.monotonic()
        self.bar: Any = None
        self.known = 0, 0
        self.timer = Timer(DELAY, self.open)
        self.timer.daemon = True

    def open(self) -> None:
        """Show the bar, unless the phase has ended."""
        with _lock:
            if self not in _phases or self.bar is not None:
                return
            self.bar = _started()
            self.task = self.bar.add_task(self.label, total=None, part="")
            self.report()

    def show(self, done: int, of: int) -> None:
        """Report the progress: `done` of `of` parts."""
        with _lock:
            self.known = done, of
            if self.bar is not None:
                self.report()
            elif self.clock() - self.start >= DELAY:
                self.open()

    def report(self) -> None:
        """Move the bar; after the last part it shows activity only, as the rest of the phase does not report."""
        done, of = self.known
        if done < of:
            self.bar.update(self.task, completed=done, total=of, part=f"{100 * done // of} %")
        else:
            self.bar.update(self.task, total=None, part="")


def _started() -> Any:
    """Return a bar on the terminal; standard output is not changed."""
    import atexit

    from rich.console import Console
    from rich.progress import BarColumn, Progress as Bar, SpinnerColumn, TextColumn, TimeElapsedColumn

    atexit.register(end_bars)
    part = TextColumn("{task.fields[part]}")
    columns = (SpinnerColumn(), "{task.description}", BarColumn(), part, TimeElapsedColumn())
    bar = Bar(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False, redirect_stderr=False)
    bar.start()
    _bars.append(bar)
    return bar


WIDE = 160
"""Columns of a table that is not printed on a terminal."""

HEAD, MOST = 12, 10_000
"""Characters of a heading that is not broken, and of the longest line."""


def printable(text: str) -> str:
    """Return a text with control characters escaped, except line ends: a terminal would execute them."""
    return "".join(repr(sign)[1:-1] if sign != "\n" and not sign.isprintable() else sign for sign in text)


def print_json(data: dict[str, Any]) -> None:
    """Print one JSON object."""
    end_bars()
    typer.echo(output.json_text(data))


def print_table(title: str, head: Sequence[str], rows: Iterable[Iterable[str]], right: Iterable[int] = ()) -> None:
    """Print a table; columns in `right` are numbers: they are never broken, even if the table becomes too wide."""
    from rich import box
    from rich.console import Console
    from rich.measure import Measurement
    from rich.table import Table

    end_bars()
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.show_header = any(head)
    numbers = set(right)
    for k, name in enumerate(head):
        table.add_column(
            name, justify="right" if k in numbers else "left", overflow="fold", no_wrap=k in numbers,
            min_width=min(HEAD, len(name)),
        )  # fmt: skip
    for row in rows:
        table.add_row(*row)
    console = Console(highlight=False, markup=False, soft_wrap=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=WIDE)
    least = Measurement.get(console, console.options.update(max_width=MOST), table).minimum
    console.width = max(console.width, least)
    with console.capture() as drawn:  # rich itself would end the program where the reader has gone away
        if title:
            console.print(title, style="bold", soft_wrap=True)  # a title of the table's own would be as narrow as that
        console.print(table)
    typer.echo(drawn.get(), nl=False)


def print_records(
    title: str, records: Records, *names: str, most: int | None = None, where: str = "--json lists all"
) -> None:
    """Print the first rows of a list below its title, with the fields of the given names; of no rows the title only."""
    head, rows, right = records.cells(*names)
    if rows:
        print_table(title, head, rows[:most], right)
        print_more(len(rows), len(rows) if most is None else most, where)
    elif title:
        typer.echo(title)


def print_remarks(*remarks: str | tuple[object, str]) -> None:
    """Print sentences, of those that come after a condition the ones that hold."""
    for one in remarks:
        holds, text = (True, one) if isinstance(one, str) else one
        if holds:
            typer.echo(text)


def print_written(paths: Sequence[Path]) -> None:
    """Print which files were written, if any."""
    if paths:
        named = [str(path) for path in paths]
        typer.echo("wrote " + ", ".join(named[:-1]) + " and " * (len(named) > 1) + named[-1])


def print_more(count: int, shown: int, where: str = "--json lists all") -> None:
    """Print how many rows are not shown, if any, and where they are."""
    if count > shown:
        typer.echo(f"... and {count - shown} more ({where})")


def print_status(motion: Motion) -> None:
    """Print the status of the first row of a motion that is not solved, its cause and the cure."""
    from gimcli.motion.unassembled import motion_reason

    typer.echo(f"{motion.overall.word}: {motion_reason(motion)}")


def room() -> int:
    """Return the width of standard output in characters."""
    import shutil

    return shutil.get_terminal_size().columns if sys.stdout.isatty() else WIDE


def note_doubtful_loading(mechanism: Mechanism) -> None:
    """Print which members are point masses, as the file gives no moment of inertia, and which tables are too short."""
    from gimcli.dynamics.load_arrays import point_masses
    from gimcli.library.check_warnings import short_table_warnings

    for _, text in short_table_warnings(mechanism):
        note(text)
    names = point_masses(mechanism)
    if names:
        note(
            f"`masses`: no `inertia` is given for {', '.join(names)}; 0 is used (point mass);"
            " write `inertia: 0` to hide this note"
        )


def print_turns(mechanism: Mechanism) -> None:
    """Say for which turns a list of configurations holds, if inputs follow others with ratios that are not whole."""
    from gimcli.positions.inputs import turns_until_repeated

    turns = turns_until_repeated(mechanism)
    if turns == 1:
        return
    name = mechanism.actuators[mechanism.drivers[0]].name
    repeated = "never repeat" if turns is None else f"repeat after {turns} turns of {name}"
    typer.echo(
        f"the inputs that follow {name} {repeated}: the list holds for the given turns only; other turns of {name}"
        " have other configurations"
    )
