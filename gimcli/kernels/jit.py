"""Compilation of kernels, with the kernels that they call.

Only this module and `linking` import numba.

A kernel is a plain module-level function with the decorator `@kernel`; for small jobs it runs interpreted.
`compiled(kernel)` returns the compiled form of the same source. Machine code is cached in a folder whose name is a hash
of all kernel sources, so that a change in a called kernel is detected (numba's own index checks only the file of the
caller).

Machine code is on disk in one file for each kernel and signature, with a hash of its content. A damaged file (full
disk, interrupted copy) is deleted and its kernel is compiled again. numba's own cache files have no such hash, and
parallel processes share one index of them.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from stat import S_ISVTX, S_IWGRP, S_IWOTH
from types import FunctionType
from typing import Any, TypeVar

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

        if result.library.has_dynamic_globals:
            return
        data: bytes = serialize.dumps(result._reduce())  # type: ignore[no-untyped-call]  # numba is untyped
        path = self._path(signature, result.codegen)
        part = path.with_name(f"{path.name}.{os.urandom(6).hex()}.part")
        try:
            part.write_bytes(hashlib.sha256(data).digest() + data)
            os.replace(part, path)
        except OSError:
            with suppress(OSError):
                part.unlink()

    def _path(self, signature: Any, codegen: Any) -> Path:
        import numba

        built_for = (numba.__version__, sys.implementation.cache_tag, codegen.magic_tuple(), signature)
        return self.cache_path / f"{self._stem}.{hashlib.sha256(repr(built_for).encode()).hexdigest()[:24]}{SUFFIX}"


def _opened(data: bytes) -> bytes:
    """Return the content of a file with a hash; raises ValueError if the hash does not match."""
    if hashlib.sha256(data[SEAL:]).digest() != data[:SEAL]:
        raise ValueError("damaged")
    return data[SEAL:]


F = TypeVar("F", bound=Callable[..., Any])

COMPILER: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "nogil": True, "no_cfunc_wrapper": True}
"""Kernels allocate no memory, so they need no reference counts (`_nrt`), which would take longer than the arithmetic.
They do not use the interpreter, so that several threads can run them in parallel (`nogil`). No C code calls them."""

_KERNELS: set[Callable[..., Any]] = set()
_STAGES: set[Callable[..., Any]] = set()
_SCALAR_FORMS: dict[Callable[..., Any], Callable[..., Any]] = {}
_STUBS: dict[tuple[Callable[..., Any], str], Callable[..., Any]] = {}


def kernel(function: F) -> F:
    """Register a function as a kernel (decorator); the function itself is returned unchanged."""
    _KERNELS.add(function)
    return function


def stage(function: F) -> F:
    """Register a function as a kernel that is not inlined into its callers (decorator)."""
    _STAGES.add(function)
    return kernel(function)


def scalar_form(scalar: Callable[..., Any]) -> Callable[[F], F]:
    """Register a function of arrays as a kernel whose compiled form is the function `scalar` of numbers (decorator)."""

    def mark(function: F) -> F:
        _KERNELS.add(function)
        _SCALAR_FORMS[function] = scalar
        return function

    return mark


def stub(function: Callable[..., Any], variant: str) -> Callable[[F], F]:
    """Register a kernel that replaces `function` in a variant of its callers that never calls it (decorator)."""

    def mark(stand_in: F) -> F:
        _STUBS[function, variant] = stand_in
        return kernel(stand_in)

    return mark


def compiled(function: Callable[..., Any], variant: str = "") -> Callable[..., Any]:
    """Return the compiled form of a kernel, including the kernels that it calls.

    A variant contains stubs of the kernels that it never calls, and compiles faster. On disk its name is that of the
    kernel, `_`, and its own.
    """
    return _compiled(function, inner=False, variant=variant)


@cache
def _compiled(function: Callable[..., Any], inner: bool, variant: str = "") -> Callable[..., Any]:
    import numba

    from gimcli.kernels.linking import part

    function = _STUBS.get((function, variant), _SCALAR_FORMS.get(function, function))
    names = dict(function.__globals__)
    for name in function.__code__.co_names:
        callee = names.get(name)
        if callee is not None and callee in _KERNELS:
            built_in = _SCALAR_FORMS.get(callee)  # `range` itself: a call that returns it is not vectorised
            names[name] = built_in if isinstance(built_in, type) else _compiled(callee, True, variant)
    clone = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    clone.__module__ = function.__module__
    clone.__qualname__ = f"{function.__qualname__}_{variant}" if variant else function.__qualname__
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]  # set when numba is loaded
        return clone
    if inner:
        return part(clone, function not in _STAGES, COMPILER)
    jit: Callable[..., Any] = numba.njit(**COMPILER)(clone)
    folder = cache_folder()
    if folder is not None:
        jit._cache = MachineCode(clone, folder)  # type: ignore[attr-defined]  # replaces numba's own cache
    return jit


def is_cached(*kernels: str) -> bool:
    """Return whether the compiled forms of the named kernels are on disk for the present source."""
    folder = cache_folder()
    if folder is None:
        return False
    names = [path.name for path in folder.glob(f"*{SUFFIX}")]
    return all(any(f".{kernel}-" in name for name in names) for kernel in kernels)


@cache
def cache_folder() -> Path | None:
    """Return the folder for the machine code of the present source, or None if no folder is safe."""
    return user_folder(source_stamp())


def user_folder(name: str) -> Path | None:
    """Return a folder in the user's cache to which no other user can write, or None if there is none.

    Machine code is loaded by unpickling, which can run any code: files that others may have written are not safe.
    """
    import tempfile

    for base in _base_folders():
        try:
            for folder in (*reversed(base.parents), base, base / name):
                folder.mkdir(exist_ok=True, mode=0o700)
            if not (_is_private(base) and _is_private(base / name)):
                continue
            with tempfile.TemporaryFile(dir=base / name):
                return base / name
        except OSError:
            continue
    return None


def _base_folders() -> Iterator[Path]:
    """Yield the folders in which the cache may be: in the user's cache, and in the folder of temporary files."""
    import tempfile

    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    if os.path.isabs(cache):  # a user without own folders has "~"
        yield Path(cache) / "gimcli"
    with suppress(OSError):  # no folder for temporary files
        yield Path(tempfile.gettempdir()) / f"gimcli-{os.getuid() if hasattr(os, 'getuid') else 'user'}"


def _is_private(folder: Path) -> bool:
    """Return whether a folder belongs to the user and no other user can write to it or replace it."""
    if not hasattr(os, "getuid"):
        return True
    status = folder.stat()
    own = folder.lstat().st_uid == status.st_uid == os.getuid() and not status.st_mode & (S_IWGRP | S_IWOTH)
    modes = (above.stat().st_mode for above in folder.resolve().parents)
    return own and all(not mode & S_IWOTH or mode & S_ISVTX for mode in modes)  # only owners can rename files


def source_stamp() -> str:
    """Return a hash of all kernel sources."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
