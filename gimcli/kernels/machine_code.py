"""Machine code on disk: one file for each kernel and signature, sealed with a hash of what it holds.

A file that is damaged (a full disk, a killed copy) is discarded and its kernel is compiled again. The compiler's own
files have no seal, and processes that run at once share an index of them.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

SUFFIX = ".nbc"
SEAL = hashlib.sha256().digest_size
"""Bytes of the hash before what a file holds."""


class MachineCode:
    """The compiled forms of one kernel in a folder, as numba's dispatcher asks for them."""

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        module = function.__module__.rpartition(".")[2]
        self._stem = f"{module}.{function.__qualname__}-{function.__code__.co_firstlineno}"
        self.cache_path = folder

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the compile result for a signature; None where there is none, or where it is damaged."""
        from numba.core import compiler

        result: Any = compiler.CompileResult
        target.refresh()
        path = self._path(signature, target.codegen())
        try:
            return result._rebuild(target, *pickle.loads(_opened(path.read_bytes())))
        except FileNotFoundError:
            return None
        except Exception:  # whatever a damaged file raises: the kernel is compiled again
            with suppress(OSError):
                path.unlink()
            return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Write a compile result, whole or not at all; where that fails, do without."""
        from numba.core import serialize

        dumps: Any = serialize.dumps
        if result.library.has_dynamic_globals:
            return
        path = self._path(signature, result.codegen)
        part = path.with_name(f"{path.name}.{os.urandom(6).hex()}.part")
        try:
            part.write_bytes(_sealed(dumps(result._reduce())))
            os.replace(part, path)
        except OSError:
            with suppress(OSError):
                part.unlink()

    def _path(self, signature: Any, codegen: Any) -> Path:
        import numba

        built_for = (numba.__version__, sys.implementation.cache_tag, codegen.magic_tuple(), signature)
        return self.cache_path / f"{self._stem}.{hashlib.sha256(repr(built_for).encode()).hexdigest()[:24]}{SUFFIX}"


def _sealed(data: bytes) -> bytes:
    return hashlib.sha256(data).digest() + data


def _opened(data: bytes) -> bytes:
    """Return what a sealed file holds; raise ValueError where it is not what was written."""
    if hashlib.sha256(data[SEAL:]).digest() != data[:SEAL]:
        raise ValueError("damaged")
    return data[SEAL:]
