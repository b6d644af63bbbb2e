"""Outcome of the equations with dry friction in a row, with the message that the user reads."""

from __future__ import annotations

from enum import IntEnum


class FrictionStatus(IntEnum):
    """What dry friction leaves of the forces in one row; a later one prevails."""

    SLIDING = 0
    STANDSTILL = 1
    SEVERAL = 2
    NO_SOLUTION = 3
    NOT_CONVERGED = 4

    @property
    def word(self) -> str:
        """The word in the status column."""
        return _WORDS[self]

    @property
    def text(self) -> str:
        """A message with the correction."""
        return _TEXTS[self]


SELF_LOCKING = "self-locking"
"""Word in the column `friction.state` for a row in which friction holds the mechanism against its loads."""

_WORDS = {
    FrictionStatus.SLIDING: "sliding",
    FrictionStatus.STANDSTILL: "standstill",
    FrictionStatus.SEVERAL: "several-solutions",
    FrictionStatus.NO_SOLUTION: "no-solution",
    FrictionStatus.NOT_CONVERGED: "not-converged",
}

_TEXTS = {
    FrictionStatus.SLIDING: "all pairs with dry friction slide",
    FrictionStatus.STANDSTILL: "a pair with dry friction does not slide there, so its friction is not determined;"
    " forces that depend on it are empty, INPUT.effort.least and .greatest are limits of the effort; with another"
    " number of steps the rows are elsewhere",
    FrictionStatus.SEVERAL: "jamming: dry friction allows several forces for the same motion; use a smaller mu, a"
    " longer guide or smaller pins",
    FrictionStatus.NO_SOLUTION: "jamming: no forces were found with which the mechanism slides in this direction,"
    " however large the effort; use a smaller mu, a longer guide or smaller pins, or drive another member",
    FrictionStatus.NOT_CONVERGED: "the iteration for dry friction did not converge: use another number of steps",
}
