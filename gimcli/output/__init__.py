"""Everything that is written to a file: one file per format, one line here for each.

A picture is made by a function of one of the modules here and written by `write`. Importing this package is cheap:
matplotlib is imported when a picture is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from gimcli.errors import UsageError
from gimcli.output.atomic import refuse_unwritable, written_bytes, written_text
from gimcli.output.csv import CsvStream, refuse_repeated, write_csv
from gimcli.output.npz import write_npz
from gimcli.output.parts import Parts
from gimcli.output.pdf import write_pdf
from gimcli.output.png import write_png
from gimcli.output.svg import write_svg
from gimcli.table import Table

if TYPE_CHECKING:
    from gimcli.output.picture import Content

__all__ = [
    "PICTURE_FORMATS", "TABLE_FORMATS", "CsvStream", "Parts", "refuse_files", "refuse_repeated", "refuse_unwritable",
    "write", "write_csv", "write_npz", "written_bytes", "written_text",
]  # fmt: skip

Written = TypeVar("Written")
Formats = dict[str, Callable[[Written, Path], None]]

TABLE_FORMATS: Formats[Table] = {
    ".csv": write_csv,
}
PICTURE_FORMATS: Formats[Content] = {
    ".png": write_png,
    ".svg": write_svg,
    ".pdf": write_pdf,
}


def write(content: Table | Content, path: Path | str) -> None:
    """Write a table or a picture in the format that the suffix of `path` names."""
    if isinstance(content, Table):
        _write(content, Path(path), TABLE_FORMATS, "table")
    else:
        _write(content, Path(path), PICTURE_FORMATS, "picture")


def refuse_files(read: Iterable[Path], table: Path | None, picture: Path | None) -> None:
    """Raise UsageError where a suffix names no format; otherwise as `refuse_unwritable`."""
    if table is not None:
        _writer(table, TABLE_FORMATS, "table")
    if picture is not None:
        _writer(picture, PICTURE_FORMATS, "picture")
    refuse_unwritable(read, *(path for path in (table, picture) if path is not None))


def _write(content: Written, path: Path, formats: Formats[Written], what: str) -> None:
    _writer(path, formats, what)(content, path)


def _writer(path: Path, formats: Formats[Written], what: str) -> Callable[[Written, Path], None]:
    writer = formats.get(path.suffix.lower())
    if writer is None:
        raise UsageError(f"{path}: no {what} is written as '{path.suffix}'; choose {', '.join(formats)}")
    return writer
