"""Machine code on disk: one file for each kernel and signature, with a hash of its content.

A damaged file (full disk, interrupted copy) is deleted and its kernel is compiled again. numba's own cache files have
no such hash, and parallel processes share one index of them.
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
"""Number of bytes of the hash at the start of a file."""


class MachineCode:
    """The compiled forms of one kernel in a folder, with the interface of the cache of numba's dispatcher."""

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        module = function.__module__.rpartition(".")[2]
        self._stem = f"{module}.{function.__qualname__}-{function.__code__.co_firstlineno}"
        self.cache_path = folder

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the compile result for a signature; None if it is missing or damaged.

        numba's own cache first loads all that its compiler needs; machine code runs without.
        """
        from numba.core import compiler

        result: Any = compiler.CompileResult
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
        """Write a compile result atomically; if that fails, it is not cached."""
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
    """Return the content of a file with a hash; raises ValueError if the hash does not match."""
    if hashlib.sha256(data[SEAL:]).digest() != data[:SEAL]:
        raise ValueError("damaged")
    return data[SEAL:]
