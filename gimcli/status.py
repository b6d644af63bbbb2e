"""Numerical outcomes: what the user reads is the member's text."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """How the search for one position ended."""

    OK = 0
    LIMIT = 1
    NOT_ASSEMBLED = 2
    NOT_CONVERGED = 3
    SINGULAR = 4
    CONTRADICTORY = 5
    JUMPED = 6
    STALLED = 7
    CYCLING = 8
    DIVERGED = 9

    @property
    def word(self) -> str:
        """The one word that stands in a CSV."""
        return _WORDS[self]

    @property
    def text(self) -> str:
        """A sentence with the cure."""
        return _TEXTS[self]

    @property
    def plain_text(self) -> str:
        """The same for commands that have neither --tolerance nor the methods of positions."""
        return _PLAIN.get(self, self.text)


_WORDS = {
    Status.OK: "ok",
    Status.LIMIT: "unreachable",
    Status.NOT_ASSEMBLED: "not-assembled",
    Status.NOT_CONVERGED: "not-converged",
    Status.SINGULAR: "singular",
    Status.CONTRADICTORY: "contradictory",
    Status.JUMPED: "other-configuration",
    Status.STALLED: "stalled",
    Status.CYCLING: "cycling",
    Status.DIVERGED: "diverged",
}

_TEXTS = {
    Status.OK: "solved to the tolerance",
    Status.LIMIT: "the mechanism cannot reach this input from its start: shorten the law to the reachable interval",
    Status.NOT_ASSEMBLED: "no position was found that satisfies all constraints: check the lengths named, draw the"
    " start nearer to an assembled position (`gim solve --all` lists all configurations, `gim solve --start random`"
    " looks for one from anywhere), or see by `gim trace` how far the inputs reach",
    Status.NOT_CONVERGED: "the iteration did not reach the tolerance: loosen --tolerance, or use --method auto"
    " where the position exists",
    Status.SINGULAR: "the position is singular: the inputs do not determine it to the requested tolerance; start from"
    " another position (the drawing, or the start of the law), or loosen --tolerance",
    Status.JUMPED: "the iteration settled in another configuration than the continuous motion: take more steps or use"
    " --method auto",
    Status.STALLED: "the sweeps hardly move the nodes any more, above the tolerance: the position is singular or out of"
    " reach, or the sequence converges too slowly; use --strategy spectral, take more steps, or use --method auto",
    Status.CYCLING: "the sweeps go in a circle above the tolerance: draw the start elsewhere (not in line), choose"
    " another --strategy, or use --method auto",
    Status.DIVERGED: "the sweeps lead away beyond all numbers: use --strategy spectral, take more steps, or use"
    " --method auto",
    Status.CONTRADICTORY: "a surplus constraint contradicts the others: correct its dimension or remove it",
}

_PLAIN = {
    Status.NOT_CONVERGED: "the iteration did not reach the tolerance: start from another position",
    Status.SINGULAR: "the position is singular: the inputs do not determine it, or the motion from there is not unique;"
    " start from another position (the drawing, the start of the law, or `start:`)",
}
