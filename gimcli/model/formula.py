"""Arithmetic in place of a number of the model file, such as `2*a + 3` with the parameter `a`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gimcli.language.expression import CONSTANTS, FUNCTIONS, Expression, ExpressionError, PartKind
from gimcli.language.reader import NAMED, SIGNED, WORD, ExpressionReader, KnownNames

WORDS = (*FUNCTIONS, *CONSTANTS)
"""Words that are no parameters."""


class UnknownNameError(ExpressionError):
    """A word in a formula of a model file that is not a parameter."""

    def __init__(self, word: str) -> None:
        super().__init__(f"'{word}' is not a parameter")
        self.word = word


class Parameters(KnownNames):
    """The parameters of a model file: words that stand for numbers."""

    def __init__(self, names: Mapping[str, Any]) -> None:
        self.names = names

    def longest(self, text: str) -> str:
        """Return the parameter with which a text begins; "" if it begins with none."""
        word = WORD.match(text)
        return word[0] if word is not None and word[0] in self.names and word[0] not in WORDS else ""

    def kind(self, name: str) -> PartKind:
        """Return that every parameter is a number."""
        return PartKind("number")

    def unknown(self, word: str, rest: str) -> Exception:
        """Return the error for a word that is not a parameter."""
        return UnknownNameError(found[0] if (found := WORD.match(word)) else word)


def is_name(word: str) -> bool:
    """Return whether a word can be the name of a parameter."""
    return WORD.fullmatch(word) is not None and word not in WORDS


def is_number(text: str) -> bool:
    """Return whether a text is a number, not a formula."""
    return SIGNED.fullmatch(text) is not None


def parsed(text: str, names: Mapping[str, Any]) -> Expression:
    """Return a formula of a model file with parameters among `names`; raise ExpressionError if it is none."""
    found = ExpressionReader(text, Parameters(names)).whole()
    if found.kind.what != "number":
        raise ExpressionError(f"expected a number, got {NAMED[found.kind.what]}")
    return found
