"""Printing: tables, JSON and notes; rich is loaded only when a table is drawn."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from gimcli.cli.progress import end_bars, print_above

if TYPE_CHECKING:
    from gimcli.library.record import Records
    from gimcli.mechanism import Mechanism
    from gimcli.motion.motion import Motion

WIDE = 160
"""Columns of a table that is not printed on a terminal."""

HEAD, MOST = 12, 10_000
"""Characters of a heading that is not broken, and of the longest line."""


def printable(text: str) -> str:
    """Return a text with control characters escaped, except line ends: a terminal would execute them."""
    return "".join(repr(sign)[1:-1] if sign != "\n" and not sign.isprintable() else sign for sign in text)


def print_json(data: dict[str, Any]) -> None:
    """Print one JSON object."""
    from gimcli.output.json import json_text

    end_bars()
    typer.echo(json_text(data))


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


def note(text: str) -> None:
    """Print a line on standard error, above the progress bar if there is one."""
    print_above(text)


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
