"""Files that are written whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, BinaryIO, TextIO, cast

from gimcli.errors import OutputError, UsageError


@contextmanager
def written_text(path: Path | str) -> Iterator[TextIO]:
    """Give a UTF-8 text handle (line ends as written) whose file appears at the end, or never."""
    with _written(Path(path), "x") as handle:
        yield cast(TextIO, handle)


@contextmanager
def written_bytes(path: Path | str) -> Iterator[BinaryIO]:
    """Give a binary handle whose file appears at the end, or never."""
    with _written(Path(path), "xb") as handle:
        yield cast(BinaryIO, handle)


def refuse_unwritable(read: Iterable[Path], *paths: Path) -> None:
    """Raise UsageError where a file is one of those that were read, OutputError where it could not appear.

    It is called before the work that is to fill the files.
    """
    read = tuple(read)
    for path in paths:
        _refuse_read(read, path)
        part = _beside(path)
        try:
            _make_room(path)
            _opened(part, "xb").close()
        except OSError as fault:
            raise OutputError(_sentence(path, fault)) from fault
        finally:
            with suppress(OSError):
                part.unlink()


def _refuse_read(read: Iterable[Path], path: Path) -> None:
    """Raise UsageError where a path leads to a file that was read, by a link too."""
    for source in read:
        with suppress(OSError):
            if path.samefile(source):
                raise UsageError(
                    f"{path}: the model is read from this file ({source}); choose another name or folder for the output"
                )


@contextmanager
def _written(path: Path, mode: str) -> Iterator[IO[str] | IO[bytes]]:
    """Write beside `path` and rename; whatever fails, the temporary file goes and `path` stays."""
    part = _beside(path)
    try:
        _make_room(path)
        with _opened(part, mode) as handle:
            yield handle
        os.replace(part, path)
    except OSError as fault:
        raise OutputError(_sentence(path, fault)) from fault
    finally:
        with suppress(OSError):
            part.unlink()


def _beside(path: Path) -> Path:
    return path.parent / f".gim-{os.urandom(6).hex()}.part"


def _opened(part: Path, mode: str) -> IO[str] | IO[bytes]:
    if "b" in mode:
        return part.open("xb")
    return part.open("x", encoding="utf-8", newline="")


def _make_room(path: Path) -> None:
    """Create the folder, and refuse a target that a rename would wrongly replace."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        raise IsADirectoryError(21, "a folder has this name")
    if path.exists() and not path.is_file():
        raise OSError(22, "not a regular file")
    if path.exists() and not os.access(path, os.W_OK):
        raise PermissionError(13, "the file is write-protected")


def _sentence(path: Path, fault: OSError) -> str:
    """Return path, cause and cure."""
    cause = fault.strerror or str(fault)
    if isinstance(fault, (FileExistsError, NotADirectoryError)):
        return f"{path}: cannot be written: '{path.parent}' runs through a file; choose another folder"
    if isinstance(fault, PermissionError):
        return f"{path}: cannot be written: {cause}; choose a folder that you may write to"
    return f"{path}: cannot be written: {cause}; free the place or choose another"
