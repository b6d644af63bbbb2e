"""The output of a command: the files of `-o` or the usual files, and the table on standard output."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, nullcontext, redirect_stdout
from pathlib import Path
from typing import Any, TypeVar

import typer

from gimcli import output
from gimcli.cli.arguments import NO_OPTIONS, NONE, Drawing, changed
from gimcli.cli.console import DRAWING, end_bars, note, print_json, print_written, printable, progress_bar
from gimcli.errors import OutputError, UsageError, refuse
from gimcli.library.load import decided, is_address, load_undecided
from gimcli.library.result import Result, UnderWay, joined, write_contents
from gimcli.mechanism import Mechanism
from gimcli.output import FORMATS, format_of, refuse_unwritable
from gimcli.status import Status
from gimcli.table import Table

CSV = FORMATS[".csv"]
"""The format of tables on standard output."""

WHOLE = ("table", "arrays", "workbook", "geometry")
"""Contents for which all rows of the table are kept."""

REPORTED = {"table": "csv", "picture": "png", "arrays": "npz"}
"""Keys in the JSON report for the first file of each kind of content."""

Found = TypeVar("Found", bound=Result)


def read(model: str) -> Mechanism:
    """Return the mechanism of a model argument; print what did not come over from another program's file.

    The side of a node without coordinates may still be open.
    """
    mechanism = load_undecided(model)
    for sentence in mechanism.left_out:
        note(printable(f"{mechanism.name}: {sentence}"))
    return mechanism


def started(
    mechanism: Mechanism, assembly: str, at: Mapping[str, str] | None = None, tolerance: float = 1e-10
) -> Mechanism:
    """Return a mechanism in the configuration of --assembly; without it, refuse one with a node whose side is open."""
    if not assembly:
        return decided(mechanism)
    from gimcli.library.assembled import assembled

    return assembled(mechanism, at, assembly, tolerance=tolerance, progress=progress_bar)


class Outputs:
    """The files of one command, and its report.

    `writes`: without `-o` the usual files are written into the current folder. `picture`: the picture is one of them.
    `more`: further suffixes of usual files. `csv` and `png`: files that the options of these names give. `drawing`: the
    options of pictures that were given.
    """

    def __init__(
        self, result: type[Result], model: str, out: Sequence[str], *, writes: bool = False, picture: bool = True,
        more: Sequence[str] = (), csv: Path | None = None, png: Path | None = None, as_json: bool = False,
        drawing: Drawing = NO_OPTIONS,
    ) -> None:  # fmt: skip
        named = _named(csv, ("table",), "--csv") + _named(png, ("picture",), "--png")
        self.chosen = bool(out or named)
        asked = [*out, *named] or ["./"] * writes
        self.model, self.as_json = model, as_json
        stem = "mechanism" if is_address(model) else Path(model).stem
        self.files = result.destinations(asked, stem, picture, more)
        refuse(
            (
                as_json and self.files.stdout,
                "-o - and --json both use standard output: write the table to a file, such as -o table.csv",
            ),
            (
                drawing and not self.files.prints,
                f"--{next(iter(drawing), '')} changes the picture, but no picture is written: use -o FILE.png",
            ),
        )
        if self.files.stdout and sys.__stdout__ is None:
            raise OutputError("-o -: standard output is closed; write the table to a file, such as -o table.csv")
        self.written: list[Path] = []
        self.options: output.printed.PictureOptions | None = None
        if drawing:
            self.options = output.printed.PictureOptions.checked(**drawing)

    @property
    def draws(self) -> bool:
        """Return whether a picture or a page is written."""
        return bool(self.files.of("picture", "animation"))

    def loaded(
        self, assembly: str = "", at: Mapping[str, str] | None = None, tolerance: float = 1e-10, *,
        changes: list[str] = NONE, every: bool = False,
    ) -> Mechanism:  # fmt: skip
        """Return the mechanism of the model file; refuse files that cannot be written, before the computation.

        `changes` are the values of --set. With --assembly the mechanism is assembled in that configuration at the start
        of the laws, or at the inputs of --at; without it, ModelError is raised if the side of a node is open, unless
        `every` configuration is wanted.
        """
        mechanism = read(self.model)
        self._refuse(mechanism.files)
        mechanism = changed(mechanism, changes)
        return mechanism if every and not assembly else started(mechanism, assembly, at, tolerance)

    def _refuse(self, read: Iterable[Path]) -> None:
        """Refuse files that cannot be written; where the user chose no folder, name the option."""
        try:
            self.files.refuse(read)
        except OutputError as refused:
            raise refused if self.chosen else OutputError(f"{refused} (-o FOLDER)") from None

    def write(self, result: Result) -> None:
        """Write the result's files, and its table to standard output if asked."""
        if self.files.stdout:
            CSV.write(result.table(), sys.stdout)
        self._write(result, self.files.files)

    def stream(self, under_way: UnderWay[Found]) -> Found:
        """Write the rows of a result while it is computed; all files appear when the result is complete."""
        streamed = tuple(path for path in self.files.files if format_of(path).stream is not None)
        others = tuple(path for path in self.files.files if path not in streamed)
        kept: list[Table] | None = [] if any(format_of(path).content in WHOLE for path in others) else None
        self._refuse_long(under_way.expected or 0)
        with ExitStack() as stack:
            own = [(format_of(path).stream, path) for path in streamed]
            targets: list[Any] = [*own, *([(CSV.stream, sys.stdout)] if self.files.stdout else [])]
            rows = [stack.enter_context(stream(target, under_way.names)) for stream, target in targets]
            for piece in under_way.tables():
                for one in rows:
                    one.append(piece)
                if kept is not None:
                    kept.append(piece)
                    self._refuse_long(sum(map(len, kept)))
            found = under_way.result(None if kept is None else joined(kept))
            self._write(found, others)
        self.written = [*streamed, *self.written]
        return found

    def _refuse_long(self, rows: int) -> None:
        """Raise UsageError for a file that does not hold so many rows."""
        most = {path: limit for path in self.files.files if (limit := format_of(path).most_rows) is not None}
        text = "use fewer steps, or .csv"
        refuse(*((rows > n, f"{path}: {rows} rows, the format has at most {n}: {text}") for path, n in most.items()))

    def _write(self, result: Result, paths: tuple[Path, ...]) -> None:
        if self.draws:
            progress_bar(DRAWING)
        self.written = write_contents(result.contents(paths), self.options)

    def show(self, found: Result, printed: Callable[[Any], None]) -> None:
        """Print the report, of each independent machine, or its JSON object; exit with 5 if a part is missing."""
        if self.as_json:
            print_json({**found.report(), **self.report()})
        else:
            end_bars()
            with redirect_stdout(sys.stderr) if self.files.stdout else nullcontext():
                for name, one in found.by_machine().items():
                    if name:
                        typer.echo(f"{name}:")
                    printed(one)
                if found.limited:
                    typer.echo(f"{found.outcome}: {Status.WORK_LIMIT.text}")
                print_written(self.written)
        if found.limited or not found.answered:
            raise typer.Exit(5)

    def report(self) -> dict[str, Any]:
        """Return the files that were written, for --json."""
        first: dict[str, str | None] = {"csv": None, "png": None}
        for path in reversed(self.written):
            name = REPORTED.get(format_of(path).content)
            if name:
                first[name] = str(path)
        return {**first, "files": [str(path) for path in self.written]}


def _named(path: Path | None, contents: tuple[str, ...], option: str) -> list[str]:
    """Return the file of --csv or --png; refuse a suffix with other contents."""
    if path is None:
        return []
    try:
        format_of(path, contents)
    except UsageError as refused:
        raise UsageError(f"{option} {refused}") from None
    refuse_unwritable((), path)  # a folder of this name is no folder to write into
    return [str(path)]
