"""The file formats: one line each, for every command and for `Result.save`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from gimcli.errors import UsageError
from gimcli.output.csv import CsvStream, write_csv
from gimcli.output.dxf import require_ezdxf, write_dxf
from gimcli.output.gif import write_gif
from gimcli.output.html import write_html
from gimcli.output.json import write_json
from gimcli.output.model import write_model
from gimcli.output.mp4 import require_ffmpeg, write_mp4
from gimcli.output.npz import NpzStream, write_npz
from gimcli.output.parquet import ParquetStream, require_pyarrow, write_parquet
from gimcli.output.pdf import write_pdf
from gimcli.output.png import write_png
from gimcli.output.svg import write_svg
from gimcli.output.xlsx import ROWS, write_xlsx

Content = Literal["table", "arrays", "report", "picture", "animation", "model", "workbook", "geometry"]


@dataclass(frozen=True)
class Format:
    """A format: the name of the method of a result that returns the content, and the function that writes it."""

    content: Content
    write: Callable[[Any, Path], None]
    printed: bool = False  # whether the size, resolution, title and style of pictures apply
    require: Callable[[Path], None] | None = None  # raises OutputError if a program that it needs is missing
    stream: Callable[[Any, Sequence[str]], Any] | None = None  # to which tables are appended, such as CsvStream
    most_rows: int | None = None  # of a table


FORMATS: dict[str, Format] = {
    ".csv": Format("table", write_csv, stream=CsvStream),
    ".parquet": Format("table", write_parquet, require=require_pyarrow, stream=ParquetStream),
    ".npz": Format("arrays", write_npz, stream=NpzStream),
    ".json": Format("report", write_json),
    ".xlsx": Format("workbook", write_xlsx, most_rows=ROWS),
    ".png": Format("picture", write_png, printed=True),
    ".svg": Format("picture", write_svg, printed=True),
    ".pdf": Format("picture", write_pdf, printed=True),
    ".dxf": Format("geometry", write_dxf, require=require_ezdxf),
    ".html": Format("animation", write_html),
    ".yaml": Format("model", write_model),
    ".yml": Format("model", write_model),
    ".gif": Format("animation", write_gif, printed=True),
    ".mp4": Format("animation", write_mp4, True, require_ffmpeg),
}
"""The formats by their suffix."""


def format_of(path: Path | str, contents: tuple[str, ...] = ()) -> Format:
    """Return the format of a suffix; raise UsageError if it is unknown, or if its content is not one of `contents`."""
    suffix = Path(path).suffix.lower()
    known = {name: one for name, one in FORMATS.items() if not contents or one.content in contents}
    if suffix not in known:
        raise UsageError(f"{path}: expected one of the formats {', '.join(known)}, got '{suffix}'")
    return known[suffix]


def write(content: Any, path: Path | str) -> None:
    """Write a content, such as a table or a picture, in the format of the suffix of `path`."""
    format_of(path).write(content, Path(path))
