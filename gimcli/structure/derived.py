"""What is derived from a mechanism, found once and kept with it."""

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
    """Keep the result of a function of a mechanism with the mechanism: it is shared and must not be changed."""
    name = f"{function.__module__}.{function.__qualname__}"

    @wraps(function)
    def kept(mechanism: Mechanism, /, *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        results: dict[Any, Any] = mechanism.__dict__.setdefault("_derived", {})
        key = (name, args, *kwargs.items())
        if key not in results:
            results[key] = function(mechanism, *args, **kwargs)
        found: Result = results[key]
        return found

    return kept
