"""The file formats: one line each, for every command and for `Result.save`."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from gimcli.errors import OutputError, UsageError
from gimcli.output.csv import CsvStream, write_csv

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


def _late(module: str, name: str) -> Callable[..., Any]:
    """Return a function of a module of this package, which is imported when the function is called."""
    return lambda *given: getattr(import_module(f"gimcli.output.{module}"), name)(*given)


def _needs(package: str, files: str, extra: str) -> Callable[[Path], None]:
    """Return a function that raises OutputError if a package that writes some files is not installed."""

    def require(path: Path) -> None:
        logging.getLogger(package).addHandler(logging.NullHandler())  # ezdxf warns if it cannot write its list of fonts
        try:
            import_module(package)
        except ImportError:
            raise OutputError(f"{path}: {files} need {package}; run: pip install 'gimcli[{extra}]'") from None

    return require


_PICTURE = Format("picture", _late("figure", "write_picture"), printed=True)
_MODEL = Format("model", _late("model", "write_model"))

FORMATS: dict[str, Format] = {
    ".csv": Format("table", write_csv, stream=CsvStream),
    ".parquet": Format(
        "table", _late("parquet", "write_parquet"), require=_needs("pyarrow", "Parquet files", "parquet"),
        stream=_late("parquet", "ParquetStream"),
    ),
    ".npz": Format("arrays", _late("npz", "write_npz"), stream=_late("npz", "NpzStream")),
    ".json": Format("report", _late("json", "write_json")),
    ".xlsx": Format("workbook", _late("xlsx", "write_xlsx"), most_rows=1_048_575),
    ".png": _PICTURE,
    ".svg": _PICTURE,
    ".pdf": _PICTURE,
    ".dxf": Format("geometry", _late("dxf", "write_dxf"), require=_needs("ezdxf", "DXF files", "dxf")),
    ".html": Format("animation", _late("page.document", "write_html")),
    ".yaml": _MODEL,
    ".yml": _MODEL,
    ".gif": Format("animation", _late("film", "write_gif"), printed=True),
    ".mp4": Format("animation", _late("film", "write_mp4"), True, _late("film", "require_ffmpeg")),
}  # fmt: skip
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
