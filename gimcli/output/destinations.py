"""Output files: the rule for `-o` of every command and for `Result.save`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from gimcli.errors import UsageError
from gimcli.output.atomic import refuse_unwritable
from gimcli.output.formats import FORMATS, format_of

STDOUT = "-"
"""The name of standard output."""


@dataclass(frozen=True)
class Destinations:
    """The files to write, and whether the table is written to standard output."""

    files: tuple[Path, ...] = ()
    named: frozenset[Path] = frozenset()  # files that the user named; the others are the usual ones of a folder
    stdout: bool = False

    def of(self, *contents: str) -> tuple[Path, ...]:
        """Return the files with the given contents ("table", "arrays", "report", "picture")."""
        return tuple(path for path in self.files if format_of(path).content in contents)

    @property
    def prints(self) -> bool:
        """Whether there is a file to which the options of pictures apply."""
        return any(format_of(path).printed for path in self.files)

    def refuse(self, read: Iterable[Path]) -> None:
        """Raise UsageError if the model was read from a file, OutputError if a file cannot be written."""
        for path in self.files:
            if (require := format_of(path).require) is not None:
                require(path)
        refuse_unwritable(read, *self.files)


def destinations(out: Sequence[Path | str], stem: str, usual: Sequence[str], known: Sequence[str] = ()) -> Destinations:
    """Return the output files.

    An entry of `out` is a folder if the folder exists and has no suffix of a file format, or if the entry ends with a
    slash or has no suffix; the folder gets `stem` with the `usual` suffixes. "-" is the table as CSV on standard
    output. Any other entry is a file. `known` are
    the suffixes that the result has, by default all. Raises UsageError for any other.
    """
    files: dict[Path, bool] = {}
    for given in map(str, out):
        if given == STDOUT:
            continue
        path = Path(given)
        known_format = path.suffix.lower() in FORMATS
        if given.endswith(("/", "\\")) or not path.suffix or (path.is_dir() and not known_format):
            for suffix in usual:
                files.setdefault(path / f"{stem}{suffix}", False)
            continue
        if path.suffix.lower() not in (known or FORMATS):
            folder = "" if known_format else "; the name of a folder with a dot needs / at its end"
            formats = ", ".join(known or FORMATS)
            raise UsageError(f"{given}: expected one of the formats {formats}, got '{path.suffix}'{folder}")
        files[path] = True
    named = frozenset(path for path, by_name in files.items() if by_name)
    return Destinations(tuple(files), named, STDOUT in map(str, out))
