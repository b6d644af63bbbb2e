"""The only home of numba: run a kernel as it is or compile it, with the kernels that it calls.

A kernel is a plain module-level function marked `@kernel`; it runs as it stands for a small
job. `compiled(kernel)` gives the same source compiled. The cache of machine code lives in a
folder whose name is a hash of all kernel sources, so that an edit in a callee is noticed
(numba's own index looks at the caller's file only).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

COMPILER: dict[str, Any] = {"error_model": "numpy", "_nrt": False}
"""Kernels allocate nothing: counting references to the arrays of their records would cost more than they do."""

_KERNELS: set[Callable[..., Any]] = set()
_STAGES: set[Callable[..., Any]] = set()
_SCALAR_FORMS: dict[Callable[..., Any], Callable[..., Any]] = {}


def kernel(function: F) -> F:
    """Mark a function as a kernel; it stays the plain Python function that it is."""
    _KERNELS.add(function)
    return function


def stage(function: F) -> F:
    """Mark a function as a kernel that stays a function of its own in those that call it."""
    _STAGES.add(function)
    return kernel(function)


def scalar_form(scalar: Callable[..., Any]) -> Callable[[F], F]:
    """Mark a function of arrays as a kernel that is another function, of numbers, when compiled."""

    def mark(function: F) -> F:
        _KERNELS.add(function)
        _SCALAR_FORMS[function] = scalar
        return function

    return mark


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the compiled form of a kernel; the kernels that it calls are compiled into it."""
    return _compiled(function, inner=False)


@cache
def _compiled(function: Callable[..., Any], inner: bool) -> Callable[..., Any]:
    import numba

    folder = cache_folder()
    if folder is not None:
        setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010 - numba has no typed setter
    function = _SCALAR_FORMS.get(function, function)
    names = dict(function.__globals__)
    for name in function.__code__.co_names:
        callee = names.get(name)
        if callee is not None and callee in _KERNELS:
            built_in = _SCALAR_FORMS.get(callee)  # `range` itself: inside a call it would not vectorise
            inner = callee not in _STAGES
            names[name] = built_in if isinstance(built_in, type) else _compiled(callee, inner=inner)
    clone = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    clone.__module__ = function.__module__
    clone.__qualname__ = function.__qualname__
    keep = folder is not None and not inner
    jit: Callable[..., Any] = numba.njit(cache=keep, forceinline=inner, **COMPILER)(clone)
    return jit


def is_cached(*kernels: str) -> bool:
    """Tell whether the compiled forms of some kernels, by name, lie on disk for this source."""
    folder = cache_folder()
    if folder is None:
        return False
    names = [path.name for path in folder.rglob("*.nbc")]
    return all(any(f".{kernel}-" in name for name in names) for kernel in kernels)


@cache
def cache_folder() -> Path | None:
    """Return a writable folder for this source's machine code, or None where there is none."""
    return user_folder(source_stamp())


def user_folder(stamp: str) -> Path | None:
    """Return a writable folder of some name in the user's cache, or None where there is none.

    Machine code is loaded by unpickling: a folder that belongs to somebody else is not taken.
    """
    import tempfile

    home = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    user = str(os.getuid()) if hasattr(os, "getuid") else "user"
    for base in (Path(home) / "gimcli", Path(tempfile.gettempdir()) / f"gimcli-{user}"):
        folder = base / stamp
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            if hasattr(os, "getuid") and any(path.stat().st_uid != os.getuid() for path in (base, folder)):
                continue
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return None


def source_stamp() -> str:
    """Return a hash of all kernel sources."""
    import hashlib

    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
