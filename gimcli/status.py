"""Status of a solved position, with the message that the user reads."""

from __future__ import annotations

from enum import IntEnum

CHANGE, TANGENCY = "change point", "tangency"
"""Kinds of a singular position: branches cross, or there is one curve only, whose constraints lose rank."""


class Status(IntEnum):
    """Outcome of the solution of one position."""

    OK = 0
    TANGENT = 1
    LIMIT = 2
    NOT_ASSEMBLED = 3
    NOT_CONVERGED = 4
    SINGULAR = 5
    CONTRADICTORY = 6
    JUMPED = 7
    STALLED = 8
    CYCLING = 9
    DIVERGED = 10
    JAMMED = 11
    WORK_LIMIT = 12
    SEVERAL_SOLUTIONS = 13
    NO_SOLUTION = 14

    @property
    def solved(self) -> bool:
        """Whether the position is solved."""
        return self <= Status.TANGENT

    @property
    def word(self) -> str:
        """The status word in CSV files and reports."""
        return _WORDS[self]

    @property
    def text(self) -> str:
        """A message with the correction."""
        return _TEXTS[self]

    @property
    def plain_text(self) -> str:
        """The message where there is no choice of tolerance and method."""
        return _PLAIN.get(self, self.text)


_WORDS = {
    Status.OK: "ok",
    Status.TANGENT: "tangent",
    Status.LIMIT: "unreachable",
    Status.NOT_ASSEMBLED: "not-assembled",
    Status.NOT_CONVERGED: "not-converged",
    Status.SINGULAR: "singular",
    Status.CONTRADICTORY: "contradictory",
    Status.JUMPED: "other-configuration",
    Status.STALLED: "stalled",
    Status.CYCLING: "cycling",
    Status.DIVERGED: "diverged",
    Status.JAMMED: "jammed",
    Status.WORK_LIMIT: "work-limit",
    Status.SEVERAL_SOLUTIONS: "several-solutions",
    Status.NO_SOLUTION: "no-solution",
}

_TEXTS = {
    Status.OK: "solved to the tolerance",
    Status.TANGENT: "solved, but tangent, as every position near it: an error e of a length moves the nodes by about"
    " the square root of e (1e-8 for rounding errors), and there are no velocities; change a length if this is not"
    " meant",
    Status.LIMIT: "the motion from the start to these inputs ends at a limit: shorten the law to the"
    " reachable interval, or let the input turn back there (`gim trace --at-limit reverse`)",
    Status.NOT_ASSEMBLED: "no position was found that satisfies all constraints: correct the lengths in `links` and"
    " `elements`, use initial coordinates closer to an assembled position, or change the inputs",
    Status.NOT_CONVERGED: "the iteration did not reach the tolerance: loosen the tolerance or use the method auto",
    Status.SINGULAR: "the position is singular: the inputs do not determine it to the requested tolerance; start from"
    " another position (the initial configuration, or the start of the law), or loosen the tolerance",
    Status.JUMPED: "the iteration converged to another configuration than that of the continuous motion: use more steps"
    " or the method auto",
    Status.STALLED: "the sweeps stagnate before they reach the tolerance: the position is singular or unreachable, or"
    " the sequence converges too slowly; use the strategy spectral, more steps, or the method auto",
    Status.CYCLING: "the sweeps repeat a cycle and do not reach the tolerance: change the initial coordinates (avoid"
    " nodes in line), choose another strategy, or use the method auto",
    Status.DIVERGED: "the iterates diverged: use the strategy spectral, more steps, or the method auto",
    Status.JAMMED: "dry friction jams the mechanism: no forces continue the motion, or several do; use a smaller `mu`,"
    " a longer guide or smaller pins, or other loads",
    Status.CONTRADICTORY: "a redundant constraint contradicts the others: correct its dimension or remove it",
    Status.WORK_LIMIT: "the computation ended at its bound on work; what was found until then is reported",
    Status.SEVERAL_SOLUTIONS: "jamming: dry friction allows several forces for the same motion; use a smaller mu, a"
    " longer guide or smaller pins",
    Status.NO_SOLUTION: "jamming: no forces were found with which the mechanism slides in this direction,"
    " however large the effort; use a smaller mu, a longer guide or smaller pins, or drive another member",
}

_PLAIN = {
    Status.NOT_CONVERGED: "the iteration did not reach the tolerance: start from another position",
    Status.SINGULAR: "the position is singular: the inputs do not determine it, or the motion from there is not unique;"
    " start from another position (the initial configuration, the start of the law, or `start:`), or"
    " give masses to the members that a free input moves",
}
