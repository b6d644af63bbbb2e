"""Results that are computed once per mechanism and cached with it."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

from gimcli.mechanism import Mechanism

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def derived(
    function: Callable[Concatenate[Mechanism, Arguments], Result],
) -> Callable[Concatenate[Mechanism, Arguments], Result]:
    """Cache the results of a function of a mechanism in the mechanism (decorator).

    The first call with some arguments computes the result; later calls return the same object, so that callers must
    not modify it. The other arguments must be hashable. The cache is `mechanism.__dict__["_derived"]`: it lives as
    long as the mechanism, and a copy made by `dataclasses.replace` starts with an empty one. If the function raises
    an exception, nothing is cached.
    """
    name = f"{function.__module__}.{function.__qualname__}"

    @wraps(function)
    def cached(mechanism: Mechanism, /, *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        results: dict[Any, Any] = mechanism.__dict__.setdefault("_derived", {})
        key = (name, args, *kwargs.items())
        if key not in results:
            results[key] = function(mechanism, *args, **kwargs)
        found: Result = results[key]
        return found

    return cached
