"""Called kernels as parts of their caller's module, so that the compiler optimises all code of a call once.

numba by itself makes each called function executable, with wrappers for Python and C, compiles it again for each
combination of constants, and optimises it again with each of its callers. Here a called kernel is only translated to
the compiler's intermediate code.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import _dynfunc  # type: ignore[attr-defined]  # compiled, without types
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher


class PartLibrary(JITCodeLibrary):
    """The code of a called kernel and of its callees: not optimised, not executable."""

    def finalize(self) -> None:
        """Add the code of the callees."""
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


class PartCompiler(Compiler):
    """Translates a called kernel."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Translate a Python function (numba's name and signature)."""
        context = self.state.targetctx
        context.get_executable = _without_code
        self.state.library = PartLibrary(context.codegen(), func.__qualname__)  # type: ignore[no-untyped-call]  # numba is untyped
        return super().compile_extra(func)  # type: ignore[no-untyped-call]  # numba is untyped


def _without_code(library: Any, description: Any, environment: Any) -> Any:
    """Return the function object by which numba identifies a kernel; it has no machine code."""
    library._ensure_finalized()
    name = description.qualname.split(".")[-1]
    return _dynfunc.make_function(description.lookup_module(), name, "", 0, environment, (library,))


class PartDispatcher(CPUDispatcher):
    """A called kernel, which is not specialised for constants."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return the template of a call (numba's name and signature)."""
        return super().get_call_template(tuple(map(types.unliteral, args)), kws)


def part(function: Callable[..., Any], inline: bool, options: dict[str, Any]) -> Callable[..., Any]:
    """Return a kernel that only other kernels can call. inline: always inlined, else if the compiler chooses to."""
    options = options | {"nopython": True, "forceinline": inline, "no_cpython_wrapper": True}
    return PartDispatcher(function, {}, options, PartCompiler)
