"""Values of the command line that are used without a check by typer.

Typer checks each value, and each default, by adapters of pydantic: importing and building them takes longer than
a short motion takes to solve. A value that is not plain is left to typer; messages about wrong
numbers and words have the form of the library's.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from enum import Enum
from pathlib import Path
from typing import Any

import typer

UNCHECKED = object()
DIGITS = 9
"""Most digits of a number that is used without a check."""


def taking_plain_values(params: Iterable[Any]) -> list[Any]:
    """Return the parameters of a command; plain values are used without a check by typer."""
    return [_taking(param) for param in params]


def _taking(param: Any) -> Any:
    checked = param.process_value

    def process_value(ctx: Any, value: Any) -> Any:
        found = plain_value(param, value)
        if found is UNCHECKED:
            try:
                return checked(ctx, value)
            except typer.BadParameter as error:
                error.message = _expected(param, value, error.message)
                raise
        return param.callback(ctx, param, found) if param.callback else found

    if "process_value" not in vars(param):
        param.process_value = process_value
    return param


def plain_value(param: Any, value: Any) -> Any:
    """Return the value of a parameter in the type of its default (lists have texts), or UNCHECKED."""
    kind = type(param.default)
    if value is None:
        return UNCHECKED if param.required or param.multiple or param.nargs != 1 else None
    if type(value) is kind and value == param.default:
        return value
    if kind is list and isinstance(value, list | tuple) and all(_printable(one) for one in value):
        return list(value)
    return _from_text(param, kind, value) if _printable(value) else UNCHECKED


def _expected(param: Any, value: Any, message: str) -> str:
    """Return the message about a wrong value; that of typer if the value is neither a number nor a word."""
    kind = type(param.default)
    if issubclass(kind, Enum):
        return f"expected one of {', '.join(one.value for one in kind)}, got '{value}'"
    if not message.startswith("Input should be"):
        return message
    number = "a whole number" if kind is int or "integer" in message else "a number"
    low, high = getattr(param, "min", None), getattr(param, "max", None)
    if low is None:
        return f"expected {number}, got '{value}'"
    return f"expected {number} {f'of at least {low:g}' if high is None else f'from {low} to {high}'}, got '{value}'"


def _printable(value: Any) -> bool:
    return isinstance(value, str) and value.isprintable()


def _from_text(param: Any, kind: type[Any], text: str) -> Any:
    if kind is str:
        return text
    if issubclass(kind, Path) and (os.access(text, os.R_OK) or not os.path.lexists(text)):
        return kind(text)
    if kind is int and text.isascii() and text.isdigit() and len(text) <= DIGITS:
        low, high = getattr(param, "min", None), getattr(param, "max", None)
        if low is not None and low <= int(text) and (high is None or int(text) <= high):
            return int(text)
    return kind(text) if issubclass(kind, Enum) and text in {one.value for one in kind} else UNCHECKED
