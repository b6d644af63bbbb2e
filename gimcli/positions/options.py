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
        for name, known in (("method", METHODS), ("strategy", STRATEGIES), ("jit", JIT)):
            if getattr(self, name) not in known:
                raise UsageError(f"{name}: expected one of {', '.join(known)}, got '{getattr(self, name)}'")

    @classmethod
    def checked(
        cls, method: str, strategy: str, tolerance: float, jit: str, moves: str = "", seed: int | None = None
    ) -> Options:
        """Return the options; raises UsageError for a tolerance out of range, or a sequence without method gim."""
        if not 1e-14 <= tolerance < 1.0:
            raise UsageError(f"tolerance: expected a number from 1e-14 to below 1, got {tolerance:g}")
        if moves and method != "gim":
            raise UsageError("sequence: needs method gim")
        return cls(method, strategy, tolerance, jit, seed=seed, moves=moves)
