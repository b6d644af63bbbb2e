"""The user's options for the solution of positions."""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.errors import UsageError

METHODS = ("auto", "gim", "newton")
STRATEGIES = ("spectral", "classic")
JIT = ("auto", "on", "off")

TOLERANCE = 1e-10
"""Usual largest error of a constraint, relative to the size."""


@dataclass(frozen=True)
class Options:
    """Method and tolerance; the tolerance is relative to the mechanism's size (gim: errors of eqs (1) and (2))."""

    method: str = "auto"
    strategy: str = "spectral"
    tolerance: float = TOLERANCE
    jit: str = "auto"
    sweeps: int = 20000  # greatest number for one position
    seed: int | None = None  # of random initial coordinates; None: start from the file's coordinates
    moves: str = ""  # a sequence given by the user, "A>B C>B ..."; "": search for one

    def __post_init__(self) -> None:
        if self.moves and self.method != "gim":
            raise UsageError("sequence: needs method gim")
