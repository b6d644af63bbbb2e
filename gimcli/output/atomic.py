"""Atomic writing of files: a file is written under a temporary name and then renamed."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, TextIO

from gimcli.errors import OutputError, UsageError, reason


def written_text(path: Path | str) -> AbstractContextManager[TextIO]:
    """Yield a UTF-8 text handle that does not convert line ends; the file appears only if the block succeeds."""
    return _written(Path(path), "x")


def written_bytes(path: Path | str) -> AbstractContextManager[BinaryIO]:
    """Yield a binary handle; the file appears only if the block succeeds."""
    return _written(Path(path), "xb")


def refuse_unwritable(read: Iterable[Path], *paths: Path) -> None:
    """Raise UsageError for a file that was read, and OutputError for a file that cannot be written.

    It is called before the computation, so that no result is lost.
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
    """Raise UsageError if a path leads to a file that was read, also through a link."""
    for source in read:
        with suppress(OSError):
            if path.samefile(source):
                raise UsageError(
                    f"{path}: the input is read from this file ({source}); choose another name or folder for the output"
                )


@contextmanager
def _written(path: Path, mode: str) -> Iterator[Any]:
    """Write to a temporary file beside `path` and rename it; after an error it is removed and `path` is unchanged."""
    path = path.resolve() if path.is_symlink() else path  # the target of a link is written, the link stays
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


def _opened(part: Path, mode: str) -> Any:
    return part.open("xb") if "b" in mode else part.open("x", encoding="utf-8", newline="")


def _make_room(path: Path) -> None:
    """Create the folder; raise OutputError for a target that a rename must not replace."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir() or (path.exists() and not path.is_file()):
        cause = "a folder has this name" if path.is_dir() else "not a regular file"
        raise OutputError(f"{path}: cannot be written: {cause}; choose another path")
    if path.exists() and not os.access(path, os.W_OK):
        raise OutputError(f"{path}: cannot be written: the file is write-protected; choose another name")


def _sentence(path: Path, fault: OSError) -> str:
    """Return the message: path, cause and correction."""
    if isinstance(fault, (FileExistsError, NotADirectoryError)):
        return f"{path}: cannot be written: a part of '{path.parent}' is a file, not a folder; choose another folder"
    if isinstance(fault, PermissionError):
        return f"{path}: cannot be written: {reason(fault)}; choose a folder with write permission"
    return f"{path}: cannot be written: {reason(fault)}; choose another path"
