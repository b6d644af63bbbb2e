"""Types of four-bar linkages by Grashof's rule: which links make full turns.

s and l are the shortest and the longest length, p and q the two others. If s + l < p + q, the shortest link makes full
turns relative to all others; if s + l > p + q, no link does; if they are equal, all links can be in line (change
point). Sources: Grashof 1883; Barker, A complete classification of planar four-bar linkages, Mech. Mach. Theory 20
(1985) 535-554, for the codes; Norton, Design of Machinery, section 2.12 and table 2-4.
"""

from __future__ import annotations

from dataclasses import dataclass

EQUAL = 1e-9
"""Lengths, and sums of lengths, that differ by less than this part of the perimeter are equal."""

NEAR = 1e-3
"""A linkage is near a change point if s + l - p - q is less than this part of the perimeter."""

FRAME, INPUT, COUPLER, OUTPUT = range(4)

GRASHOF = {
    FRAME: ("double-crank (drag link)", "GCCC"), INPUT: ("crank-rocker", "GCRR"),
    COUPLER: ("double-rocker", "GRCR"), OUTPUT: ("crank-rocker driven at the rocker", "GRRC"),
}  # fmt: skip
CHANGE = {FRAME: "SCCC", INPUT: "SCRR", COUPLER: "SRCR", OUTPUT: "SRRC"}


@dataclass(frozen=True)
class FourBar:
    """The lengths of frame, input, coupler and output link, in this order."""

    lengths: tuple[float, float, float, float]
    crossed: bool = False  # whether the coupler crosses the frame, which distinguishes antiparallelograms

    @property
    def excess(self) -> float:
        """Return p + q - s - l: positive for Grashof linkages, 0 at a change point."""
        s, p, q, longest = sorted(self.lengths)
        return p + q - s - longest if abs(p + q - s - longest) > EQUAL * sum(self.lengths) else 0.0

    @property
    def grashof(self) -> bool:
        """Whether at least one link can make full turns: s + l <= p + q."""
        return self.excess >= 0.0

    @property
    def near_change_point(self) -> bool:
        """Whether a small change of the lengths gives a linkage with change points."""
        return 0.0 < abs(self.excess) < NEAR * sum(self.lengths)

    @property
    def kind(self) -> str:
        """The type in words."""
        return self._named[0]

    @property
    def code(self) -> str:
        """Barker's code."""
        return self._named[1]

    @property
    def _named(self) -> tuple[str, str]:
        """The type in words, and its code."""
        place, (frame, first, coupler, second) = self.lengths.index, self.lengths
        if self.excess < 0.0:
            longest, loose = (
                max(self.lengths),
                "cannot be assembled, the longest link is longer than the others together",
            )
            fits = 2.0 * longest <= sum(self.lengths) * (1.0 + EQUAL)
            return "triple-rocker (not Grashof)" if fits else loose, f"RRR{place(longest) + 1}"
        shortest = place(min(self.lengths))
        if self.excess > 0.0:
            return GRASHOF[shortest]
        if self._same(*self.lengths):
            return "rhombus (change points)", "S3X"
        if self._same(frame, coupler) and self._same(first, second):
            return "antiparallelogram (change points)" if self.crossed else "parallelogram (change points)", "S2X"
        pairs = ((frame, first), (coupler, second)), ((first, coupler), (second, frame))
        if any(self._same(*one) and self._same(*other) for one, other in pairs):
            return "kite (change points)", "S2X"
        return "linkage with change points", CHANGE[shortest]

    def _same(self, *lengths: float) -> bool:
        return max(lengths) - min(lengths) <= EQUAL * sum(self.lengths)
