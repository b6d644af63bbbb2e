"""What the user decides about a solution."""

from __future__ import annotations

from dataclasses import dataclass

METHODS = ("auto", "gim", "newton")
STRATEGIES = ("spectral", "classic")
JIT = ("auto", "on", "off")


@dataclass(frozen=True)
class Options:
    """Method and tolerance; the tolerance is relative to the mechanism's size (gim: eqs (1) and (2))."""

    method: str = "auto"
    strategy: str = "spectral"
    tolerance: float = 1e-10
    jit: str = "auto"
    sweeps: int = 20000  # at the most, for one position
    seed: int | None = None  # random start
    moves: str = ""  # a sequence given by the user, "A>B C>B ..."; "" searches one
