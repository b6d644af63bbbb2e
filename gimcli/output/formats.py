"""The file formats, one line each, and the rule for `-o`, for every command and for `Result.save`."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from gimcli.errors import OutputError, UsageError
from gimcli.output.atomic import refuse_unwritable

Content = Literal["table", "arrays", "report", "picture", "animation", "model", "workbook", "geometry"]


@dataclass(frozen=True)
class Format:
    """A format: the name of the method of a result that returns the content, and the function that writes it."""

    content: Content
    write: Callable[[Any, Any], None]
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
    ".csv": Format("table", _late("csv", "write_csv"), stream=_late("csv", "CsvStream")),
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


# -- the files of a command --------------------------------------------------------------------

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
