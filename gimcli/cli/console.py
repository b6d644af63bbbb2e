"""Printing: tables, JSON and notes; rich is loaded only when a table is drawn."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import typer

from gimcli.cli.progress import end_bars, print_above

if TYPE_CHECKING:
    from gimcli.library.result import Result
    from gimcli.mechanism import Mechanism
    from gimcli.motion.motion import Motion
    from gimcli.table import Table

WIDE = 160
"""Columns where no terminal tells how many there are."""

HEAD, MOST = 12, 10_000
"""Characters of a head that are not broken, and of the widest line."""


def printable(text: str) -> str:
    """Return a text whose control characters, line ends apart, are written out: a terminal obeys them."""
    return "".join(repr(sign)[1:-1] if sign != "\n" and not sign.isprintable() else sign for sign in text)


def print_json(data: dict[str, Any]) -> None:
    """Print one JSON object."""
    from gimcli.library.result import plain

    end_bars()
    typer.echo(json.dumps(plain(data), ensure_ascii=False))


def print_table(title: str, head: Sequence[str], rows: Iterable[Iterable[str]], right: Iterable[int] = ()) -> None:
    """Print a table; columns named in `right` are numbers, which are never broken: rather the table is too wide."""
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


def loaded(model: Path, csv: Path | None, png: Path | None) -> Mechanism:
    """Return the mechanism of a model file; refuse files that cannot be written before the work that fills them."""
    from gimcli.library.load import load
    from gimcli.output import refuse_files

    mechanism = load(model)
    refuse_files(mechanism.files, csv, png)
    return mechanism


def files_in(out: Path, stem: str, png: bool, mechanism: Mechanism) -> tuple[Path, Path | None]:
    """Return the table and the picture that a command writes into a folder; refuse what cannot be written."""
    from gimcli.output import refuse_unwritable

    table, picture = out / f"{stem}.csv", out / f"{stem}.png" if png else None
    refuse_unwritable(mechanism.files, table, *([picture] if picture else []))
    return table, picture


def write_picture(result: Result, picture: Path | None) -> dict[str, Path | None]:
    """Write a result's picture where it is asked for; return it, for the report."""
    return {"png": write_files(result, None, picture)["png"]}


def write_files(result: Result, table: Path | None, picture: Path | None) -> dict[str, Path | None]:
    """Write a result's table and picture where they are asked for; return which were written, for the report."""
    from gimcli.cli.progress import DRAWING, progress_bar
    from gimcli.output import write

    if table is not None:
        write(result.table(), table)
    content = None
    if picture is not None:
        progress_bar(DRAWING)
        content = result.picture()
        if content is not None:
            write(content, picture)
    return {"csv": table, "png": picture if content is not None else None}


Kind = TypeVar("Kind", bound="Result", covariant=True)


class Stream(Protocol[Kind]):
    """A result under way: tables of its pieces, then the result."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        ...

    def tables(self) -> Iterator[Table]:
        """Yield the table of each piece."""
        ...

    def result(self, table: Table | None) -> Kind:
        """Return the result, when all tables have been taken."""
        ...


def write_stream(stream: Stream[Kind], table: Path, picture: Path | None) -> tuple[Kind, dict[str, Path | None]]:
    """Write the tables of a result under way and its picture; the table appears when both are done."""
    from gimcli.output import CsvStream

    with CsvStream(table, stream.names) as rows:
        for piece in stream.tables():
            rows.append(piece)
        found = stream.result(None)
        paths = write_files(found, None, picture)
    return found, {**paths, "csv": table}


Shown = TypeVar("Shown", bound="Result")


def finish(
    found: Shown, paths: dict[str, Path | None], as_json: bool, show: Callable[[Shown], None], paths_first: bool = False
) -> None:
    """Print the report, or what people read and which files were written; exit with 5 where something is missing."""
    if as_json:
        named = {kind: None if path is None else str(path) for kind, path in paths.items()}
        print_json({**named, **found.report()} if paths_first else {**found.report(), **named})
    else:
        end_bars()
        show(found)
        print_written(*paths.values())
    if not found.answered:
        raise typer.Exit(5)


def print_written(*paths: Any) -> None:
    """Say which files were written, if any; None stands for one that was not."""
    told = [str(path) for path in paths if path is not None]
    if told:
        typer.echo("wrote " + ", ".join(told[:-1]) + " and " * (len(told) > 1) + told[-1])


def print_more(count: int, shown: int, where: str = "--json names all") -> None:
    """Say how many rows are not shown, if any, and where they are."""
    if count > shown:
        typer.echo(f"... and {count - shown} more ({where})")


def print_status(motion: Motion) -> None:
    """Say what ended the first row of a motion that is not solved, and the cure."""
    worst = f" (worst: {motion.worst})" if motion.worst else ""
    typer.echo(f"{motion.overall.word}: {motion.overall.text}{worst}")


def how_it_ends(closed: bool, ended: str, turns: float) -> str:
    """Return whether a circuit is closed, after how many turns, or what ends it."""
    after = f" after {abs(turns):g} turn{'s' * (abs(turns) != 1)}" if turns else ""
    return f"closed{after}" if closed else ended


def intervals(spans: Mapping[str, Sequence[float]], between: str = "; ") -> str:
    """Return the intervals of the inputs by their names."""
    return between.join(f"{name} {number(low)} to {number(high)}" for name, (low, high) in spans.items())


def room() -> int:
    """Return the columns that standard output has room for."""
    import shutil

    return shutil.get_terminal_size().columns if sys.stdout.isatty() else WIDE


def note(text: str) -> None:
    """Print a line for the user's eyes, above a bar that goes on; standard output stays clean."""
    print_above(text)


def note_point_masses(mechanism: Mechanism) -> None:
    """Print which members count as point masses because the file gives no moment of inertia."""
    from gimcli.dynamics.load_arrays import point_masses

    names = point_masses(mechanism)
    if names:
        note(f"masses: no `inertia` for {', '.join(names)}: taken as 0, as of a point mass (`inertia: 0` confirms it)")


def number(value: float, digits: int = 10) -> str:
    """Return a number readable in a table."""
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"
